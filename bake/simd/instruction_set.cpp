// SPDX-License-Identifier: Apache-2.0
#include "bake/simd/instruction_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

#ifdef PHOTIC_X86_KERNELS
#include <cpuid.h>
#endif

#include "bake/report/error.h"

namespace photic {
namespace {

constexpr const char* kVariable = "PHOTIC_INSTRUCTION_SET";

InstructionSet setCalled(std::string_view wanted) {
    for (const InstructionSet set : {InstructionSet::Portable, InstructionSet::Avx2, InstructionSet::Avx512})
        if (wanted == name(set)) return set;
    throw Error(ErrorCode::Usage,
                fmt::format("'{}' is no instruction set; use portable, avx2 or avx512, or leave it unset for the best "
                            "that this processor has",
                            wanted),
                kVariable);
}

#ifdef PHOTIC_X86_KERNELS
// __builtin_cpu_supports() of Clang 14 knows no name for it.
bool halfFloatConversions() {
    unsigned a = 0, b = 0, c = 0, d = 0;
    return __get_cpuid(1, &a, &b, &c, &d) && (c & bit_F16C);
}
#endif

}  // namespace

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

std::vector<InstructionSet> instructionSets() {
    std::vector<InstructionSet> sets{InstructionSet::Portable};
#ifdef PHOTIC_X86_KERNELS
    // All that cmake/photic_kernels.cmake compiles for.
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma") || !halfFloatConversions()) return sets;
    sets.push_back(InstructionSet::Avx2);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bw"))
        sets.push_back(InstructionSet::Avx512);
#endif
    return sets;
}

InstructionSet bestInstructionSet() {
    const InstructionSet best = instructionSets().back();
    const char* wanted = std::getenv(kVariable);
    return wanted && *wanted ? std::min(best, setCalled(wanted)) : best;
}

int widestLanes(InstructionSet set) { return set == InstructionSet::Avx512 ? 16 : set == InstructionSet::Avx2 ? 8 : 4; }

}  // namespace photic
