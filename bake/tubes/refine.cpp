// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/refine.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>

namespace photic {
namespace {

double largest(const glm::dvec3& v) { return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}); }

int mainAxis(const glm::dvec3& v) {
    const glm::dvec3 a = glm::abs(v);
    return a.z >= a.x && a.z >= a.y ? 2 : a.y >= a.x ? 1 : 0;
}

}  // namespace

std::size_t Refiner::ParamHash::operator()(const SurfaceParam& p) const {
    std::uint64_t hash = 0x9e3779b97f4a7c15ull;
    for (const double value : {p.position.x, p.position.y, p.position.z, p.normal.x, p.normal.y, p.normal.z}) {
        std::uint64_t bits;
        std::memcpy(&bits, &value, sizeof bits);
        hash = (hash ^ bits) * 0xbf58476d1ce4e5b9ull;
        hash ^= hash >> 29;
    }
    return static_cast<std::size_t>(hash);
}

bool Refiner::alike(const Corner& a, const Corner& b) const {
    if (a.fate != b.fate) return false;
    if (a.fate != CornerFate::Lit) return true;
    if (options_.ends_matter && a.end_object != b.end_object) return false;
    const glm::dvec3 da = builder_.indexDirection(a.direction), db = builder_.indexDirection(b.direction);
    const int axis = mainAxis(da + db);
    // Directions more than some 100 degrees apart have no plane that both cross.
    return da[axis] * db[axis] > 0 && std::fabs(da[axis]) > 0.2 * largest(da) &&
           std::fabs(db[axis]) > 0.2 * largest(db);
}

bool Refiner::mustSplit(const Corner& a, const Corner& b, const Corner& m) const {
    const glm::dvec3 pa = builder_.indexPosition(a.position), pb = builder_.indexPosition(b.position);
    const double at_surface = largest(pa - pb);
    if (options_.max_edge > 0 && at_surface > options_.max_edge) return true;
    if (!alike(a, b) || !alike(a, m)) return at_surface > options_.silhouette;
    if (a.fate != CornerFate::Lit) return false;
    if (options_.ends_matter && stepsInDepth(a, b, m)) return at_surface > options_.silhouette;
    // Rays half an edge apart: a quarter of the second difference over the edge.
    return options_.tolerance > 0 && 4 * bend(a, m, b) > options_.tolerance;
}

// A step in depth inside one object is a silhouette too.
bool Refiner::stepsInDepth(const Corner& a, const Corner& b, const Corner& m) const {
    if (a.end_object < 0) return false;
    const double voxels = largest(builder_.indexDirection(m.direction));
    const double step = std::fabs(m.hit_distance - 0.5 * (a.hit_distance + b.hit_distance)) * voxels;
    return step > 1 + 0.25 * std::fabs(a.hit_distance - b.hit_distance) * voxels;
}

double Refiner::bend(const Corner& a, const Corner& m, const Corner& b) const {
    const glm::dvec3 pm = builder_.indexPosition(m.position), dm = builder_.indexDirection(m.direction);
    const double exit = builder_.exitDistance(pm, dm);
    if (exit <= 0 && !std::isfinite(m.end_distance)) return 0;
    const int axis = mainAxis(dm);
    const glm::dvec3 landing = pm + dm * std::min(m.end_distance, std::max(exit, 0.0));
    const auto onPlane = [&](const Corner& c) {
        const glm::dvec3 p = builder_.indexPosition(c.position), d = builder_.indexDirection(c.direction);
        return p + d * ((landing[axis] - p[axis]) / d[axis]);
    };
    return largest(onPlane(a) - 2.0 * landing + onPlane(b));
}

void Refiner::decide(const Corner& a, const Corner& b, const glm::dvec3& face, bool split) {
    const SurfaceParam param = middle(a.param, b.param);
    Middle& decided = middles_[param];
    decided.split = split;
    if (!split) return;
    decided.corner = tracer_.trace(param, face);
    ++traced_;
}

const Refiner::Middle& Refiner::middleOf(const Corner& a, const Corner& b, const glm::dvec3& face) {
    const SurfaceParam param = middle(a.param, b.param);
    auto [it, fresh] = middles_.try_emplace(param);
    if (fresh) {
        it->second.corner = tracer_.trace(param, face);
        it->second.split = mustSplit(a, b, it->second.corner);
        ++traced_;
    }
    return it->second;
}

void Refiner::add(const Corner& a, const Corner& b, const Corner& c, const glm::dvec3& face, int depth) {
    // Without a tolerance, three rays that are alike make a tube as they are: no need to trace between them.
    const bool plain = options_.tolerance <= 0 && options_.max_edge <= 0 && !options_.ends_matter;
    const bool as_they_are = plain && alike(a, b) && alike(b, c) && alike(c, a) &&
                             (a.fate != CornerFate::Lit || builder_.axisServes(a, b, c));
    if (depth >= options_.max_depth || as_they_are) {
        builder_.add(a, b, c);
        return;
    }
    // References into an unordered_map stay valid while it grows.
    const Middle& ab = middleOf(a, b, face);
    const Middle& bc = middleOf(b, c, face);
    const Middle& ca = middleOf(c, a, face);
    const int splits = ab.split + bc.split + ca.split;
    if (splits == 0) {
        // What no edge shows: three rays that pairwise share an axis and all together do not.
        const bool lit = a.fate == CornerFate::Lit && b.fate == CornerFate::Lit && c.fate == CornerFate::Lit;
        if (!lit || builder_.axisServes(a, b, c)) {
            builder_.add(a, b, c);
            return;
        }
    }
    if (splits == 3 || splits == 0) {
        add(a, ab.corner, ca.corner, face, depth + 1);
        add(ab.corner, b, bc.corner, face, depth + 1);
        add(ca.corner, bc.corner, c, face, depth + 1);
        add(ab.corner, bc.corner, ca.corner, face, depth + 1);
        return;
    }
    if (splits == 1) {
        if (ab.split) return add(a, ab.corner, c, face, depth + 1), add(ab.corner, b, c, face, depth + 1);
        if (bc.split) return add(b, bc.corner, a, face, depth + 1), add(bc.corner, c, a, face, depth + 1);
        return add(c, ca.corner, b, face, depth + 1), add(ca.corner, a, b, face, depth + 1);
    }
    // Two edges: cut off the corner between them, and halve the rest.
    const auto cut = [&](const Corner& tip, const Corner& next, const Corner& last, const Corner& tip_next,
                         const Corner& last_tip) {
        add(tip, tip_next, last_tip, face, depth + 1);
        add(tip_next, next, last, face, depth + 1);
        add(tip_next, last, last_tip, face, depth + 1);
    };
    if (!bc.split) return cut(a, b, c, ab.corner, ca.corner);
    if (!ca.split) return cut(b, c, a, bc.corner, ab.corner);
    cut(c, a, b, ca.corner, bc.corner);
}

}  // namespace photic
