// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/deposit_work.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec2.hpp>

#include "bake/deposit/edge_kernel.h"
#include "bake/deposit/voxelise.h"

namespace photic {
namespace {

constexpr int kLayers = 16;  // of a slab

/// Where tubes count, as they see it.
struct Box {
    glm::dvec2 low, high;  ///< along u and v [voxels]
    int first_layer, end_layer;
};

Box boxOf(const GridFrame& frame, int axis) {
    const auto axes = axesFor(axis);
    return {{frame.min[axes[0]] - 0.5, frame.min[axes[1]] - 0.5},
            {frame.max[axes[0]] + 0.5, frame.max[axes[1]] + 0.5},
            frame.min[axis],
            frame.max[axis] + 1};
}

/// What a ray comes by in a slab.
struct Reach {
    glm::dvec2 low{1e300}, high{-1e300};
    void add(const glm::dvec2& p) { low = glm::min(low, p), high = glm::max(high, p); }
    void add(const Reach& other) { low = glm::min(low, other.low), high = glm::max(high, other.high); }
    glm::dvec2 size() const { return glm::min(high - low, glm::dvec2(TileSums::kColumns)); }
};

// Cells of one edge: row by row where it is long, all in one where it is short (SlabKernel::addEdge).
double cellsAlong(const Reach& from, const Reach& to) {
    constexpr double kNarrow = 4;
    Reach edge = from;
    edge.add(to);
    const glm::dvec2 size = edge.size();
    const double rows = 1 + size.y;
    if (size.x < kNarrow) return rows * (2 + size.x);
    const double drift = std::max(from.size().x, to.size().x);
    return rows * (2 + drift + (size.x - drift) / rows);
}

// A tube in a slab: all that it comes by, and its rays as the sums see them.
void count(const Reach& tube, const Reach (&drifting)[3], const Box& box, DepositWork& work) {
    for (int k = 0; k < 2; ++k)
        if (tube.high[k] < box.low[k] || tube.low[k] > box.high[k]) return;
    ++work.tubes;
    for (int i = 0; i < 3; ++i) work.cells += 0.5 * cellsAlong(drifting[i], drifting[(i + 1) % 3]);
}

// One tube in the slab from `first` on. The sums drift with the mean slope of the light; what leans otherwise passes
// more of them.
void countSlab(const CornerRay* const* corner, int first, const glm::dvec2& mean_slope, const Box& box,
               DepositWork& work) {
    Reach tube, drifting[3];
    for (int i = 0; i < 3; ++i) {
        const CornerRay& ray = *corner[i];
        const glm::dvec2 slope(ray.du_dw, ray.dv_dw), over = 0.5 * (kLayers - 1) * slope;
        const glm::dvec2 middle = glm::dvec2(ray.u, ray.v) + slope * (first + 0.5 * (kLayers - 1) - ray.w);
        const glm::dvec2 drift = over - 0.5 * (kLayers - 1) * mean_slope;
        tube.add(middle - over), tube.add(middle + over);
        drifting[i].add(middle - drift), drifting[i].add(middle + drift);
    }
    count(tube, drifting, box, work);
}

}  // namespace

DepositWork depositWork(const TubeSet& tubes, const GridFrame& frame, const VoxeliseOptions& options) {
    const Box box = boxOf(frame, tubes.axis);
    const glm::dvec2 mean_slope(tubes.meanSlopeU(), tubes.meanSlopeV());
    const std::vector<int> points = pointsOfBlocks(tubes, options.has_edges);
    DepositWork sum;
    for (std::size_t b = 0; b < tubes.blocks.size(); ++b) {
        const TubeBlock& block = tubes.blocks[b];
        DepositWork work;
        for (const BlockTopology::Triangle& triangle : block.topology->triangles) {
            const CornerRay* corner[3];
            double low = 1e300, high = -1e300;  // layers that it passes
            for (int i = 0; i < 3; ++i) {
                corner[i] = &tubes.corners[block.first_corner + triangle.corner[i]];
                low = std::min({low, corner[i]->w, corner[i]->w_end});
                high = std::max({high, corner[i]->w, corner[i]->w_end});
            }
            for (int first = box.first_layer; first < box.end_layer; first += kLayers)
                if (high > first - 0.5 && low < std::min(first + kLayers, box.end_layer) - 0.5)
                    countSlab(corner, first, mean_slope, box, work);
        }
        sum += work * (options.quadrature > 0 ? options.quadrature : points[b]);
    }
    return sum;
}

DepositWork depositWork(const TubeSet& tubes, const BentRows& bent, const GridFrame& frame, int layers) {
    const Box box = boxOf(frame, tubes.axis);
    const glm::dvec2 first(bent.first_column[0], bent.first_column[1]);
    const glm::dvec2 mean_slope(tubes.meanSlopeU(), tubes.meanSlopeV());
    DepositWork work;
    for (const TubeBlock& block : tubes.blocks)
        for (const BlockTopology::Triangle& triangle : block.topology->triangles) {
            Reach tube, drifting[3];
            for (int i = 0; i < 3; ++i) {
                const float* rows = bent.of(block.first_corner + triangle.corner[i]);
                for (int l = 0; l < layers; ++l) {
                    const glm::dvec2 at(rows[BentRows::kU * BentRows::kLanes + l],
                                        rows[BentRows::kV * BentRows::kLanes + l]);
                    tube.add(at + first), drifting[i].add(at - (l - 0.5 * (kLayers - 1)) * mean_slope);
                }
            }
            count(tube, drifting, box, work);
        }
    return work;
}

}  // namespace photic
