// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/ernst_deposit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/vec2.hpp>
#include <unordered_map>

#include "bake/deposit/slabs.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

// The tubes around a corner: their power, and twice their signed area as a quadratic in w [section 3.4: a + alpha b +
// alpha^2 c].
struct Fan {
    double power = 0, a = 0, b = 0, c = 0;
    double area(double w) const { return 0.5 * (a + w * (b + w * c)); }
};

struct CornerHash {
    std::size_t operator()(const std::array<double, 3>& p) const {
        std::uint64_t hash = 0;
        for (const double value : p) {
            std::uint64_t bits;
            std::memcpy(&bits, &value, sizeof bits);
            hash = (hash ^ bits) * 0x9e3779b97f4a7c15ull;
            hash ^= hash >> 31;
        }
        return static_cast<std::size_t>(hash);
    }
};

double cross(const glm::dvec2& p, const glm::dvec2& q) { return p.x * q.y - p.y * q.x; }

glm::dvec2 at(const CornerRay& ray, double w) {
    return {ray.u + ray.du_dw * (w - ray.w), ray.v + ray.dv_dw * (w - ray.w)};
}

// Blocks repeat the corners on their rims: corners at the same place share a fan.
std::vector<std::uint32_t> gatherFans(const TubeSet& set, std::vector<Fan>& fans) {
    std::vector<std::uint32_t> fan_of(set.corners.size());
    std::unordered_map<std::array<double, 3>, std::uint32_t, CornerHash> known;
    for (std::size_t i = 0; i < set.corners.size(); ++i) {
        const auto [it, fresh] = known.try_emplace({set.corners[i].u, set.corners[i].v, set.corners[i].w},
                                                   static_cast<std::uint32_t>(fans.size()));
        if (fresh) fans.emplace_back();
        fan_of[i] = it->second;
    }
    for (const TubeBlock& block : set.blocks)
        for (std::size_t t = 0; t < block.topology->triangles.size(); ++t) {
            const std::uint8_t* c = block.topology->triangles[t].corner;
            const CornerRay *r0 = &set.corners[block.first_corner + c[0]],
                            *r1 = &set.corners[block.first_corner + c[1]],
                            *r2 = &set.corners[block.first_corner + c[2]];
            const glm::dvec2 k1 = at(*r1, 0) - at(*r0, 0), k2 = at(*r2, 0) - at(*r0, 0);
            const glm::dvec2 l1(r1->du_dw - r0->du_dw, r1->dv_dw - r0->dv_dw),
                l2(r2->du_dw - r0->du_dw, r2->dv_dw - r0->dv_dw);
            for (int i = 0; i < 3; ++i) {
                Fan& fan = fans[fan_of[block.first_corner + c[i]]];
                fan.power += set.tubes[block.first_tube + t].power[0];
                fan.a += cross(k1, k2), fan.b += cross(k1, l2) + cross(l1, k2), fan.c += cross(l1, l2);
            }
        }
    return fan_of;
}

/// One tube across one layer: the triangle, and what it interpolates.
struct CutTube {
    glm::dvec2 p[3];
    double power[3], area[3];  ///< of the corners' fans
    double whole;              ///< twice the triangle's area, signed
};

/// Lays tubes layer by layer.
class ErnstLayers {
public:
    ErnstLayers(const TubeSet& set, LightField& field)
        : set_(set),
          field_(field),
          fan_of_(gatherFans(set, fans_)),
          axes_(axesFor(set.axis)),
          per_volume_(1 / field.frame().voxelVolume()) {}

