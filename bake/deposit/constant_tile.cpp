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

}  // namespace

bool constantTile(const TubeSet& set, const std::vector<std::uint32_t>& blocks, const TileSums& tile, float* values) {
    std::size_t tubes = 0;
    for (const std::uint32_t b : blocks) {
        if (set.blocks[b].extinction != glm::dvec3(0)) return false;
        tubes += set.blocks[b].topology->triangles.size();
    }
    if (tubes > kMaxTubes) return false;

    const double entry = tile.first_w - 0.5, exit = tile.first_w + tile.active_lanes - 0.5;
    const glm::dvec2 low(tile.tile_min_u - 0.5, tile.tile_min_v - 0.5),
        high(tile.tile_max_u - 0.5, tile.tile_max_v - 0.5);
    // A point of the tile that no corner of a regular mesh falls on.
    const glm::dvec2 probe = low + (high - low) * glm::dvec2(0.4142135, 0.5615528);
    const TubeConstants* first = nullptr;
    double density[3] = {0, 0, 0};
    int sheets = 0;
    for (const std::uint32_t b : blocks) {
        const TubeBlock& block = set.blocks[b];
        const CornerRay* corners = &set.corners[block.first_corner];
        for (std::size_t t = 0; t < block.topology->triangles.size(); ++t) {
            const std::uint8_t* c = block.topology->triangles[t].corner;
            const TubeConstants& tube = set.tubes[block.first_tube + t];
            for (int i = 0; i < 3; ++i) {
                const double open = set.sense > 0 ? entry - corners[c[i]].w : corners[c[i]].w - exit;
                const double left = set.sense > 0 ? corners[c[i]].w_end - exit : entry - corners[c[i]].w_end;
                if (open < 0 || left < 0) return false;
            }
            if (!first) first = &tube;
            if (!sameConstants(*first, tube)) return false;
            for (const double w : {entry, 0.5 * (entry + exit), exit}) {
                const glm::dvec2 p[3] = {at(corners[c[0]], w), at(corners[c[1]], w), at(corners[c[2]], w)};
                const double area = 0.5 * std::fabs(cross(p[1] - p[0], p[2] - p[0]));
                for (int k = 0; k < set.channels; ++k) {
                    const double here = tube.power[k] / area;
                    if (density[k] == 0) density[k] = here;
                    if (!(std::fabs(here - density[k]) <= kSame * density[k])) return false;
                }
                if (w == entry) sheets += contains(p, probe);
            }
        }
        for (const auto& edge : block.topology->edges) {
            if (edge.right != BlockTopology::kNone) continue;
            // A rim is harmless only where its box over the slab misses the tile.
            glm::dvec2 least(1e300), most(-1e300);
            for (const std::uint8_t v : {edge.v0, edge.v1})
                for (const double w : {entry, exit}) {
                    const glm::dvec2 p = at(corners[v], w);
                    least = {std::min(least.x, p.x), std::min(least.y, p.y)};
                    most = {std::max(most.x, p.x), std::max(most.y, p.y)};
                }
            if (most.x >= low.x && least.x <= high.x && most.y >= low.y && least.y <= high.y) return false;
        }
    }
    if (!first || sheets == 0) return false;
    double mean = 0;
    for (int k = 0; k < set.channels; ++k) {
        values[k] = static_cast<float>(sheets * density[k] * first->length);
        mean += sheets * density[k] / set.channels;
    }
    if (tile.channels > set.channels)
        for (int k = 0; k < 3; ++k) values[set.channels + k] = static_cast<float>(mean * first->travel[k]);
    return true;
}

}  // namespace photic
