// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/methods/wave.h"

namespace photic {

/// What a bake by waves takes: by the cells of the box, whose number the band's steps grow with.
MethodCost waveCost(const CostQuestion& question, const WaveOptions& options);

}  // namespace photic
