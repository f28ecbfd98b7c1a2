// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

#include "bake/file/runtime_metadata.h"
#include "bake/file/vdb.h"
#include "bake/report/error.h"
#include "photic/runtime_vdb.h"
#include "runtime/src/guarded.h"
#include "runtime/src/metadata_json.h"
#include "runtime/src/volume_builder.h"

namespace photic::runtime {
namespace {

constexpr std::size_t kVoxels = VolumeData::kVoxels;

VoxelTransform transformOf(const GridFrame& frame) {
    VoxelTransform out;
    const glm::dmat3& inverse = frame.indexFromWorld();
    for (std::size_t row = 0; row < 3; ++row) {
        const auto r = static_cast<int>(row);
        out.origin_world[row] = frame.origin_world[r];
        for (std::size_t column = 0; column < 3; ++column) {
            const auto c = static_cast<int>(column);
            out.world_from_index[3 * row + column] = frame.worldFromIndex()[c][r];  // GLM counts columns first
            out.index_from_world[3 * row + column] = inverse[c][r];
        }
    }
    return out;
}

Int3 originOf(const LightField& field, int slot) {
    const glm::ivec3 origin = field.needed().leafOrigin(slot);
    return {origin.x, origin.y, origin.z};
}

/// Channel `channel` of a leaf's voxel `offset`, in the baker's order; 0 where the voxel is not needed.
float valueOf(const LightField& field, int slot, std::size_t channel, int offset) {
    if (!NeededVoxels::maskBit(field.needed().mask(slot), offset)) return 0;
    if (field.state(slot) == LeafState::Constant) return field.constant(slot)[channel];
    return field.dense(slot)[channel * kVoxels + static_cast<std::size_t>(offset)];
}

/// One lobe of a volume.
Volume lobeOf(const LightVolume& from, const LightField& field, const Volume& second, const LoadOptions& options) {
    const auto colours = static_cast<std::size_t>(field.channels().irradiance);
    const bool coloured = colours == 3, directed = from.has_direction && field.channels().flux;
    VolumeBuilder builder(transformOf(field.frame()), options.largest_memory);
    builder.setMetadata(readMetadata(runtimeMetadata(from).dump()));
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        if (field.state(slot) != LeafState::Empty) builder.addBrick(originOf(field, slot));
    }
    builder.allocate(coloured);
    if (directed) builder.beginChannels(Channels::FluxAndIrradiance);
    const auto scale = static_cast<float>(1 / from.reference_irradiance);
    std::vector<float> light(4 * kVoxels), rgb(3 * kVoxels);
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        if (field.state(slot) == LeafState::Empty) continue;
        for (int offset = 0; offset < static_cast<int>(kVoxels); ++offset) {
            const int x = offset >> 6, y = offset >> 3 & 7, z = offset & 7;
            const auto voxel = static_cast<std::size_t>(x + 8 * y + 64 * z);
            float sum = 0;
            for (std::size_t c = 0; c < colours; ++c) {
                const float value = scale * valueOf(field, slot, c, offset);
                if (coloured) rgb[3 * voxel + c] = value;
                sum += value;
            }
            for (std::size_t c = 0; c < 3; ++c) {
                light[4 * voxel + c] = directed ? scale * valueOf(field, slot, colours + c, offset) : 0;
            }
            light[4 * voxel + 3] = sum / static_cast<float>(colours);
        }
        builder.setBrick(originOf(field, slot), Channels::FluxAndIrradiance, light.data());
        if (coloured) builder.setBrick(originOf(field, slot), Channels::Rgb, rgb.data());
    }
    builder.setSecondLobe(second);
    return builder.finish();
}

Volume volumeOf(const LightVolume& from, const LoadOptions& options) {
    return lobeOf(from, from.field, from.second ? lobeOf(from, *from.second, Volume(), options) : Volume(), options);
}

}  // namespace

Result<Volume> loadVdb(const std::string& path, const LoadOptions& options) {
    return guarded([&]() -> Result<Volume> {
        try {
            return volumeOf(readVdb(path), options);
        } catch (const photic::Error& error) {
            return Error{ErrorCode::File, error.what()};
        }
    });
}

}  // namespace photic::runtime
