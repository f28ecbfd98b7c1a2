// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "photic/bent_rays.h"
#include "runtime/src/index_atlas.h"

namespace photic::runtime {

/// As photic_bent.glsl has them, std140; docs/index_volumes.md says it in words.
struct BentObjectBlock {
    float rows[3][4], box_low[4], box_high[4], scattering[4], coat[4];
    std::int32_t count[4], corner[4], block[4];
};
struct BentBlock {
    float origin[4];
    std::int32_t counts[4];
    float march[4], texel[4], ambient[9][4];
    BentObjectBlock objects[BentRayPass::kMostObjects];
    std::int32_t shapes[BentRayPass::kMostObjects][4];
};
static_assert(sizeof(BentObjectBlock) == 160 && sizeof(BentBlock) == 208 + 16 * (160 + 16));

/// The objects of an atlas, for their places in the world.
struct IndexObjects {
    struct Object {
        VoxelTransform transform;
        Double3 box_low, box_high;
        Int3 count;
        IndexAtlas::Place place;
        std::array<float, 3> scattering;
        float anisotropy = 0;
        std::array<float, 3> albedo;  ///< of faces
        float roughness = 0;
        bool reflects = false, matte = false, sharp = false, scatters = false, disperses = false;
        int shape = -1;  ///< place of its shape's texels; -1: none
        int rank = 0;
        int shape_flags = 0;  ///< 1 with samples; 16 times what its faces do; 256 times its kind
    };
    std::vector<Object> objects;
    Int3 texels{1, 1, 1};  ///< of the atlas

    IndexObjects() = default;
    IndexObjects(const std::vector<IndexVolume>& volumes, const IndexAtlas& atlas, const std::vector<int>& shapes);
    /// Some of those that are placed have a shape.
    bool haveShapes(const std::vector<PlacedObject>& placed) const;
};

/// @throws Failure{Usage} for what makes no sense
BentBlock bentBlock(const IndexObjects& objects, const std::vector<PlacedObject>& placed, const Double3& origin,
                    const BentRayOptions& options, const Surroundings& surroundings);

/// What matte faces see of the surroundings: irradiance over pi as a polynomial of the direction that a face looks in.
void layAmbient(const Surroundings& around, BentBlock& block);

}  // namespace photic::runtime
