// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <memory>

#include "bake/field/needed_voxels.h"
#include "bake/file/file_bytes.h"
#include "bake/file/vdb.h"
#include "bake/report/error.h"
#include "bake/volume/byte_cursor.h"
#include "bake/volume/vdb_bytes.h"
#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

constexpr int kVoxels = LightField::kLeafVoxels;
// Voxels in tiles that are expanded: 1 GiB with direction.
constexpr std::int64_t kLargestTiles = std::int64_t{1} << 26;

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
    throw Error(ErrorCode::Input, fmt::format("cannot read {}: {}", path, why), path);
}

// What is given for a volume by mistake, told by its name; null for anything else.
const char* otherKind(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".toml" || extension == ".glb" || extension == ".gltf")
        return "it is a scene; a light volume (.vdb) is wanted, which photic bake makes of it";
    if (extension == ".nvdb")
        return "it is a volume for games, which photic export made; give the .vdb that it was made of";
    return nullptr;
}

std::string gridNames(const std::vector<VdbGrid>& grids) {
    std::vector<std::string> names;
    for (const auto& g : grids) names.push_back(fmt::format("{} ({})", g.name.empty() ? "unnamed" : g.name, g.type));
    return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

GridFrame frameOf(const std::string& path, const VdbGrid& grid) {
    if (!grid.transform)
        refuse(path, fmt::format("grid {} has a perspective transform; resample it to a linear one", grid.name));
    const GridFrame frame(grid.transform->world_from_index, grid.transform->origin_world);
    if (!(frame.voxelVolume() > 0) || !std::isfinite(frame.voxelVolume()))
        refuse(path, fmt::format("grid {} has voxels of no volume", grid.name));
    return frame;
}

void readMetadata(const VdbMetadata& from, std::map<std::string, std::string>& to) {
    const std::string prefix = format::kPrefix;
    for (const auto& [name, text] : from)
        if (name.compare(0, prefix.size(), prefix) == 0) to[name.substr(prefix.size())] = text;
}

/// A grid with the slots that its leaves have in the light field.
struct KnownGrid {
    const VdbGrid* grid = nullptr;
    std::vector<std::int32_t> leaf_of_slot;  ///< -1: none
    explicit operator bool() const { return grid != nullptr; }
    /// Its leaf, or null.
    const VdbLeaf* leafAt(int slot) const {
        if (grid == nullptr) return nullptr;
        const std::int32_t leaf = leaf_of_slot[static_cast<std::size_t>(slot)];
        return leaf < 0 ? nullptr : &grid->leaves[static_cast<std::size_t>(leaf)];
    }
};

// The grids that make a light volume; empty where there is none.
struct KnownGrids {
    KnownGrid irradiance, direction, irradiance_2, direction_2;
    std::map<std::string, KnownGrid> scalars;
    std::vector<KnownGrid*> all;  // in the file's order
};

// Leaves instead of tiles, as long as they are not too many.
void expandTiles(const std::string& path, VdbGrid& grid) {
    if (grid.tiles.empty()) return;
    if (grid.tileVoxels() > kLargestTiles)
        refuse(path, fmt::format("grid {} holds {} voxels in tiles, more than the {} that are expanded; crop it",
                                 grid.name, grid.tileVoxels(), kLargestTiles));
    grid.expandTiles();
}

void findGrids(const std::string& path, std::vector<VdbGrid>& grids, KnownGrids& known) {
    const auto need = [&](const VdbGrid& grid, bool right, const char* wanted) {
        if (!right) refuse(path, fmt::format("grid {} holds {}, not {}", grid.name, grid.type, wanted));
    };
    for (VdbGrid& grid : grids) {
        KnownGrid* as = nullptr;
        if (grid.name == format::kIrradiance) {
            need(grid, grid.components != 0, "float or vec3s");
            as = &known.irradiance;
        } else if (grid.name == format::kDirection) {
            need(grid, grid.components == 3, "vec3s");
            as = &known.direction;
        } else if (grid.name == format::kIrradiance2) {
            need(grid, grid.components != 0, "float or vec3s");
            as = &known.irradiance_2;
        } else if (grid.name == format::kDirection2) {
            need(grid, grid.components == 3, "vec3s");
            as = &known.direction_2;
        } else if (grid.name == format::kCaustic || grid.name == format::kArrivalTime ||
                   grid.name == format::kDensity) {
            need(grid, grid.components == 1, "float");
            as = &known.scalars[grid.name];
        } else {
            continue;
        }
        expandTiles(path, grid);
        if (!*as) known.all.push_back(as);
        as->grid = &grid;
    }
    if (known.irradiance_2 && !(known.irradiance && known.direction_2 && known.direction &&
                                known.irradiance.grid->components == known.irradiance_2.grid->components))
        refuse(path, fmt::format("{} is a second lobe, which needs {}, {} and {} with as many channels",
                                 format::kIrradiance2, format::kDirection2, format::kIrradiance, format::kDirection));
    if (!known.irradiance && known.scalars.empty())
        refuse(path, fmt::format("it holds no light: looked for irradiance, density, caustic or arrival_time, found {}",
                                 gridNames(grids)));
}

// Whether two grids have the same leaves in the same order with the same active voxels, as ours always have.
bool sameLeaves(const VdbGrid& a, const VdbGrid& b) {
    return std::equal(
        a.leaves.begin(), a.leaves.end(), b.leaves.begin(), b.leaves.end(),
        [&](const VdbLeaf& p, const VdbLeaf& q) { return p.origin == q.origin && a.mask(p) == b.mask(q); });
}

std::shared_ptr<const NeededVoxels> activeVoxels(const std::string& path, KnownGrids& known) {
    const VdbGrid& first = *known.all.front()->grid;
    GridFrame frame = frameOf(path, first);
    std::vector<const VdbGrid*> others;  // whose leaves are not the first one's
    glm::ivec3 low, high;
    first.activeBox(low, high);
    for (const KnownGrid* k : known.all) {
        const GridFrame other = frameOf(path, *k->grid);
        double difference = glm::length(other.origin_world - frame.origin_world);
        for (int a = 0; a < 3; ++a)
            difference = std::max(difference, glm::length(other.worldFromIndex()[a] - frame.worldFromIndex()[a]));
        if (!(difference <= 1e-6 * std::cbrt(frame.voxelVolume())))
            refuse(path, fmt::format("grids {} and {} have different transforms; a light volume has one", first.name,
                                     k->grid->name));
        if (k->grid == &first || sameLeaves(first, *k->grid)) continue;
        others.push_back(k->grid);
        glm::ivec3 min, max;
        k->grid->activeBox(min, max);
        low = glm::min(low, min), high = glm::max(high, max);
    }
    const bool dark = high.x < low.x;
    frame.min = dark ? glm::ivec3(0) : low, frame.max = dark ? glm::ivec3(0) : high;
    NeededVoxels needed = NeededVoxels::none(frame);
    for (const VdbLeaf& leaf : first.leaves) needed.addLeaf(leaf.origin, first.mask(leaf));
    for (const VdbGrid* grid : others)
        for (const VdbLeaf& leaf : grid->leaves) needed.addLeaf(leaf.origin, grid->mask(leaf));
    needed.finish();
    for (KnownGrid* k : known.all) {
        k->leaf_of_slot.assign(static_cast<std::size_t>(needed.leafCount()), -1);
        for (std::size_t i = 0; i < k->grid->leaves.size(); ++i)
            if (const int slot = needed.slotOf(k->grid->leaves[i].origin); slot >= 0)
                k->leaf_of_slot[static_cast<std::size_t>(slot)] = static_cast<std::int32_t>(i);
    }
    return std::make_shared<const NeededVoxels>(std::move(needed));
}

// The values of a leaf, channel after channel, times `scale`; 0 where it is not active.
void readLeaf(const VdbGrid& grid, const VdbLeaf& leaf, float scale, float* out) {
    float values[3 * kVoxels];
    grid.values(leaf, values);
    const auto mask = grid.mask(leaf);
    const int width = grid.components;
    for (int i = 0; i < kVoxels; ++i) {
        const bool active = NeededVoxels::maskBit(mask, i);
        for (int c = 0; c < width; ++c) out[c * kVoxels + i] = active ? values[i * width + c] * scale : 0.0f;
    }
}

void fillLight(LightField& field, const KnownGrid& irradiance_grid, const KnownGrid& direction_grid, float reference) {
    const int colours = field.channels().irradiance;
    forEachLeaf(field.needed(), [&](int slot) {
        const VdbLeaf *irradiance = irradiance_grid.leafAt(slot), *direction = direction_grid.leafAt(slot);
        if (irradiance == nullptr) return;
        bool was_empty = false;
        float* data = field.makeDenseUninitialised(slot, was_empty);
        float* flux = data + colours * kVoxels;
        readLeaf(*irradiance_grid.grid, *irradiance, reference, data);
        if (!field.channels().flux) return;
        if (direction == nullptr) {
            std::fill_n(flux, 3 * kVoxels, 0.0f);
            return;
        }
        readLeaf(*direction_grid.grid, *direction, 1, flux);
        for (int a = 0; a < 3; ++a)
            for (int i = 0; i < kVoxels; ++i) {
                const float mean =
                    colours == 1 ? data[i] : (data[i] + data[kVoxels + i] + data[2 * kVoxels + i]) * (1.0f / 3);
                flux[a * kVoxels + i] *= mean;
            }
    });
}

LightField scalarField(const KnownGrid& known, const std::shared_ptr<const NeededVoxels>& needed) {
    LightField field(needed, {1, false});
    forEachLeaf(*needed, [&](int slot) {
        const VdbLeaf* leaf = known.leafAt(slot);
        if (leaf == nullptr) return;
        bool was_empty = false;
        readLeaf(*known.grid, *leaf, 1, field.makeDenseUninitialised(slot, was_empty));
    });
    return field;
}

double referenceOf(const std::string& path, const std::map<std::string, std::string>& metadata) {
    const auto at = metadata.find(format::kMetaReferenceIrradiance + std::strlen(format::kPrefix));
    if (at == metadata.end()) return 1;
    double reference = 0;
    try {
        reference = std::stod(at->second);
    } catch (const std::logic_error&) {
        reference = 0;
    }
    if (!(reference > 0) || !std::isfinite(reference))
        refuse(path, fmt::format("its reference irradiance is \"{}\", not a positive number", at->second));
    return reference;
}

}  // namespace

