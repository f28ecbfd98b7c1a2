// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace photic {

enum class KernelChoice { Portable, Avx2, Avx512 };

/// The widest instruction set that this processor has; PHOTIC_INSTRUCTION_SET=portable|avx2 asks for less.
KernelChoice widestKernel();

}  // namespace photic
