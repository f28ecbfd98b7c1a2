// SPDX-License-Identifier: Apache-2.0
#include "bake/file/sample_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "bake/volume/checksum.h"
#include "bake/volume/vdb_layout.h"

namespace photic {
namespace {

constexpr int kVoxels = VdbGrid::kVoxels;

std::size_t flat(const SampleVolume& volume, const glm::ivec3& voxel) {
    const glm::ivec3 p = voxel - volume.min;
    return (static_cast<std::size_t>(p.z) * static_cast<std::size_t>(volume.size.y) + static_cast<std::size_t>(p.y)) *
               static_cast<std::size_t>(volume.size.x) +
           static_cast<std::size_t>(p.x);
}

/// Calls put(i, voxel) for the voxels of a leaf that the volume has.
template <class Put>
void forEachVoxel(const SampleVolume& volume, const glm::ivec3& origin, const Put& put) {
    for (int i = 0; i < kVoxels; ++i) {
        const glm::ivec3 voxel = origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7), p = voxel - volume.min;
        if (p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < volume.size.x && p.y < volume.size.y && p.z < volume.size.z)
            put(i, voxel);
    }
}

std::vector<VdbTopology> topologyOf(const SampleVolume& volume, std::int64_t& active) {
    std::vector<VdbTopology> leaves;
    const glm::ivec3 low = volume.min >> 3, high = (volume.min + volume.size - 1) >> 3;
    for (int x = low.x; x <= high.x; ++x)
        for (int y = low.y; y <= high.y; ++y)
            for (int z = low.z; z <= high.z; ++z) {
                VdbTopology leaf{glm::ivec3(x, y, z) * 8, {}};
                std::int64_t here = 0;
                forEachVoxel(volume, leaf.origin, [&](int i, const glm::ivec3& voxel) {
                    if (!volume.active(flat(volume, voxel))) return;
                    leaf.mask[static_cast<std::size_t>(i >> 6)] |= std::uint64_t{1} << (i & 63), ++here;
                });
                if (here > 0) leaves.push_back(leaf), active += here;
            }
    std::sort(leaves.begin(), leaves.end(),
              [](const VdbTopology& a, const VdbTopology& b) { return beforeInTree(a.origin, b.origin); });
    return leaves;
}

void append(const SampleVolume& volume, const SampleVolume::Grid& grid, const std::vector<VdbTopology>& leaves,
            std::string& file) {
    VdbGridLayout layout;
    layout.name = grid.name, layout.components = grid.components, layout.half = false;
    layout.transform.world_from_index = glm::dmat3(volume.voxel_size);
    layout.transform.origin_world = glm::dvec3(0.5 * volume.voxel_size);
    VdbGridHead head = vdbGridHead(layout, leaves);
    const std::size_t at = file.size();
    file += head.bytes;
    std::int64_t offsets[3] = {static_cast<std::int64_t>(at + head.offsets + 3 * sizeof(std::int64_t)),
                               static_cast<std::int64_t>(file.size()), 0};
    const HalfConversion convert = halfConversion();
    std::vector<char> bytes(mostBytesOfLeaf(layout));
    std::vector<float> values(static_cast<std::size_t>(kVoxels) * static_cast<std::size_t>(grid.components));
    const auto components = static_cast<std::size_t>(grid.components);
    for (const VdbTopology& leaf : leaves) {
        std::fill(values.begin(), values.end(), 0.0f);
        forEachVoxel(volume, leaf.origin, [&](int i, const glm::ivec3& voxel) {
            if (!(leaf.mask[static_cast<std::size_t>(i >> 6)] >> (i & 63) & 1)) return;
            std::copy_n(grid.values->data() + components * flat(volume, voxel), components,
                        values.data() + components * static_cast<std::size_t>(i));
        });
        file.append(bytes.data(), encodeLeaf(layout, convert, leaf.mask, values.data(), bytes.data()));
    }
    offsets[2] = static_cast<std::int64_t>(file.size());
    std::memcpy(file.data() + at + head.offsets, offsets, sizeof(offsets));
}

}  // namespace

std::int64_t writeSamples(OutputSet& outputs, const std::string& path, const SampleVolume& volume) {
    std::int64_t active = 0;
    const std::vector<VdbTopology> leaves = topologyOf(volume, active);
    std::string file = vdbFileHead(std::string(36, '0'), {}, static_cast<int>(volume.grids.size()));
    for (const SampleVolume::Grid& grid : volume.grids) append(volume, grid, leaves, file);
    // A number made of the contents keeps equal files equal byte for byte.
    const std::uint64_t sum = checksum(file.data(), file.size());
    file.replace(kVdbNumberAt, 36,
                 fmt::format("{:08x}-{:04x}-8{:03x}-8{:03x}-{:012x}", sum >> 32, sum >> 16 & 0xffff, sum & 0xfff,
                             sum >> 4 & 0xfff, sum >> 8 & 0xffffffffffffull));
    outputs.write(path, file);
    return active;
}

}  // namespace photic
