// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "photic/movers.h"

namespace photic::runtime {

/// The uniform block photic_movers of photic_movers.glsl, by std140.
struct MoverParameters {
    float surface[4], sun[4], cone[4];
    std::int32_t count[4];
    float map_u[4], map_v[4], map_d[4];
    float range[4];
    float shapes[4 * Movers::kMostShapes][4];
};

/// @throws Failure{Usage}
MoverParameters moverParameters(const Movers& movers);

}  // namespace photic::runtime
