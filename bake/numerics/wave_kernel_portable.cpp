// SPDX-License-Identifier: Apache-2.0
#define PHOTIC_ISA portable
#include "bake/numerics/wave_kernel_impl.h"
