// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/march_kernel.h"

#include "bake/simd/dispatch.h"

namespace photic {

PHOTIC_PER_SET(void solveBlockHere(LocalBlock& block))

SolveBlock blockSolver() { return PHOTIC_CHOOSE(bestInstructionSet(), solveBlockHere); }

}  // namespace photic
