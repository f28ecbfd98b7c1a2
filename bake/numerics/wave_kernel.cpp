// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/wave_kernel.h"

#include <cstdlib>
#include <string_view>

namespace photic {

namespace portable {
extern const WaveKernels kWaveKernels;
}
#ifdef PHOTIC_X86_KERNELS
namespace avx2 {
extern const WaveKernels kWaveKernels;
}
namespace avx512 {
extern const WaveKernels kWaveKernels;
}
#endif

int waveKernelCount() {
#ifdef PHOTIC_X86_KERNELS
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return 1;
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                   __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw")
               ? 3
               : 2;
#else
    return 1;
#endif
}

const WaveKernels& waveKernels(int index) {
#ifdef PHOTIC_X86_KERNELS
    if (index == 2) return avx512::kWaveKernels;
    if (index == 1) return avx2::kWaveKernels;
#endif
    (void)index;
    return portable::kWaveKernels;
}

const WaveKernels& waveKernels() {
    int best = waveKernelCount() - 1;
    if (const char* wanted = std::getenv("PHOTIC_INSTRUCTION_SET")) {
        while (best > 0 && std::string_view(wanted) != waveKernels(best).name) --best;
    }
    return waveKernels(best);
}

}  // namespace photic
