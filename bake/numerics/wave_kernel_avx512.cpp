// SPDX-License-Identifier: Apache-2.0
#define PHOTIC_ISA avx512
#include "bake/numerics/wave_kernel_impl.h"
