// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/front_kernel.h"

#include "bake/simd/dispatch.h"

namespace photic {

PHOTIC_PER_SET(void marchFront(const FrontMarch&, FrontRays&, std::size_t, std::size_t, float*, std::size_t))

FrontKernel frontKernel() { return PHOTIC_CHOOSE(bestInstructionSet(), marchFront); }

void FrontRays::resize(std::size_t rays, bool attenuated, bool timed) {
    constexpr std::size_t kWidest = 16;
    count = rays;
    const std::size_t room = (rays + kWidest - 1) / kWidest * kWidest;
    for (auto* member : {&u, &v, &w, &pu, &pv, &lit}) member->resize(room, 0.0f);
    pw.resize(room, 1.0f);
    stopped.resize(room, -1);
    for (auto& channel : depth) channel.resize(attenuated ? room : 0, 0.0f);
    time.resize(timed ? room : 0, 0.0f);
}

}  // namespace photic