LightVolume readVdb(const std::string& path) {
    const FileBytes bytes(path);
    try {
        VdbFile file = parseVdb(bytes.data(), bytes.size());
        KnownGrids known;
        findGrids(path, file.grids, known);

        // What a grid says wins: files that were merged or cut keep it.
        std::map<std::string, std::string> metadata;
        readMetadata(file.metadata, metadata);
        for (const KnownGrid* grid : known.all) readMetadata(grid->grid->metadata, metadata);
        if (const auto version = metadata.find("version");
            version != metadata.end() && std::atoi(version->second.c_str()) > format::kVersion)
            refuse(path, fmt::format("its format is version {}, this program knows up to {}; use a newer one",
                                     version->second, format::kVersion));

        const double reference = referenceOf(path, metadata);
        const auto needed = activeVoxels(path, known);
        const int colours = known.irradiance ? known.irradiance.grid->components : 1;
        LightVolume volume{LightField(needed, {colours, static_cast<bool>(known.direction)}),
                           reference,
                           static_cast<bool>(known.irradiance),
                           static_cast<bool>(known.direction),
                           {},
                           std::move(metadata)};
        fillLight(volume.field, known.irradiance, known.direction, static_cast<float>(reference));
        if (known.irradiance_2) {
            volume.second.emplace(needed, volume.field.channels());
            fillLight(*volume.second, known.irradiance_2, known.direction_2, static_cast<float>(reference));
        }
        for (const auto& [name, grid] : known.scalars) volume.scalars.emplace(name, scalarField(grid, needed));
        return volume;
    } catch (const VolumeFault& fault) {
        const char* kind = otherKind(path);
        refuse(path, kind ? kind : fault.what());
    } catch (const std::bad_alloc&) {
        refuse(path, "it is larger than memory");
    }
}

}  // namespace photic
