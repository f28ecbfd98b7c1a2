// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <limits>
#include <set>

#include "bake/report/error.h"
#include "bake/scene/index_volume.h"
#include "bake/scene/vdb_voxels.h"
#include "bake/volume/byte_cursor.h"
#include "bake/volume/vdb_bytes.h"

namespace photic {
namespace {

constexpr std::int64_t kMostVoxels = std::int64_t{1} << 28;  // 1 GiB of samples

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
    throw Error(ErrorCode::Input, fmt::format("cannot read the index volume '{}': {}", path, why));
}

const VdbGrid& chooseGrid(const std::string& path, const std::vector<VdbGrid>& grids, const std::string& name) {
    static const std::set<std::string> usual{"ior", "index", "n"};
    std::vector<std::string> names;
    std::vector<const VdbGrid*> fitting, floats;
    for (const VdbGrid& grid : grids) {
        names.push_back(fmt::format("{} ({})", grid.name.empty() ? "unnamed" : grid.name, grid.type));
        if (grid.components != 1) continue;
        floats.push_back(&grid);
        if (name.empty() ? usual.count(grid.name) > 0 : grid.name == name) fitting.push_back(&grid);
    }
    if (fitting.empty() && name.empty() && floats.size() == 1) fitting = floats;
    if (fitting.size() == 1) return *fitting.front();
    const std::string all = names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
    if (fitting.size() > 1)
        refuse(path, fmt::format("several of its grids fit; name one with 'grid'. It holds {}", all));
    if (name.empty())
        refuse(path,
               fmt::format("no float grid of it is called ior, index or n; name one with 'grid'. It holds {}", all));
    refuse(path, fmt::format("it has no float grid '{}'. It holds {}", name, all));
}

IndexVolume::Samples samplesOf(const std::string& path, const VdbGrid& grid) {
    if (!grid.transform)
        refuse(path, fmt::format("grid {} has a perspective transform; resample it to a linear one", grid.name));
    glm::ivec3 min, max;
    if (!grid.activeBox(min, max)) refuse(path, fmt::format("grid {} has no active voxel", grid.name));
    const glm::ivec3 size = max - min + 1;
    if (double(size.x) * size.y * size.z > double(kMostVoxels))
        refuse(path,
               fmt::format("grid {} spans {} x {} x {} voxels, more than the {} that are read; crop or coarsen it",
                           grid.name, size.x, size.y, size.z, kMostVoxels));

    IndexVolume::Samples samples;
    samples.world_from_index = grid.transform->world_from_index;
    samples.origin_world = grid.transform->origin_world + samples.world_from_index * glm::dvec3(min);
    samples.size = size;
    samples.values.assign(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z),
                          std::numeric_limits<float>::quiet_NaN());
    forEachActiveVoxel(grid, [&](const glm::ivec3& voxel, const float* value) {
        const float n = *value;
        if (!(double(n) >= kLeastIndex && double(n) <= kLargestIndex))
            refuse(path, fmt::format("voxel ({}, {}, {}) of grid {} is {}; an index must lie between {} and {}",
                                     voxel.x, voxel.y, voxel.z, grid.name, n, kLeastIndex, kLargestIndex));
        const glm::ivec3 p = voxel - min;
        samples.values[(std::size_t(p.z) * std::size_t(size.y) + std::size_t(p.y)) * std::size_t(size.x) +
                       std::size_t(p.x)] = n;
    });
    return samples;
}

}  // namespace

IndexVolume readIndexVolume(const std::string& path, const std::string& bytes, const std::string& name, double medium,
                            Monitor& monitor) {
    try {
        const VdbFile file = parseVdb(bytes.data(), bytes.size());
        const VdbGrid& grid = chooseGrid(path, file.grids, name);
        if (grid.storedAsHalf())
            monitor.warn(fmt::format(
                "'{}': grid {} is stored as half floats, which hold an index near 1.33 to 0.001: light bends at "
                "its steps; save 32-bit floats",
                path, grid.name));
        return {samplesOf(path, grid), medium};
    } catch (const VolumeFault& fault) {
        refuse(path, fault.what());
    } catch (const std::bad_alloc&) {
        refuse(path, "it is larger than memory");
    }
}

}  // namespace photic
