// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <new>
#include <utility>

#include "bake/file/active_leaves.h"
#include "bake/file/checked_file.h"
#include "bake/file/grid_writer.h"
#include "bake/file/output_set.h"
#include "bake/file/vdb.h"
#include "bake/file/voxel_encoding.h"
#include "bake/report/error.h"
#include "bake/volume/pack.h"
#include "bake/volume/vdb_layout.h"
#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

constexpr int kVoxels = LightField::kLeafVoxels;

/// Writes the 512 values of a leaf, a voxel's components side by side; what they are where the leaf is not active does
/// not matter. Called from several threads.
using LeafValues = std::function<void(const ActiveLeaf&, float* values)>;

/// One channel of a leaf that is not Empty: 512 values, `constant` where it has but one.
const float* channelOf(const LightField& field, int slot, int channel, std::array<float, kVoxels>& constant) {
    const auto c = static_cast<std::size_t>(channel);
    if (field.state(slot) == LeafState::Dense) return field.dense(slot) + c * kVoxels;
    constant.fill(field.constant(slot)[c]);
    return constant.data();
}

bool isLit(const LightField& field, int slot) { return slot >= 0 && field.state(slot) != LeafState::Empty; }

LeafValues irradianceValues(const LightField& field, double reference, std::atomic<std::int64_t>& clamped) {
    return [&field, reference, &clamped](const ActiveLeaf& leaf, float* values) {
        const auto scale = static_cast<float>(1 / reference);
        const int colours = field.channels().irradiance;
        if (!isLit(field, leaf.slot)) {
            std::fill_n(values, kVoxels * colours, 0.0f);
            return;
        }
        std::int64_t cut = 0;
        std::array<float, kVoxels> constant;
        for (int c = 0; c < colours; ++c) {
            const float* from = channelOf(field, leaf.slot, c, constant);
            for (int i = 0; i < kVoxels; ++i) values[i * colours + c] = cutToRange(from[i] * scale, cut);
        }
        if (cut > 0) clamped += cut;
    };
}

LeafValues directionValues(const LightField& field, bool half) {
    return [&field, half](const ActiveLeaf& leaf, float* values) {
        if (!isLit(field, leaf.slot)) {
            std::fill_n(values, kVoxels * 3, 0.0f);
            return;
        }
        const bool dense = field.state(leaf.slot) == LeafState::Dense;
        const int f = field.channels().irradiance;
        std::array<float, kVoxels> mean, dx, dy, dz;
        meanIrradiance(field, leaf.slot, mean.data());
        const float* flux = dense ? field.dense(leaf.slot) + f * kVoxels : field.constant(leaf.slot).data() + f;
        const int next = dense ? kVoxels : 1;
        encodeDirections(mean.data(), flux, flux + next, flux + 2 * next, next, half, dx.data(), dy.data(), dz.data());
        for (std::size_t i = 0; i < kVoxels; ++i) {
            const std::size_t from = dense ? i : 0;
            values[3 * i] = dx[from], values[3 * i + 1] = dy[from], values[3 * i + 2] = dz[from];
        }
    };
}

LeafValues scalarValues(const LightField& field, std::atomic<std::int64_t>& clamped) {
    return [&field, &clamped](const ActiveLeaf& leaf, float* values) {
        const int slot = field.needed().slotOf(leaf.origin);
        if (!isLit(field, slot)) {
            std::fill_n(values, kVoxels, 0.0f);
            return;
        }
        std::int64_t cut = 0;
        std::array<float, kVoxels> constant;
        const float* from = channelOf(field, slot, 0, constant);
        const auto& needed = field.needed().mask(slot);
        for (int i = 0; i < kVoxels; ++i)
            values[i] = NeededVoxels::maskBit(needed, i) ? cutToRange(from[i], cut) : 0.0f;
        if (cut > 0) clamped += cut;
    };
}

std::uint32_t compressionFlags(Compression compression) {
    switch (compression) {
        case Compression::None:
            return 0;
        case Compression::Blosc:
            return kPackedBlosc | kPackedActive;
        case Compression::Zip:
            return kPackedZip | kPackedActive;
        case Compression::Mask:
            break;
    }
    return kPackedActive;
}

/// The leaves of a file, and those of them where the second lobe has light.
struct FileLeaves {
    std::vector<ActiveLeaf> all, second;
    std::vector<VdbTopology> all_places, second_places;
};

std::vector<VdbTopology> placesOf(const std::vector<ActiveLeaf>& leaves) {
    std::vector<VdbTopology> places;
    places.reserve(leaves.size());
    for (const ActiveLeaf& leaf : leaves) places.push_back({leaf.origin, leaf.mask});
    return places;
}

