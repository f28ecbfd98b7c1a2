// SPDX-License-Identifier: Apache-2.0
// How a kernel is declared once and chosen when the program runs. The file that cmake/photic_kernels.cmake compiles
// per instruction set defines it:
//
//     namespace photic::PHOTIC_ISA {                    // in sum_per_set.cpp
//     float sumOf(const float* from, int count) { ... }
//     }
//
//     PHOTIC_PER_SET(float sumOf(const float* from, int count))           // where it is called
//     const auto sum = PHOTIC_CHOOSE(bestInstructionSet(), sumOf);
#pragma once

#include "bake/simd/instruction_set.h"

/// At namespace photic: declares a function or a constant for every instruction set of this build.
/// PHOTIC_CHOOSE: what is called `name` in the namespace of `set`; on a build without it, the portable one.
#ifdef PHOTIC_X86_KERNELS
#define PHOTIC_PER_SET(...) \
    namespace portable {    \
    __VA_ARGS__;            \
    }                       \
    namespace avx2 {        \
    __VA_ARGS__;            \
    }                       \
    namespace avx512 {      \
    __VA_ARGS__;            \
    }
#define PHOTIC_CHOOSE(set, name)                              \
    ((set) == ::photic::InstructionSet::Avx512 ? avx512::name \
     : (set) == ::photic::InstructionSet::Avx2 ? avx2::name   \
                                               : portable::name)
#else
#define PHOTIC_PER_SET(...) \
    namespace portable {    \
    __VA_ARGS__;            \
    }
#define PHOTIC_CHOOSE(set, name) ((void)(set), portable::name)
#endif
