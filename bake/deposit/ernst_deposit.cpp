// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/ernst_deposit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

/// What is found at a point of a tube.
struct ErnstPoint {
    double density = -1;  ///< power an area of the layers' plane [W per voxel face]; below 0 beside the tube
    double layers = 0;    ///< from where the light began [layers]
};

/// Lays tubes layer by layer.
class ErnstLayers {
public:
    ErnstLayers(const TubeSet& set, const ErnstFans& fans, std::size_t number, LightField& field)
        : set_(set),
          fans_(fans),
          number_(number),
          field_(field),
          axes_(axesFor(set.axis)),
          per_volume_(1 / field.frame().voxelVolume()) {}

    /// Adds tube `t` of a block in the layers from `first` to `last`.
    void add(const TubeBlock& block, std::size_t t, int first, int last) const {
        const std::size_t index = block.first_tube + t;
        const ErnstTube& tube = fans_.tube(number_, index);
        if (tube.normal == glm::dvec3(0)) return;
        double end[3];
        for (int i = 0; i < 3; ++i)
            end[i] = set_.corners[block.first_corner + block.topology->triangles[t].corner[i]].w_end;
        for (int w = first; w <= last; ++w) {
            glm::ivec3 low, high;
            if (!boxAt(tube, end, w, low, high)) continue;
            for (glm::ivec3 voxel = low; voxel[axes_[0]] <= high[axes_[0]]; ++voxel[axes_[0]])
                for (voxel[axes_[1]] = low[axes_[1]]; voxel[axes_[1]] <= high[axes_[1]]; ++voxel[axes_[1]]) {
                    const ErnstPoint point = at(tube, end, voxel);
                    if (point.density >= 0) addVoxel(block, set_.tubes[index], voxel, point);
                }
        }
    }

private:
    // The voxels of a layer whose centres a tube can hold. Its rays there are mixtures of the corners', at mixtures of
    // the corners' times: all lie in the hull of nine points.
    bool boxAt(const ErnstTube& tube, const double* end, int w, glm::ivec3& low, glm::ivec3& high) const {
        const GridFrame& frame = field_.frame();
        const int axis = axes_[2];
        double least = 1e300, most = -1e300;
        bool ended = true;
        for (int i = 0; i < 3; ++i) {
            const double alpha = (w - tube.ray[i].start[axis]) / tube.ray[i].along[axis];
            least = std::min(least, alpha), most = std::max(most, alpha);
            ended = ended && set_.sense * (end[i] - w) < 0;
        }
        if (ended || most < std::min({tube.opens[0], tube.opens[1], tube.opens[2]})) return false;
        glm::dvec3 from(1e300), to(-1e300);
        for (const FanRay& ray : tube.ray)
            for (const double alpha : {least, most}) {
                const glm::dvec3 point = ray.start + alpha * ray.along;
                from = glm::min(from, point), to = glm::max(to, point);
            }
        low[axis] = high[axis] = w;
        for (const int a : {axes_[0], axes_[1]}) {
            low[a] = static_cast<int>(std::max<double>(frame.min[a], std::ceil(from[a])));
            high[a] = static_cast<int>(std::min<double>(frame.max[a], std::floor(to[a])));
        }
        return low[axes_[0]] <= high[axes_[0]] && low[axes_[1]] <= high[axes_[1]];
    }

    ErnstPoint at(const ErnstTube& tube, const double* end, const glm::ivec3& voxel) const {
        const glm::dvec3 point(voxel);
        const double alpha = glm::dot(tube.normal, point - tube.origin);
        // [section 3.3] the caustic triangle, and the point's weights in it.
        glm::dvec3 c[3];
        for (int i = 0; i < 3; ++i) c[i] = tube.ray[i].start + alpha * tube.ray[i].along;
        const double whole = glm::dot(tube.normal, glm::cross(c[1] - c[0], c[2] - c[0]));
        if (whole == 0) return {};
        const double b0 = glm::dot(tube.normal, glm::cross(c[1] - point, c[2] - point)) / whole,
                     b1 = glm::dot(tube.normal, glm::cross(c[2] - point, c[0] - point)) / whole, b2 = 1 - b0 - b1;
        if (b0 < 0 || b1 < 0 || b2 < 0) return {};
        const auto mixed = [&](double x0, double x1, double x2) { return b0 * x0 + b1 * x1 + b2 * x2; };
        const int axis = axes_[2], w = voxel[axis];
        if (alpha < mixed(tube.opens[0], tube.opens[1], tube.opens[2])) return {};
        if (set_.sense * (mixed(end[0], end[1], end[2]) - w) < 0) return {};
        // [section 3.4] power over the area of the flattened fans, across the layers.
        const double along = mixed(tube.ray[0].along[axis], tube.ray[1].along[axis], tube.ray[2].along[axis]);
        const double area = mixed(tube.fan[0].at(alpha), tube.fan[1].at(alpha), tube.fan[2].at(alpha));
        if (area == 0) return {};
        ErnstPoint out;
        out.density = mixed(tube.fan[0].power, tube.fan[1].power, tube.fan[2].power) * std::fabs(along / area);
        out.layers = std::fabs((alpha - mixed(tube.opens[0], tube.opens[1], tube.opens[2])) * along);
        return out;
    }

    void addVoxel(const TubeBlock& block, const TubeConstants& tube, const glm::ivec3& voxel,
                  const ErnstPoint& point) const {
        const int slot = field_.needed().slotOf(voxel);
        if (slot < 0 || !field_.needed().contains(voxel)) return;
        const int irradiance = field_.channels().irradiance;
        float* out = field_.makeDense(slot) + NeededVoxels::offsetInLeaf(voxel);
        double mean = 0;
        for (int k = 0; k < irradiance; ++k) {
            // Other channels follow the tube's own share of power.
            const double share = tube.power[0] > 0 ? tube.power[k] / tube.power[0] : 1;
            const double here =
                point.density * share * std::exp(-block.extinction[k] * point.layers * tube.length) * per_volume_;
            out[k * LightField::kLeafVoxels] += static_cast<float>(here * tube.length);
            mean += here / irradiance;
        }
        if (!field_.channels().flux) return;
        for (int k = 0; k < 3; ++k)
            out[(irradiance + k) * LightField::kLeafVoxels] += static_cast<float>(mean * tube.travel[k]);
    }

    const TubeSet& set_;
    const ErnstFans& fans_;
    const std::size_t number_;
    LightField& field_;
    const std::array<int, 3> axes_;
    const double per_volume_;
};

}  // namespace

void depositErnst(const TubeSet& tubes, const ErnstFans& fans, std::size_t set, LightField& field, Monitor& monitor) {
    if (tubes.empty()) return;
    const ErnstLayers layers(tubes, fans, set, field);
    const GridFrame& frame = field.frame();
    const int first_leaf = frame.min[tubes.axis] >> 3, leaves = (frame.max[tubes.axis] >> 3) - first_leaf + 1;
    // A row of leaves along w belongs to one thread.
    parallelFor(leaves, [&](std::int64_t row) {
        monitor.checkCancelled();
        const int first = std::max(frame.min[tubes.axis], (first_leaf + static_cast<int>(row)) * 8);
        const int last = std::min(frame.max[tubes.axis], (first_leaf + static_cast<int>(row)) * 8 + 7);
        for (const TubeBlock& block : tubes.blocks)
            for (std::size_t t = 0; t < block.topology->triangles.size(); ++t) layers.add(block, t, first, last);
    });
}

}  // namespace photic
