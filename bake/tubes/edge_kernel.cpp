// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/edge_kernel.h"

#include <cstdlib>
#include <string_view>

#include "bake/tubes/row_trace.h"

namespace photic {

namespace portable {
TileKernels kernelsFor(int lanes, int irradiance_channels, bool flux, TubeDensity density);
RowTracer rowTracerHere();
}  // namespace portable
#ifdef PHOTIC_X86_KERNELS
namespace avx2 {
TileKernels kernelsFor(int lanes, int irradiance_channels, bool flux, TubeDensity density);
RowTracer rowTracerHere();
}  // namespace avx2
namespace avx512 {
TileKernels kernelsFor(int lanes, int irradiance_channels, bool flux, TubeDensity density);
RowTracer rowTracerHere();
}  // namespace avx512
#endif

const char* name(InstructionSet set) {
    switch (set) {
        case InstructionSet::Avx512:
            return "avx512";
        case InstructionSet::Avx2:
            return "avx2";
        case InstructionSet::Portable:
            break;
    }
    return "portable";
}

InstructionSet bestInstructionSet() {
    InstructionSet best = InstructionSet::Portable;
#ifdef PHOTIC_X86_KERNELS
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) best = InstructionSet::Avx2;
    if (best == InstructionSet::Avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
        best = InstructionSet::Avx512;
#endif
    if (const char* wanted = std::getenv("PHOTIC_INSTRUCTION_SET")) {
        for (const InstructionSet set : {InstructionSet::Portable, InstructionSet::Avx2})
            if (std::string_view(wanted) == name(set) && set < best) best = set;
    }
    return best;
}

int widestLanes(InstructionSet set) { return set == InstructionSet::Avx512 ? 16 : set == InstructionSet::Avx2 ? 8 : 4; }

TileKernels tileKernels(InstructionSet set, int lanes, int irradiance_channels, bool flux, TubeDensity density) {
#ifdef PHOTIC_X86_KERNELS
    if (set == InstructionSet::Avx512) return avx512::kernelsFor(lanes, irradiance_channels, flux, density);
    if (set == InstructionSet::Avx2) return avx2::kernelsFor(lanes, irradiance_channels, flux, density);
#endif
    (void)set;
    return portable::kernelsFor(lanes, irradiance_channels, flux, density);
}

RowTracer rowTracer(InstructionSet set) {
#ifdef PHOTIC_X86_KERNELS
    if (set == InstructionSet::Avx512) return avx512::rowTracerHere();
    if (set == InstructionSet::Avx2) return avx2::rowTracerHere();
#endif
    (void)set;
    return portable::rowTracerHere();
}

}  // namespace photic
