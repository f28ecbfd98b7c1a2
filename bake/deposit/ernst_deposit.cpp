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

}  // namespace

void depositErnst(const TubeSet& set, LightField& field, Monitor& monitor) {
    if (set.empty()) return;
    std::vector<Fan> fans;
    const auto fan_of = gatherFans(set, fans);
    const auto axes = axesFor(set.axis);
    const GridFrame& frame = field.frame();
    const double per_volume = 1 / frame.voxelVolume();
    const int irradiance = field.channels().irradiance;
    const int first_leaf = frame.min[set.axis] >> 3, leaves = (frame.max[set.axis] >> 3) - first_leaf + 1;

    // A row of leaves along w belongs to one thread.
    const auto depositTube = [&](const TubeBlock& block, std::size_t t, int w) {
        const std::uint8_t* c = block.topology->triangles[t].corner;
        const TubeConstants& tube = set.tubes[block.first_tube + t];
        glm::dvec2 p[3];
        double power[3], area[3];
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t corner = block.first_corner + c[i];
            const CornerRay& ray = set.corners[corner];
            if (set.sense * (w - ray.w) < 0 || set.sense * (ray.w_end - static_cast<double>(w)) < 0) return;
            p[i] = at(ray, w);
            power[i] = fans[fan_of[corner]].power, area[i] = fans[fan_of[corner]].area(w);
        }
        const double whole = cross(p[1] - p[0], p[2] - p[0]);
        if (whole == 0) return;
        const auto [least_u, most_u] = std::minmax({p[0].x, p[1].x, p[2].x});
        const auto [least_v, most_v] = std::minmax({p[0].y, p[1].y, p[2].y});
        const int low_u = std::max(frame.min[axes[0]], static_cast<int>(std::ceil(least_u)));
        const int high_u = std::min(frame.max[axes[0]], static_cast<int>(std::floor(most_u)));
        const int low_v = std::max(frame.min[axes[1]], static_cast<int>(std::ceil(least_v)));
        const int high_v = std::min(frame.max[axes[1]], static_cast<int>(std::floor(most_v)));
        for (int u = low_u; u <= high_u; ++u)
            for (int v = low_v; v <= high_v; ++v) {
                const glm::dvec2 x(u, v);
                const double b0 = cross(p[1] - x, p[2] - x) / whole, b1 = cross(p[2] - x, p[0] - x) / whole,
                             b2 = 1 - b0 - b1;
                if (b0 < 0 || b1 < 0 || b2 < 0) continue;
                const double denominator = std::fabs(b0 * area[0] + b1 * area[1] + b2 * area[2]);
                if (denominator <= 0) continue;
                const double density = (b0 * power[0] + b1 * power[1] + b2 * power[2]) / denominator;
                glm::ivec3 voxel;
                voxel[axes[0]] = u, voxel[axes[1]] = v, voxel[axes[2]] = w;
                const int slot = field.needed().slotOf(voxel);
                if (slot < 0 || !field.needed().contains(voxel)) continue;
                float* out = field.makeDense(slot) + NeededVoxels::offsetInLeaf(voxel);
                double mean = 0;
                for (int k = 0; k < irradiance; ++k) {
                    const double sigma = block.extinction[k];
                    const double path = std::fabs(w - set.corners[block.first_corner + c[0]].w) * tube.length;
                    // Other channels follow the tube's own share of power.
                    const double share = tube.power[0] > 0 ? tube.power[k] / tube.power[0] : 1;
                    const double here = density * share * std::exp(-sigma * path) * per_volume;
                    out[k * LightField::kLeafVoxels] += static_cast<float>(here * tube.length);
                    mean += here / irradiance;
                }
                if (!field.channels().flux) continue;
                for (int k = 0; k < 3; ++k)
                    out[(irradiance + k) * LightField::kLeafVoxels] += static_cast<float>(mean * tube.travel[k]);
            }
    };
    parallelFor(leaves, [&](std::int64_t row) {
        monitor.checkCancelled();
        const int first = std::max(frame.min[set.axis], (first_leaf + static_cast<int>(row)) * 8);
        const int last = std::min(frame.max[set.axis], (first_leaf + static_cast<int>(row)) * 8 + 7);
        for (const TubeBlock& block : set.blocks)
            for (std::size_t t = 0; t < block.topology->triangles.size(); ++t)
                for (int w = first; w <= last; ++w) depositTube(block, t, w);
    });
}

}  // namespace photic
