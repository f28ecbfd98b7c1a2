// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/kept_light.h"

#include <algorithm>

#include "bake/deposit/kept_tiles.h"
#include "bake/field/light_field.h"

namespace photic {

struct KeptLight::Tiles {
    KeptTiles tiles;
};

KeptLight::KeptLight() : tiles_(std::make_unique<Tiles>()) {}
KeptLight::~KeptLight() = default;

void KeptLight::clear() { tiles_->tiles.clear(); }
std::int64_t KeptLight::bytes() const { return tiles_->tiles.bytes(); }

KeptLight::Lent::Lent(KeptLight* kept, const NeededVoxels& needed, int channels, std::int64_t most_bytes)
    : kept_(kept) {
    if (!kept_) return;
    // Each light, and each direction of a disc that is sampled, lays tiles of its own: of many, few are kept.
    const std::int64_t field = std::int64_t{needed.leafCount()} * LightField::kLeafVoxels *
                               static_cast<std::int64_t>(sizeof(float)) * channels;
    KeptTiles& tiles = kept_->tiles_->tiles;
    tiles.begin(keyOf(needed), std::clamp<std::int64_t>(most_bytes, 0, 2 * field));
    KeptTiles::use(&tiles);
}

KeptLight::Lent::~Lent() {
    if (!kept_) return;
    KeptTiles::use(nullptr);
    kept_->tiles_->tiles.end();
}

}  // namespace photic
