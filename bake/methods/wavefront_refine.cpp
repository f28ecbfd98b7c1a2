// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wavefront_refine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "bake/paths/optical_scene.h"

namespace photic {
namespace {

/// Less than that in n^2 turns no ray by 60 degrees but on a way that is many times as long as wide.
constexpr double kGentleContrast = 0.15;
constexpr int kHalvings = 3;
constexpr std::size_t kMostTimes = 4;          // as many tubes as were launched
constexpr std::size_t kMostTubes = 134217728;  // 2^27, as a front of the most rays has

/// An edge of a tube, by its rays.
std::uint64_t edgeOf(std::uint32_t a, std::uint32_t b) {
    return static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
}

using Edge = FrontBends::Edge;

/// What is known of the edges of some tubes: of their corners 0 and 1, 1 and 2, 2 and 0. Tubes that share an edge know
/// the same of it, and what its halves have follows from that.
using Edges = std::array<Edge, 3>;

/// Tubes, and what is known of each.
struct Known {
    std::vector<Front::Tube> tubes;
    std::vector<Edges> edges;
    std::vector<std::uint32_t> from;  ///< which of the first ones each is a part of
    void add(const Front::Tube& tube, const Edges& known, std::uint32_t whence) {
        tubes.push_back(tube), edges.push_back(known), from.push_back(whence);
    }
};

/// What the edges of a tube make it wrong by [voxels].
std::array<double, 3> wrongBy(const LaunchPlane& plane, const Front& front, const Front::Tube& tube,
                              const Edges& edges) {
    std::array<double, 3> out;
    const auto strengthOf = [&](std::size_t corner) {
        return channelMean(plane.strengthAt(plane.placeOf(front.rays[tube.ray[corner]])));
    };
    for (std::size_t c = 0; c < 3; ++c) {
        out[c] = double(edges[c].bend);
        if (plane.even() || !(edges[c].length > 0)) continue;
        // Light that grows from nothing along an edge is misplaced by as much as where it bends by its length.
        const double a = strengthOf(c), b = strengthOf((c + 1) % 3);
        if (a + b > 0) out[c] = std::max(out[c], double(edges[c].length) * std::fabs(a - b) / (a + b));
    }
    return out;
}

/// Up to which tolerance at least there are no more than `most` tubes, once edges that are off by more are halved.
double tolerated(const std::vector<std::array<double, 3>>& wrong, double tolerance, std::size_t most) {
    std::vector<double> above;
    for (const auto& edges : wrong)
        for (const double edge : edges)
            if (edge > tolerance) above.push_back(edge);
    const std::size_t room = most > wrong.size() ? most - wrong.size() : 0;
    if (above.size() <= room) return tolerance;
    // One more tube an edge and side.
    const auto last = above.begin() + static_cast<std::ptrdiff_t>(room);
    std::nth_element(above.begin(), last, above.end(), std::greater<>());
    return *last;
}

Edge scaled(const Edge& edge, float bend, float length) { return {bend * edge.bend, length * edge.length}; }

/// Halves each edge by which tubes are wrong by more than the tolerance, once.
/// @param wrong  per tube
Known halveOnce(const LaunchPlane& plane, std::vector<Front::Ray>& rays, const Known& known,
                const std::vector<std::array<double, 3>>& wrong, double tolerance) {
    Known out;
    std::unordered_map<std::uint64_t, std::uint32_t> middles;
    const auto placeOf = [&](std::uint32_t ray) { return plane.placeOf(rays[ray]); };
    const auto middleOf = [&](std::uint32_t a, std::uint32_t b) {
        const auto [at, fresh] = middles.emplace(edgeOf(a, b), static_cast<std::uint32_t>(rays.size()));
        if (fresh) rays.push_back(plane.rayAt(0.5 * (placeOf(a) + placeOf(b))));
        return at->second;
    };
    for (std::size_t t = 0; t < known.tubes.size(); ++t) {
        const Front::Tube& tube = known.tubes[t];
        const auto halves = [&](std::size_t edge) { return wrong[t][edge] > tolerance; };
        const int count = static_cast<int>(halves(0)) + halves(1) + halves(2);
        if (count == 0) {
            out.add(tube, known.edges[t], known.from[t]);
            continue;
        }
        // Turned so that an edge that is halved comes first, and one that is not last.
        std::size_t first = 0;
        while (count < 3 && !(halves(first) && !halves((first + 2) % 3))) ++first;
        Edges edge = known.edges[t];
        std::rotate(edge.begin(), edge.begin() + static_cast<std::ptrdiff_t>(first), edge.end());
        const std::uint32_t a = tube.ray[first], b = tube.ray[(first + 1) % 3], c = tube.ray[(first + 2) % 3];
        const auto add = [&](std::uint32_t p, std::uint32_t q, std::uint32_t r, const Edge& pq, const Edge& qr,
                             const Edge& rp) {
            Front::Tube part = tube;
            part.ray[0] = p, part.ray[1] = q, part.ray[2] = r;
            part.power = plane.power(placeOf(p), placeOf(q), placeOf(r));
            out.add(part, {pq, qr, rp}, known.from[t]);
        };
        // Where the map is quadratic the edge from a middle to the corner beyond bends by no more than that.
        const auto median = [&](std::size_t of) {
            const Edge &one = edge[(of + 1) % 3], &other = edge[(of + 2) % 3];
            return Edge{0.25f * (2 * one.bend + 2 * other.bend + edge[of].bend), 0.5f * (one.length + other.length)};
        };
        // Halves, and edges between middles, which lie along the third one.
        const Edge half[3] = {scaled(edge[0], 0.25f, 0.5f), scaled(edge[1], 0.25f, 0.5f), scaled(edge[2], 0.25f, 0.5f)};
        const std::uint32_t ab = middleOf(a, b);
        if (count == 1) {
            add(a, ab, c, half[0], median(0), edge[2]), add(ab, b, c, half[0], edge[1], median(0));
            continue;
        }
        const std::uint32_t bc = middleOf(b, c);
        add(ab, b, bc, half[0], half[1], half[2]);
        if (count == 2) {
            add(a, ab, bc, half[0], half[2], median(1)), add(a, bc, c, median(1), half[1], edge[2]);
            continue;
        }
        const std::uint32_t ca = middleOf(c, a);
        add(a, ab, ca, half[0], half[1], half[2]), add(ca, bc, c, half[0], half[1], half[2]);
        add(ab, bc, ca, half[2], half[0], half[1]);
    }
    return out;
}

}  // namespace

Front FrontRefiner::halveEdges(const LaunchPlane& plane, const Front& front, const FrontBends* bends, double tolerance,
                               const std::vector<std::uint32_t>& whole, std::size_t most,
                               std::vector<std::uint32_t>& from, FrontCoarse* coarse) {
    Known known{front.tubes, std::vector<Edges>(front.tubes.size()), std::vector<std::uint32_t>(front.tubes.size())};
    std::unordered_set<std::uint64_t> marked;
    for (const std::uint32_t tube : whole)
        for (std::size_t c = 0; c < 3; ++c)
            marked.insert(edgeOf(front.tubes[tube].ray[c], front.tubes[tube].ray[(c + 1) % 3]));
    const int row = front.cells.x + 1;
    for (std::size_t t = 0; t < front.tubes.size(); ++t) {
        known.from[t] = static_cast<std::uint32_t>(t);
        for (std::size_t c = 0; c < 3 && bends; ++c) {
            const auto [a, b] = std::minmax(front.tubes[t].ray[c], front.tubes[t].ray[(c + 1) % 3]);
            const int at = static_cast<int>(a), by = static_cast<int>(b - a);
            known.edges[t][c] = bends->edges[bends->at(at % row, at / row, by == 1 ? 0 : by == row ? 1 : 2)];
        }
    }
    Front out;
    out.axis = front.axis, out.sense = front.sense, out.inside = front.inside, out.rays = front.rays;
    const double asked = tolerance;
    const auto wrongOfAll = [&] {
        std::vector<std::array<double, 3>> wrong(known.tubes.size());
        for (std::size_t t = 0; t < wrong.size(); ++t) wrong[t] = wrongBy(plane, out, known.tubes[t], known.edges[t]);
        return wrong;
    };
    for (int halving = 0; halving < kHalvings; ++halving) {
        std::vector<std::array<double, 3>> wrong = wrongOfAll();
        tolerance = tolerated(wrong, tolerance, most);
        for (std::size_t t = 0; t < wrong.size() && halving == 0 && !marked.empty(); ++t)
            for (std::size_t c = 0; c < 3; ++c)
                if (marked.count(edgeOf(known.tubes[t].ray[c], known.tubes[t].ray[(c + 1) % 3])))
                    wrong[t][c] = std::numeric_limits<double>::infinity();
        const bool any = std::any_of(wrong.begin(), wrong.end(), [&](const auto& edges) {
            return *std::max_element(edges.begin(), edges.end()) > tolerance;
        });
        if (!any) break;
        known = halveOnce(plane, out.rays, known, wrong, tolerance);
    }
    if (coarse) {
        coarse->too_many = coarse->too_many || tolerance > asked;
        const std::vector<std::array<double, 3>> wrong = wrongOfAll();
        for (std::size_t t = 0; t < wrong.size(); ++t) {
            const double by = *std::max_element(wrong[t].begin(), wrong[t].end());
            if (by > asked) coarse->power += channelMean(known.tubes[t].power), coarse->by = std::max(coarse->by, by);
        }
    }
    out.tubes = std::move(known.tubes), from = std::move(known.from);
    return out;
}

namespace {

/// Some tubes of a front, in order, with the rays that they need.
Front pick(const Front& front, const std::vector<char>& which, char as) {
    Front out;
    out.axis = front.axis, out.sense = front.sense, out.inside = front.inside;
    std::vector<std::uint32_t> at(front.rays.size(), Front::kNoSource);
    for (std::size_t t = 0; t < front.tubes.size(); ++t) {
        if (which[t] != as) continue;
        Front::Tube tube = front.tubes[t];
        for (std::uint32_t& ray : tube.ray) {
            if (at[ray] == Front::kNoSource) {
                at[ray] = static_cast<std::uint32_t>(out.rays.size());
                out.rays.push_back(front.rays[ray]);
            }
            ray = at[ray];
        }
        out.tubes.push_back(tube);
    }
    return out;
}

}  // namespace

Front FrontRefiner::refine(Front front) {
    const FrontSpace& space = launch_.space;
    std::optional<LampSide> side;
    if (standsAmong(launch_, sample_)) side.emplace(front.axis, front.sense);
    const LaunchPlane plane(launch_, sample_, side);
    // Tubes that halving what would be lost may add, and all that halving what bends may make.
    std::size_t room = (space.beyond ? 15 : 2) * front.tubes.size();
    const std::size_t most = std::min(kMostTimes * front.tubes.size(), std::max(kMostTubes, front.tubes.size()));
    coarse_ = {};
    // Those that carry most, where there is no room for all.
    const auto keepSome = [&room](const Front& of, std::vector<std::uint32_t>& tubes) {
        const std::size_t many = std::min(tubes.size(), room / 3);
        if (many < tubes.size()) {
            std::stable_sort(tubes.begin(), tubes.end(), [&](std::uint32_t a, std::uint32_t b) {
                return channelMean(of.tubes[a].power) > channelMean(of.tubes[b].power);
            });
            tubes.resize(many);
            std::sort(tubes.begin(), tubes.end());
        }
        room -= 3 * many;
    };
    FrontBends bends(front.cells);
    std::vector<std::uint32_t> lost, from;
    const bool gentle = space.index && 2 * (space.index->largest() - space.index->least()) < kGentleContrast;
    if (space.obstacles || (sweep_.scout(front, gentle, bends) && !gentle)) {
        bends = FrontBends(front.cells);
        lost = sweep_.findLost(front, &bends);
        keepSome(front, lost);
    }
    std::vector<char> again(front.tubes.size(), 0);
    for (const std::uint32_t tube : lost) again[tube] = 1;
    Front parts = halveEdges(plane, front, &bends, tolerance_, lost, most, from, &coarse_);
    std::vector<char> which;
    const auto partsOf = [&] {
        which.clear();
        for (const std::uint32_t tube : from) which.push_back(again[tube]);
    };
    partsOf();
    Front whole = pick(parts, which, 0);
    parts = pick(parts, which, 1);
    for (int halving = 1; halving < kHalvings && !parts.tubes.empty(); ++halving) {
        lost = sweep_.findLost(parts);
        keepSome(parts, lost);
        if (lost.empty()) break;
        again.assign(parts.tubes.size(), 0);
        for (const std::uint32_t tube : lost) again[tube] = 1;
        parts = halveEdges(plane, parts, nullptr, tolerance_, lost, ~std::size_t{0}, from);
        partsOf();
        whole.append(pick(parts, which, 0));
        parts = pick(parts, which, 1);
    }
    whole.append(parts);
    for (Front::Tube& tube : whole.tubes) tube.least = space.limits.threshold * channelMean(tube.power);
    return whole;
}

}  // namespace photic
