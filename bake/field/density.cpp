// SPDX-License-Identifier: Apache-2.0
#include "bake/field/density.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "bake/threads/parallel_for.h"

namespace photic {

SurfacePoint surfaceAbove(const HeightField& surface, const glm::dvec2& xy) {
    SurfacePoint point = surface.at(xy);
    if (surface.maxDisplacement() <= 0) return point;
    // Fixed-point iteration: converges while the displacement's gradient is below 1, that is, while the surface
    // does not fold over itself.
    glm::dvec2 uv = xy;
    for (int step = 0; step < 60; ++step) {
        const glm::dvec2 miss = xy - glm::dvec2(point.position);
        uv += miss;
        point = surface.at(uv);
        if (std::fabs(miss.x) + std::fabs(miss.y) < 1e-9 * (1 + surface.maxDisplacement())) break;
    }
    return point;
}

namespace {

/// Where a mesh crosses a voxel column, in index units along k; `enters` is true when the medium lies below.
struct Crossing {
    double k = 0;
    bool medium_below = true;
};

double filledFraction(double surface_k, double k) { return std::clamp(surface_k - k + 0.5, 0.0, 1.0); }

/// Crossings of every column (i, j) of the frame's box, in index units.
class ColumnCrossings {
public:
    ColumnCrossings(const TriangleMesh& mesh, const GridFrame& frame)
        : min_(frame.min),
          size_(frame.size()),
          columns_(static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y)) {
        for (const auto& t : mesh.triangles) {
            glm::dvec3 p[3];
            for (std::size_t c = 0; c < 3; ++c) p[c] = frame.indexFromWorld(mesh.positions[t[c]]);
            addTriangle(p);
        }
        for (auto& column : columns_) {
            std::sort(column.begin(), column.end(), [](const Crossing& a, const Crossing& b) { return a.k < b.k; });
        }
    }

    double density(const glm::ivec3& voxel) const {
        const auto& column = columns_[columnOf(voxel.x, voxel.y)];
        double inside = 0;
        for (std::size_t c = 0; c < column.size(); ++c) {
            const double below = filledFraction(column[c].k, voxel.z);
            // Each crossing is the top or the bottom of a filled interval of the column.
            if (column[c].medium_below) {
                const bool has_bottom = c > 0 && !column[c - 1].medium_below;
                inside += below - (has_bottom ? filledFraction(column[c - 1].k, voxel.z) : 0.0);
            } else if (c + 1 == column.size()) {
                inside += 1 - below;
            }
        }
        return std::clamp(inside, 0.0, 1.0);
    }

private:
    std::size_t columnOf(int i, int j) const {
        return static_cast<std::size_t>(i - min_.x) * static_cast<std::size_t>(size_.y) +
               static_cast<std::size_t>(j - min_.y);
    }

    void addTriangle(const glm::dvec3 (&p)[3]) {
        const double area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[2].x - p[0].x) * (p[1].y - p[0].y);
        if (area == 0) return;
        const double low_x = std::min({p[0].x, p[1].x, p[2].x}), high_x = std::max({p[0].x, p[1].x, p[2].x});
        const double low_y = std::min({p[0].y, p[1].y, p[2].y}), high_y = std::max({p[0].y, p[1].y, p[2].y});
        const int i_begin = static_cast<int>(std::max<double>(min_.x, std::ceil(low_x)));
        const int i_end = static_cast<int>(std::min<double>(min_.x + size_.x - 1, std::floor(high_x)));
        const int j_begin = static_cast<int>(std::max<double>(min_.y, std::ceil(low_y)));
        const int j_end = static_cast<int>(std::min<double>(min_.y + size_.y - 1, std::floor(high_y)));
        for (int i = i_begin; i <= i_end; ++i) {
            for (int j = j_begin; j <= j_end; ++j) {
                double b[3];
                bool inside = true;
                for (int c = 0; c < 3 && inside; ++c) {
                    const glm::dvec3 &q = p[(c + 1) % 3], &r = p[(c + 2) % 3];
                    const double edge = (r.x - q.x) * (j - q.y) - (r.y - q.y) * (i - q.x);
                    b[c] = edge / area;
                    // A shared edge belongs to one of its two triangles: to that which it bounds from below or the
                    // left.
                    const bool owns =
                        area > 0 ? (r.y < q.y || (r.y == q.y && r.x > q.x)) : (r.y > q.y || (r.y == q.y && r.x < q.x));
                    inside = b[c] > 0 || (b[c] == 0 && owns);
                }
                if (!inside) continue;
                columns_[columnOf(i, j)].push_back({b[0] * p[0].z + b[1] * p[1].z + b[2] * p[2].z, area > 0});
            }
        }
    }

    glm::ivec3 min_, size_;
    std::vector<std::vector<Crossing>> columns_;
};

/// Raises the voxels of a leaf to what one surface's medium fills of them.
template <class DensityAt>
void fillLeaf(LightField& field, int slot, const DensityAt& density_at) {
    const NeededVoxels& needed = field.needed();
    const glm::ivec3 origin = needed.leafOrigin(slot);
    float* values = nullptr;
    for (int x = 0; x < 8; ++x) {
        for (int y = 0; y < 8; ++y) {
            for (int z = 0; z < 8; ++z) {
                const glm::ivec3 voxel = origin + glm::ivec3(x, y, z);
                const int offset = NeededVoxels::offsetInLeaf(voxel);
                if (!NeededVoxels::maskBit(needed.mask(slot), offset)) continue;
                const auto density = static_cast<float>(density_at(voxel));
                if (density <= 0) continue;
                if (!values) values = field.makeDense(slot);
                values[offset] = std::max(values[offset], density);
            }
        }
    }
}

}  // namespace

LightField mediumDensity(const Scene& scene, std::shared_ptr<const NeededVoxels> needed) {
    LightField field(std::move(needed), FieldChannels{1, false});
    const GridFrame& frame = field.frame();
    const double layer_height = frame.worldFromIndex()[2].z;
    for (const Surface& surface : scene.surfaces) {
        if (surface.event == SurfaceEvent::Reflect) continue;
        if (surface.height_field) {
            const HeightField& heights = *surface.height_field;
            parallelFor(field.leafCount(), [&](std::int64_t leaf) {
                const int slot = static_cast<int>(leaf);
                const double top = frame.worldFromIndex(glm::dvec3(field.needed().leafOrigin(slot)) + 7.5).z;
                if (field.needed().leafFull(slot) && field.state(slot) == LeafState::Empty && top <= heights.minZ()) {
                    const float one = 1;
                    return field.setConstant(slot, {&one, 1});
                }
                fillLeaf(field, slot, [&](const glm::ivec3& voxel) {
                    const glm::dvec3 p = frame.worldFromIndex(glm::dvec3(voxel));
                    if (p.z - 0.5 * layer_height >= heights.maxZ()) return 0.0;
                    if (p.z + 0.5 * layer_height <= heights.minZ()) return 1.0;
                    return filledFraction((surfaceAbove(heights, p).position.z - p.z) / layer_height, 0.0);
                });
            });
        } else if (surface.mesh) {
            const ColumnCrossings crossings(*surface.mesh, frame);
            parallelFor(field.leafCount(), [&](std::int64_t slot) {
                fillLeaf(field, static_cast<int>(slot),
                         [&](const glm::ivec3& voxel) { return crossings.density(voxel); });
            });
        }
    }
    return field;
}

}  // namespace photic
