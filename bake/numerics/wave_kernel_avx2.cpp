// SPDX-License-Identifier: Apache-2.0
#define PHOTIC_ISA avx2
#include "bake/numerics/wave_kernel_impl.h"
