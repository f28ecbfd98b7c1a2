// SPDX-License-Identifier: Apache-2.0
// From the grids of a `.nvdb` to the bricks of a Volume.
#include <algorithm>
#include <iterator>
#include <string>

#include "runtime/format/light_volume_format.h"
#include "runtime/src/metadata_json.h"
#include "runtime/src/nvdb_grid.h"
#include "runtime/src/nvdb_volume.h"
#include "runtime/src/volume_builder.h"

namespace photic::runtime {
namespace {

/// What a grid's components are of the light, by its name; see loadVolume().
struct Role {
    const char* name;
    int components;
    Channels channels;
};
constexpr Role kRoles[] = {{"flux", 4, Channels::FluxAndIrradiance},
                           {"irradiance", 1, Channels::Irradiance},
                           {"irradiance", 3, Channels::ColouredIrradiance},
                           {"direction", 3, Channels::Direction},
                           {"flux_x", 1, Channels::FluxX},
                           {"flux_y", 1, Channels::FluxY},
                           {"flux_z", 1, Channels::FluxZ},
                           {"irradiance_rgb", 3, Channels::Rgb},
                           {"irradiance_r", 1, Channels::Red},
                           {"irradiance_g", 1, Channels::Green},
                           {"irradiance_b", 1, Channels::Blue}};

struct Source {
    const NvdbGrid* grid;
    Channels channels;
};

/// The grids of the second lobe are called as those of the first, and this.
constexpr const char* kSecondLobe = "_2";

/// The grids that make the light of a lobe, irradiance before direction.
/// @param suffix  of their names
std::vector<Source> sourcesOf(const std::vector<NvdbGrid>& grids, const std::string& suffix) {
    std::vector<Source> sources;
    std::string names;
    const auto has = [&](Channels c) {
        return std::any_of(sources.begin(), sources.end(), [&](const Source& s) { return s.channels == c; });
    };
    for (const NvdbGrid& grid : grids) {
        names += (names.empty() ? "'" : ", '") + grid.name() + "'";
        for (const Role& role : kRoles) {
            if (grid.name() != role.name + suffix) continue;
            if (!grid.typeIsRead()) {
                fail(ErrorCode::Format,
                     "grid '" + grid.name() + "' is of NanoVDB's type " + std::to_string(grid.typeNumber()) +
                         "; float, Vec3f, Vec4f, Fp4, Fp8 and Fp16 are read: convert it to one of them");
            }
            if (grid.components() == role.components && !has(role.channels)) sources.push_back({&grid, role.channels});
        }
    }
    const auto requireAll = [&](std::initializer_list<Channels> parts, const char* which) {
        const auto there = std::count_if(parts.begin(), parts.end(), has);
        if (there != 0 && static_cast<std::size_t>(there) != parts.size()) {
            fail(ErrorCode::Format, std::string("some of ") + which + " are missing; the file has " + names);
        }
    };
    requireAll({Channels::FluxX, Channels::FluxY, Channels::FluxZ}, "flux_x, flux_y, flux_z");
    requireAll({Channels::Red, Channels::Green, Channels::Blue}, "irradiance_r, irradiance_g, irradiance_b");
    if (has(Channels::FluxAndIrradiance)) {
        // It holds all but the colours.
        std::erase_if(sources, [](const Source& s) {
            return s.channels != Channels::FluxAndIrradiance && s.channels != Channels::Rgb &&
                   s.channels != Channels::Red && s.channels != Channels::Green && s.channels != Channels::Blue;
        });
    } else if (!has(Channels::Irradiance) && !has(Channels::ColouredIrradiance)) {
        fail(ErrorCode::Format,
             "no grid `flux` (Vec4f) or `irradiance`; the file has " + (names.empty() ? "none" : names));
    }
    std::stable_sort(sources.begin(), sources.end(), [](const Source& a, const Source& b) {
        return (a.channels == Channels::Direction) < (b.channels == Channels::Direction);
    });
    return sources;
}

bool sameTransform(const VoxelTransform& a, const VoxelTransform& b) {
    return a.world_from_index == b.world_from_index && a.origin_world == b.origin_world;
}

/// Whether the file keeps light of a second lobe.
bool hasSecondLobe(const std::vector<NvdbGrid>& grids) {
    return std::any_of(grids.begin(), grids.end(), [](const NvdbGrid& grid) {
        return std::any_of(std::begin(kRoles), std::end(kRoles),
                           [&](const Role& role) { return grid.name() == std::string(role.name) + kSecondLobe; });
    });
}

/// @param second  to go with it
Volume lobeOf(const std::vector<NvdbGrid>& grids, const std::string& suffix, const Volume& second,
              const LoadOptions& options) {
    const std::vector<Source> sources = sourcesOf(grids, suffix);
    VolumeBuilder builder(sources.front().grid->transform(), options.largest_memory);
    for (const NvdbGrid& grid : grids) {
        const std::string json = grid.blindText("photic");
        if (json.empty()) continue;
        builder.setMetadata(readMetadata(json));
        break;
    }
    std::vector<std::vector<NvdbLeaf>> leaves;
    for (const Source& source : sources) {
        if (!sameTransform(source.grid->transform(), sources.front().grid->transform())) {
            fail(ErrorCode::Format, "the grids '" + source.grid->name() + "' and '" + sources.front().grid->name() +
                                        "' have different transforms; they must share one");
        }
        leaves.push_back(source.grid->leaves(options.largest_memory / (VolumeData::kVoxels * sizeof(Half4))));
        for (const NvdbLeaf& leaf : leaves.back()) builder.addBrick(leaf.origin);
    }
    builder.allocate(
        std::any_of(sources.begin(), sources.end(), [](const Source& s) { return holdsColour(s.channels); }));
    std::vector<float> values(std::size_t{VolumeData::kVoxels} * 4);
    for (std::size_t i = 0; i < sources.size(); ++i) {
        builder.beginChannels(sources[i].channels);
        for (const NvdbLeaf& leaf : leaves[i]) {
            sources[i].grid->readLeaf(leaf, values.data());
            builder.setBrick(leaf.origin, sources[i].channels, values.data());
        }
    }
    builder.setSecondLobe(second);
    for (const NvdbGrid& grid : grids) {
        if (grid.name() != format::kBlocksGrid + suffix) continue;
        builder.setBlocks(BlockTexels::of(grid.blindBytes("photic", format::kBlocksMagic)));
        break;
    }
    return builder.finish();
}

Volume volumeOf(const std::vector<NvdbGrid>& grids, const LoadOptions& options) {
    if (!hasSecondLobe(grids)) return lobeOf(grids, "", Volume(), options);
    const Volume second = lobeOf(grids, kSecondLobe, Volume(), options);
    LoadOptions rest = options;
    rest.largest_memory -= std::min(rest.largest_memory, second.bytes());
    return lobeOf(grids, "", second, rest);
}

}  // namespace

Volume readNvdbFile(const Bytes& file, const LoadOptions& options) {
    return volumeOf(readNvdbGrids(file, options.largest_file), options);
}

}  // namespace photic::runtime
