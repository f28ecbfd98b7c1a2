// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/eikonal_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/report/error.h"
#include "bake/scene/index_volume.h"
#include "bake/threads/parallel_for.h"

namespace photic {

EikonalGrid::Box EikonalGrid::boxOf(const NeededVoxels& needed, const EikonalFront& front) {
    const GridFrame& f = needed.frame();
    int lowest = f.max.z;
    for (int slot = 0; slot < needed.leafCount(); ++slot)
        lowest = std::min(lowest, std::max(f.min.z, needed.leafOrigin(slot).z));
    // The surface, which may lie above the domain, and one layer more below for differences.
    const int top = std::max(
        f.max.z, static_cast<int>(std::ceil(f.indexFromWorld({0, 0, front.surface().height_field->maxZ()}).z)) + 1);
    glm::ivec3 start(f.min.x - kGhosts, f.min.y - kGhosts, lowest - 1), end(f.max.x + kGhosts, f.max.y + kGhosts, top);
    if (front.index()) {
        const glm::dvec2 low(f.indexFromWorld({front.reach().low, 0})), high(f.indexFromWorld({front.reach().high, 0}));
        for (int a = 0; a < 2; ++a) {
            start[a] = std::min(start[a], static_cast<int>(std::floor(low[a])));
            end[a] = std::max(end[a], static_cast<int>(std::ceil(high[a])));
        }
    }
    return {start, end - start + 1};
}

EikonalGrid::EikonalGrid(const NeededVoxels& needed, const EikonalFront& front, const std::string& file)
    : frame(needed.frame()),
      spacing(frame.worldFromIndex()[0].x),
      start(boxOf(needed, front).start),
      size(boxOf(needed, front).size),
      low(start.x & ~7, start.y & ~7, start.z & ~7),
      shift(start - low),
      blocks(BlockGrid::blocksFor(shift + size)),
      fixed(blocks),
      arrival(blocks.cellCount(), kUnreached) {
    const auto& m = frame.worldFromIndex();
    const double off = std::max(std::fabs(m[1].y - spacing), std::fabs(m[2].z - spacing));
    if (!frame.axisAligned() || off > 1e-9 * spacing)
        throw Error(
            ErrorCode::Input,
            fmt::format(
                "marching needs cubic voxels without shear, and they are {:.4g} x {:.4g} x {:.4g} m{}; use solver = "
                "\"foot_points\", or shear = \"none\" without layer_height",
                spacing, m[1].y, m[2].z, frame.axisAligned() ? "" : ", sheared"),
            file);
    // What the blocks hold beside the box is no part of the domain.
    parallelFor(blocks.blockCount(), [&](std::int64_t b) {
        const glm::ivec3 origin = blocks.origin(static_cast<int>(b)) - shift;
        for (int c = 0; c < BlockGrid::kCells; ++c) {
            const glm::ivec3 cell = origin + glm::ivec3(c & 7, c >> 3 & 7, c >> 6);
            bool inside = true;
            for (int a = 0; a < 3; ++a) inside = inside && cell[a] >= 0 && cell[a] < size[a];
            if (!inside) fixed.set(b * BlockGrid::kCells + c);
        }
    });
    if (!front.index()) return;
    slowness.resize(blocks.cellCount());
    parallelFor(blocks.blockCount(), [&](std::int64_t b) {
        const glm::ivec3 origin = blocks.origin(static_cast<int>(b)) - shift;
        for (int c = 0; c < BlockGrid::kCells; ++c)
            slowness[static_cast<std::size_t>(b * BlockGrid::kCells + c)] =
                static_cast<float>(front.index()->at(centre(origin + glm::ivec3(c & 7, c >> 3 & 7, c >> 6))));
    });
}

std::vector<std::uint8_t> EikonalGrid::neededBlocks(const NeededVoxels& needed) const {
    std::vector<std::uint8_t> flags(static_cast<std::size_t>(blocks.blockCount()), 0);
    for (int slot = 0; slot < needed.leafCount(); ++slot) {
        const int b = blocks.slotAt((needed.leafOrigin(slot) - low) / 8);
        if (b >= 0) flags[static_cast<std::size_t>(b)] = 1;
    }
    return flags;
}

std::int64_t EikonalGrid::bytes() const {
    return blocks.bytes() + static_cast<std::int64_t>(arrival.size() * (sizeof(double) + 1.0 / 8 + 4.0 / 8) +
                                                      slowness.size() * sizeof(float));
}

}  // namespace photic
