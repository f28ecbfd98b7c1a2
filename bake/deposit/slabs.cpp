// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/slabs.h"

#include <algorithm>

namespace photic {
namespace {

int floorTo(int x, int step) { return x >= 0 ? x - x % step : -((-x + step - 1) / step) * step; }

// For each layer along `axis`, whether any voxel of it is needed.
std::vector<bool> neededLayers(const NeededVoxels& needed, int axis) {
    const int first = needed.frame().min[axis], count = needed.frame().size()[axis];
    std::vector<bool> layers(static_cast<std::size_t>(std::max(0, count)), needed.isEverything());
    if (needed.isEverything()) return layers;
    for (int slot = 0; slot < needed.leafCount(); ++slot) {
        const int origin = needed.leafOrigin(slot)[axis];
        const NeededVoxels::Mask& mask = needed.mask(slot);
        for (int i = 0; i < 8; ++i) {
            const int layer = origin + i - first;
            if (layer < 0 || layer >= count || layers[static_cast<std::size_t>(layer)]) continue;
            bool any = false;
            if (axis == 0) any = mask[static_cast<std::size_t>(i)] != 0;
            for (std::size_t word = 0; word < 8 && axis != 0 && !any; ++word)
                any = (mask[word] & (axis == 1 ? 0xffull << (8 * i) : 0x0101010101010101ull << i)) != 0;
            if (any) layers[static_cast<std::size_t>(layer)] = true;
        }
    }
    return layers;
}

std::vector<Slab> cutSlabs(const std::vector<bool>& layers, int first, int max_lanes) {
    std::vector<Slab> slabs;
    const int count = static_cast<int>(layers.size());
    for (int i = 0; i < count;) {
        if (!layers[static_cast<std::size_t>(i)]) {
            ++i;
            continue;
        }
        const int low = first + i;
        const auto lastNeeded = [&](int limit) {
            int last = low;
            for (int layer = low; layer <= std::min(limit, first + count - 1); ++layer)
                if (layers[static_cast<std::size_t>(layer - first)]) last = layer;
            return last;
        };
        int high = lastNeeded(low + max_lanes - 1);
        // A thin band stays in one slab; a thick one is cut where leaves are, so that whole leaves are stored at once.
        if (high - low + 1 > max_lanes / 2) high = lastNeeded(floorTo(low, max_lanes) + max_lanes - 1);
        const int active = high - low + 1;
        slabs.push_back({low, active, active > 8 ? 16 : active > 4 ? 8 : 4});
        i = high + 1 - first;
    }
    return slabs;
}

}  // namespace

std::vector<SlabGroup> planSlabs(const NeededVoxels& needed, int axis, int tile_size, int max_lanes) {
    const auto axes = axesFor(axis);
    const GridFrame& frame = needed.frame();
    std::vector<SlabGroup> groups;
    for (const Slab& slab : cutSlabs(neededLayers(needed.whole(), axis), frame.min[axis], max_lanes)) {
        const bool shares = !groups.empty() && floorTo(slab.first, 8) <= groups.back().slabs.back().first +
                                                                             groups.back().slabs.back().active - 1;
        if (!shares) groups.emplace_back();
        groups.back().slabs.push_back(slab);
    }
    for (SlabGroup& group : groups) {
        const int low = floorTo(group.slabs.front().first, 8);
        const int high = group.slabs.back().first + group.slabs.back().active - 1;
        int tiles = 0;
        for (int v = floorTo(frame.min[axes[1]], 8); v <= frame.max[axes[1]]; v += tile_size) {
            for (int u = floorTo(frame.min[axes[0]], 8); u <= frame.max[axes[0]]; u += tile_size, ++tiles) {
                bool any = needed.isEverything();
                for (int w = low; w <= high && !any; w += 8)
                    for (int y = v; y < v + tile_size && !any; y += 8)
                        for (int x = u; x < u + tile_size && !any; x += 8) {
                            glm::ivec3 voxel;
                            voxel[axes[0]] = x, voxel[axes[1]] = y, voxel[axes[2]] = w;
                            any = needed.slotOf(voxel) >= 0;
                        }
                if (any) group.tiles.push_back({u, v});
            }
        }
        group.rectangle = static_cast<int>(group.tiles.size()) == tiles;
    }
    return groups;
}

}  // namespace photic
