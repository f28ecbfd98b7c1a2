// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/kept_shapes.h"

#include "bake/paths/scene_shapes.h"

namespace photic {

struct KeptShapes::Held {
    HeldShapes shapes;
};

KeptShapes::KeptShapes() : held_(std::make_unique<Held>()) {}
KeptShapes::~KeptShapes() = default;

}  // namespace photic
