// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "bake/file/vdb.h"

namespace photic::test {

/// What a voxel of a test volume holds: irradiance (1 or 3 channels), then flux x y z.
using VoxelValues = std::function<std::vector<double>(const glm::ivec3& voxel)>;

inline GridFrame cubicFrame(double voxel_size, const glm::ivec3& min, const glm::ivec3& max) {
    return {glm::dmat3(voxel_size), glm::dvec3(voxel_size / 2), min, max};
}

/// A volume whose needed voxels are all of `frame`, or those that `needs` accepts.
inline LightVolume makeVolume(const GridFrame& frame, int colours, const VoxelValues& values,
                              const std::function<bool(const glm::ivec3&)>& needs = {}) {
    NeededVoxels needed = NeededVoxels::none(frame);
    for (int x = frame.min.x; x <= frame.max.x; ++x) {
        for (int y = frame.min.y; y <= frame.max.y; ++y) {
            for (int z = frame.min.z; z <= frame.max.z; ++z) {
                if (!needs || needs({x, y, z})) needed.add({x, y, z});
            }
        }
    }
    needed.finish();
    LightField field(std::make_shared<const NeededVoxels>(std::move(needed)), FieldChannels{colours, true});
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        float* leaf = field.makeDense(slot);
        for (int offset = 0; offset < LightField::kLeafVoxels; ++offset) {
            if (!NeededVoxels::maskBit(field.needed().mask(slot), offset)) continue;
            const glm::ivec3 voxel =
                field.needed().leafOrigin(slot) + glm::ivec3(offset >> 6, offset >> 3 & 7, offset & 7);
            const auto v = values(voxel);
            for (std::size_t c = 0; c < v.size(); ++c)
                leaf[c * LightField::kLeafVoxels + static_cast<std::size_t>(offset)] = static_cast<float>(v[c]);
        }
    }
    return LightVolume{std::move(field), 1.0, true, true, {}, {}};
}

}  // namespace photic::test