FileLeaves leavesOf(const LightVolume& volume) {
    FileLeaves leaves{activeLeaves(volume, ActiveBy::LightOrMedium), {}, {}, {}};
    std::sort(leaves.all.begin(), leaves.all.end(),
              [](const ActiveLeaf& a, const ActiveLeaf& b) { return beforeInTree(a.origin, b.origin); });
    leaves.second = secondLobeLeaves(volume, leaves.all);
    leaves.all_places = placesOf(leaves.all), leaves.second_places = placesOf(leaves.second);
    return leaves;
}

void clearInactive(const NeededVoxels::Mask& active, int components, float* values) {
    for (int i = 0; i < kVoxels; ++i)
        if (!NeededVoxels::maskBit(active, i)) std::fill_n(values + i * components, components, 0.0f);
}

/// How a leaf of a grid becomes bytes.
EncodeLeaf encoder(const VdbGridLayout& layout, LeafValues values, const std::vector<ActiveLeaf>& leaves) {
    return [layout, values = std::move(values), &leaves, convert = halfConversion()](std::int64_t i, char* to) {
        const ActiveLeaf& leaf = leaves[static_cast<std::size_t>(i)];
        float of_voxels[3 * kVoxels];
        values(leaf, of_voxels);
        if (!(layout.compression & kPackedActive)) clearInactive(leaf.mask, layout.components, of_voxels);
        return encodeLeaf(layout, convert, leaf.mask, of_voxels, to);
    };
}

std::vector<GridSource> gridsOf(const LightVolume& volume, const FileLeaves& leaves, const VdbOptions& options,
                                std::atomic<std::int64_t>& clamped) {
    VdbGridLayout common;
    common.half = options.half, common.compression = compressionFlags(options.compression);
    const GridFrame& frame = volume.field.frame();
    common.transform = {frame.worldFromIndex(), frame.origin_world};
    std::vector<GridSource> grids;
    const auto add = [&](const char* name, int components, const char* vector_type, LeafValues values, bool second) {
        VdbGridLayout layout = common;
        layout.name = name, layout.components = components;
        if (components == 3) layout.metadata["vector_type"] = std::string(vector_type);
        // Ten bits would leave millimetres of an arrival time.
        layout.half = layout.half && layout.name != format::kArrivalTime;
        grids.push_back({layout, second ? &leaves.second_places : &leaves.all_places,
                         encoder(layout, std::move(values), second ? leaves.second : leaves.all)});
    };
    const auto addLight = [&](const char* irradiance, const char* direction, const LightField& field, bool second) {
        if (volume.has_irradiance)
            add(irradiance, field.channels().irradiance, "invariant",
                irradianceValues(field, volume.reference_irradiance, clamped), second);
        if (volume.has_direction && field.channels().flux)
            add(direction, 3, "contravariant relative", directionValues(field, options.half), second);
    };
    addLight(format::kIrradiance, format::kDirection, volume.field, false);
    if (!leaves.second.empty()) addLight(format::kIrradiance2, format::kDirection2, *volume.second, true);
    for (const auto& [name, field] : volume.scalars) add(name.c_str(), 1, "", scalarValues(field, clamped), false);
    return grids;
}

}  // namespace

std::int64_t writeVdb(const std::string& path, const LightVolume& volume, const VdbOptions& options) {
    OutputSet outputs;
    const std::int64_t active = writeVdb(outputs, path, volume, options);
    outputs.commit();
    return active;
}

std::int64_t writeVdb(OutputSet& outputs, const std::string& path, const LightVolume& volume,
                      const VdbOptions& options) {
    return writeVdb(outputs.open(path), volume, options);  // opened first: a folder that is closed shows at once
}

std::int64_t writeVdb(CheckedFile& file, const LightVolume& volume, const VdbOptions& options) {
    const std::string& path = file.path();
    if (!(volume.reference_irradiance > 0) || !std::isfinite(volume.reference_irradiance))
        throw Error(ErrorCode::Failed,
                    fmt::format("cannot write {}: the reference irradiance is {} W/m2; it must be positive", path,
                                volume.reference_irradiance),
                    path);
    try {
        const FileLeaves leaves = leavesOf(volume);
        std::atomic<std::int64_t> clamped{0};
        std::vector<GridSource> grids = gridsOf(volume, leaves, options, clamped);
        if (grids.empty())
            throw Error(ErrorCode::Failed,
                        fmt::format("cannot write {}: no grid was asked for; add one to grids", path), path);
        writeGrids(file, grids, [&] { return fileMetadata(volume.metadata, volume.reference_irradiance, clamped); });
        std::int64_t active = 0;
        for (const auto& leaf : leaves.all) active += leaf.count();
        return active;
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::Failed,
                    fmt::format("cannot write {}: out of memory; use larger voxels or where = "
                                "\"receivers\"",
                                path),
                    path);
    }
}

}  // namespace photic
