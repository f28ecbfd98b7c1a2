// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/foot_kernel.h"

#include "bake/simd/dispatch.h"

namespace photic {

PHOTIC_PER_SET(FootKernels footKernelsHere())

FootKernels footKernels() { return PHOTIC_CHOOSE(bestInstructionSet(), footKernelsHere)(); }

}  // namespace photic
