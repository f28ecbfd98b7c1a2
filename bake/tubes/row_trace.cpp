// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/row_trace.h"

namespace photic {

void RayRow::resize(std::size_t count) {
    if (x.size() == count) return;
    for (auto* a :
         {&x, &y, &z, &dx, &dy, &dz, &u, &v, &w, &du, &dv, &per_layer, &fraction, &untraced, &hit_distance, &w_end})
        a->resize(count);
}

}  // namespace photic
