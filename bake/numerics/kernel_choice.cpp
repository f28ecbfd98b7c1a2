// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/kernel_choice.h"

#include <cstdlib>
#include <string_view>

#include "bake/numerics/foot_kernel.h"
#include "bake/numerics/march_kernel.h"

namespace photic {

#define PHOTIC_KERNELS_OF(isa)              \
    namespace isa {                         \
    void solveBlockHere(LocalBlock& block); \
    FootKernels footKernelsHere();          \
    }
PHOTIC_KERNELS_OF(portable)
#ifdef PHOTIC_X86_KERNELS
PHOTIC_KERNELS_OF(avx2)
PHOTIC_KERNELS_OF(avx512)
#endif

KernelChoice widestKernel() {
#ifdef PHOTIC_X86_KERNELS
    const char* wanted = std::getenv("PHOTIC_INSTRUCTION_SET");
    const std::string_view most = wanted ? wanted : "";
    if (most == "portable" || !__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma"))
        return KernelChoice::Portable;
    if (most != "avx2" && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
        return KernelChoice::Avx512;
    return KernelChoice::Avx2;
#else
    return KernelChoice::Portable;
#endif
}

SolveBlock blockSolver() {
#ifdef PHOTIC_X86_KERNELS
    if (widestKernel() == KernelChoice::Avx512) return avx512::solveBlockHere;
    if (widestKernel() == KernelChoice::Avx2) return avx2::solveBlockHere;
#endif
    return portable::solveBlockHere;
}

FootKernels footKernels() {
#ifdef PHOTIC_X86_KERNELS
    if (widestKernel() == KernelChoice::Avx512) return avx512::footKernelsHere();
    if (widestKernel() == KernelChoice::Avx2) return avx2::footKernelsHere();
#endif
    return portable::footKernelsHere();
}

}  // namespace photic
