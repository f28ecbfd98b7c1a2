// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/constant_tile.h"

#include <algorithm>
#include <cmath>
#include <glm/vec2.hpp>

namespace photic {
namespace {

constexpr double kSame = 1e-6;         // relative difference that single precision cannot tell
constexpr std::size_t kMaxTubes = 64;  // more than that is not a flat surface

glm::dvec2 at(const CornerRay& c, double w) { return {c.u + c.du_dw * (w - c.w), c.v + c.dv_dw * (w - c.w)}; }

double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

bool contains(const glm::dvec2* p, const glm::dvec2& point) {
    const double a = cross(p[1] - p[0], point - p[0]), b = cross(p[2] - p[1], point - p[1]),
                 c = cross(p[0] - p[2], point - p[2]);
    return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

bool sameConstants(const TubeConstants& a, const TubeConstants& b) {
    bool same = std::fabs(a.length - b.length) <= kSame * a.length;
    for (int k = 0; k < 3; ++k) same = same && std::fabs(a.travel[k] - b.travel[k]) <= kSame * a.length;
    return same;
}

/// What the tubes over a tile add up to, as long as they are alike.
class TileLight {
public:
    TileLight(const TubeSet& set, const TileSums& tile)
        : set_(set),
          entry_(tile.first_w - 0.5),
          exit_(tile.first_w + tile.active_lanes - 0.5),
          low_(tile.tile_min_u - 0.5, tile.tile_min_v - 0.5),
          high_(tile.tile_max_u - 0.5, tile.tile_max_v - 0.5),
          // A point of the tile that no corner of a regular mesh falls on.
          probe_(low_ + (high_ - low_) * glm::dvec2(0.4142135, 0.5615528)) {}

    /// Adds the tubes of a block. @return whether the light is still the same everywhere in the tile
    bool add(const TubeBlock& block) {
        const CornerRay* corners = &set_.corners[block.first_corner];
        for (std::size_t t = 0; t < block.topology->triangles.size(); ++t) {
            const TubeConstants& tube = set_.tubes[block.first_tube + t];
            if (!addTube(corners, block.topology->triangles[t].corner, tube)) return false;
        }
        for (const auto& edge : block.topology->edges)
            if (edge.right == BlockTopology::kNone && rimTouches(corners[edge.v0], corners[edge.v1])) return false;
        return true;
    }

    bool lit() const { return first_ && sheets_ > 0; }
    /// What a voxel holds, channel after channel.
    void write(const TileSums& tile, float* values) const {
        double mean = 0;
        for (int k = 0; k < set_.channels; ++k) {
            values[k] = static_cast<float>(sheets_ * density_[k] * first_->length);
            mean += sheets_ * density_[k] / set_.channels;
        }
        if (tile.channels > set_.channels)
            for (int k = 0; k < 3; ++k) values[set_.channels + k] = static_cast<float>(mean * first_->travel[k]);
    }

private:
    /// A tube that passes the whole slab, as dense there as all before it.
    bool addTube(const CornerRay* corners, const std::uint8_t* c, const TubeConstants& tube) {
        for (int i = 0; i < 3; ++i) {
            const double open = set_.sense > 0 ? entry_ - corners[c[i]].w : corners[c[i]].w - exit_;
            const double left = set_.sense > 0 ? corners[c[i]].w_end - exit_ : entry_ - corners[c[i]].w_end;
            if (open < 0 || left < 0) return false;
        }
        if (!first_) first_ = &tube;
        if (!sameConstants(*first_, tube)) return false;
        for (const double w : {entry_, 0.5 * (entry_ + exit_), exit_}) {
            const glm::dvec2 p[3] = {at(corners[c[0]], w), at(corners[c[1]], w), at(corners[c[2]], w)};
            const double area = 0.5 * std::fabs(cross(p[1] - p[0], p[2] - p[0]));
            for (int k = 0; k < set_.channels; ++k) {
                const double here = tube.power[k] / area;
                if (density_[k] == 0) density_[k] = here;
                if (!(std::fabs(here - density_[k]) <= kSame * density_[k])) return false;
            }
            if (w == entry_) sheets_ += contains(p, probe_);
        }
        return true;
    }

    /// A rim is harmless only where its box over the slab misses the tile.
    bool rimTouches(const CornerRay& one, const CornerRay& other) const {
        glm::dvec2 least(1e300), most(-1e300);
        for (const CornerRay* corner : {&one, &other})
            for (const double w : {entry_, exit_}) {
                const glm::dvec2 p = at(*corner, w);
                least = {std::min(least.x, p.x), std::min(least.y, p.y)};
                most = {std::max(most.x, p.x), std::max(most.y, p.y)};
            }
        return most.x >= low_.x && least.x <= high_.x && most.y >= low_.y && least.y <= high_.y;
    }

    const TubeSet& set_;
    const double entry_, exit_;  ///< of the slab
    const glm::dvec2 low_, high_, probe_;
    const TubeConstants* first_ = nullptr;
    double density_[3] = {0, 0, 0};
    int sheets_ = 0;
};

}  // namespace

bool constantTile(const TubeSet& set, const std::vector<std::uint32_t>& blocks, const TileSums& tile, float* values) {
    std::size_t tubes = 0;
    for (const std::uint32_t b : blocks) {
        if (set.blocks[b].extinction != glm::dvec3(0)) return false;
        tubes += set.blocks[b].topology->triangles.size();
    }
    if (tubes > kMaxTubes) return false;

    TileLight light(set, tile);
    for (const std::uint32_t b : blocks)
        if (!light.add(set.blocks[b])) return false;
    if (!light.lit()) return false;
    light.write(tile, values);
    return true;
}

}  // namespace photic
