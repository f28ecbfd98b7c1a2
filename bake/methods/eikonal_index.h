// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/methods/eikonal_front.h"

namespace photic {

/// First arrival close below the surface through an index that varies [m of optical path]: the least over feet y of
/// T_incoming(y) + the time from y to `place`.
///
/// That time is Simpson's mean of n along the straight line times its length r, less r^3 |grad n across|^2 / (24 n) for
/// the ray that bends (the second variation of Fermat's integral); right to fourth order in r. The foot by Newton's
/// method.
/// @param foot  to start from
double arrivalThroughIndex(const EikonalFront& front, const glm::dvec3& place, glm::dvec2 foot);

}  // namespace photic
