// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/eikonal_front.h"
#include "bake/report/error.h"

namespace photic {

void bakeByMarching(const Scene& scene, const EikonalFront&, const EikonalOptions&, EikonalFields&, BakeReport&, Monitor&) {
    throw Error(ErrorCode::Input, "marching is on its way", scene.file);
}

}  // namespace photic
