// SPDX-License-Identifier: Apache-2.0
#define PHOTIC_ISA portable
#include "bake/numerics/march_kernel_impl.h"

namespace photic::portable {

void solveBlockHere(LocalBlock& block) { solveBlock(block); }

}  // namespace photic::portable