    /// Adds tube `t` of a block in layer `w`.
    void add(const TubeBlock& block, std::size_t t, int w) const {
        CutTube cut;
        if (!cutAt(block, t, w, cut)) return;
        const GridFrame& frame = field_.frame();
        const auto [least_u, most_u] = std::minmax({cut.p[0].x, cut.p[1].x, cut.p[2].x});
        const auto [least_v, most_v] = std::minmax({cut.p[0].y, cut.p[1].y, cut.p[2].y});
        const int low_u = std::max(frame.min[axes_[0]], static_cast<int>(std::ceil(least_u)));
        const int high_u = std::min(frame.max[axes_[0]], static_cast<int>(std::floor(most_u)));
        const int low_v = std::max(frame.min[axes_[1]], static_cast<int>(std::ceil(least_v)));
        const int high_v = std::min(frame.max[axes_[1]], static_cast<int>(std::floor(most_v)));
        for (int u = low_u; u <= high_u; ++u)
            for (int v = low_v; v <= high_v; ++v) {
                const double density = densityAt(cut, {u, v});
                if (density < 0) continue;
                glm::ivec3 voxel;
                voxel[axes_[0]] = u, voxel[axes_[1]] = v, voxel[axes_[2]] = w;
                addVoxel(block, t, voxel, density);
            }
    }

private:
    bool cutAt(const TubeBlock& block, std::size_t t, int w, CutTube& cut) const {
        const std::uint8_t* c = block.topology->triangles[t].corner;
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t corner = block.first_corner + c[i];
            const CornerRay& ray = set_.corners[corner];
            if (set_.sense * (w - ray.w) < 0 || set_.sense * (ray.w_end - static_cast<double>(w)) < 0) return false;
            cut.p[i] = at(ray, w);
            cut.power[i] = fans_[fan_of_[corner]].power, cut.area[i] = fans_[fan_of_[corner]].area(w);
        }
        cut.whole = cross(cut.p[1] - cut.p[0], cut.p[2] - cut.p[0]);
        return cut.whole != 0;
    }

    /// Power an area at a point; below 0 beside the tube.
    static double densityAt(const CutTube& cut, const glm::dvec2& x) {
        const auto& [p, power, area, whole] = cut;
        const double b0 = cross(p[1] - x, p[2] - x) / whole, b1 = cross(p[2] - x, p[0] - x) / whole, b2 = 1 - b0 - b1;
        if (b0 < 0 || b1 < 0 || b2 < 0) return -1;
        const double denominator = std::fabs(b0 * area[0] + b1 * area[1] + b2 * area[2]);
        if (denominator <= 0) return -1;
        return (b0 * power[0] + b1 * power[1] + b2 * power[2]) / denominator;
    }

    void addVoxel(const TubeBlock& block, std::size_t t, const glm::ivec3& voxel, double density) const {
        const int slot = field_.needed().slotOf(voxel);
        if (slot < 0 || !field_.needed().contains(voxel)) return;
        const std::uint8_t* c = block.topology->triangles[t].corner;
        const TubeConstants& tube = set_.tubes[block.first_tube + t];
        const int irradiance = field_.channels().irradiance;
        float* out = field_.makeDense(slot) + NeededVoxels::offsetInLeaf(voxel);
        double mean = 0;
        for (int k = 0; k < irradiance; ++k) {
            const double sigma = block.extinction[k];
            const double path = std::fabs(voxel[axes_[2]] - set_.corners[block.first_corner + c[0]].w) * tube.length;
            // Other channels follow the tube's own share of power.
            const double share = tube.power[0] > 0 ? tube.power[k] / tube.power[0] : 1;
            const double here = density * share * std::exp(-sigma * path) * per_volume_;
            out[k * LightField::kLeafVoxels] += static_cast<float>(here * tube.length);
            mean += here / irradiance;
        }
        if (!field_.channels().flux) return;
        for (int k = 0; k < 3; ++k)
            out[(irradiance + k) * LightField::kLeafVoxels] += static_cast<float>(mean * tube.travel[k]);
    }

    const TubeSet& set_;
    LightField& field_;
    std::vector<Fan> fans_;
    const std::vector<std::uint32_t> fan_of_;  ///< by corner
    const std::array<int, 3> axes_;
    const double per_volume_;
};

}  // namespace

void depositErnst(const TubeSet& set, LightField& field, Monitor& monitor) {
    if (set.empty()) return;
    const ErnstLayers layers(set, field);
    const GridFrame& frame = field.frame();
    const int first_leaf = frame.min[set.axis] >> 3, leaves = (frame.max[set.axis] >> 3) - first_leaf + 1;
    // A row of leaves along w belongs to one thread.
    parallelFor(leaves, [&](std::int64_t row) {
        monitor.checkCancelled();
        const int first = std::max(frame.min[set.axis], (first_leaf + static_cast<int>(row)) * 8);
        const int last = std::min(frame.max[set.axis], (first_leaf + static_cast<int>(row)) * 8 + 7);
        for (const TubeBlock& block : set.blocks)
            for (std::size_t t = 0; t < block.topology->triangles.size(); ++t)
                for (int w = first; w <= last; ++w) layers.add(block, t, w);
    });
}

}  // namespace photic
