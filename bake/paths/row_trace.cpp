// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/row_trace.h"

#include "bake/simd/dispatch.h"

namespace photic {

PHOTIC_PER_SET(RowTracer rowTracerHere())

RowTracer rowTracer(InstructionSet set) { return PHOTIC_CHOOSE(set, rowTracerHere)(); }

void RayRow::resize(std::size_t count) {
    if (x.size() == count) return;
    for (auto* a :
         {&x, &y, &z, &dx, &dy, &dz, &u, &v, &w, &du, &dv, &per_layer, &fraction, &untraced, &hit_distance, &w_end})
        a->resize(count);
}

}  // namespace photic
