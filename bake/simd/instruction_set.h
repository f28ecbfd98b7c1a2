// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace photic {

/// Which vector instructions a kernel is built for, from the narrowest registers to the widest.
enum class InstructionSet { Portable, Avx2, Avx512 };

/// "portable", "avx2", "avx512".
const char* name(InstructionSet set);

/// The sets that this processor and this build have, Portable first.
std::vector<InstructionSet> instructionSets();

/// The best of these. PHOTIC_INSTRUCTION_SET=portable|avx2|avx512 in the environment lowers it: the same results as on
/// a processor that has no more. Empty counts as not set.
/// @throws Error{Usage} if the environment names another
InstructionSet bestInstructionSet();

/// How many floats a register of the set holds: 4, 8 or 16.
int widestLanes(InstructionSet set);

}  // namespace photic
