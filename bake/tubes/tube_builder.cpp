// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/tube_builder.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/tubes/slabs.h"

namespace photic {
namespace {

constexpr std::size_t kBlockTubes = 128, kBlockCorners = 120;

double mean(const glm::dvec3& power) { return (power.x + power.y + power.z) / 3; }

// Three rays whose ends differ in kind stop with the first of them; otherwise each has its own end.
bool sameEnd(const Corner& a, const Corner& b, const Corner& c) {
    return a.end_object == b.end_object && b.end_object == c.end_object;
}

}  // namespace

TubeBuilder::TubeBuilder(const GridFrame& frame, const TubeLight& light)
    : frame_(frame),
      index_from_world_(glm::inverse(frame.world_from_index)),
      light_(light),
      extinction_(light.absorption + light.scattering) {
    for (int i = 0; i < 6; ++i) {
        TubeSet& set = sets_[static_cast<std::size_t>(i)];
        set.axis = i / 2;
        set.sense = i % 2 ? 1 : -1;
        set.channels = light.channels;
        set.extinction = extinction_;
        set.irradiance = light.irradiance;
    }
}

double TubeBuilder::exitDistance(const glm::dvec3& p, const glm::dvec3& d) const {
    double exit = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
        if (d[a] == 0) continue;
        const double side = d[a] > 0 ? frame_.max[a] + 0.5 : frame_.min[a] - 0.5;
        exit = std::min(exit, (side - p[a]) / d[a]);
    }
    return exit;
}

int TubeBuilder::chooseAxis(const Corner& a, const Corner& b, const Corner& c, double max_slope) const {
    const glm::dvec3 d[3] = {indexDirection(a.direction), indexDirection(b.direction), indexDirection(c.direction)};
    int best = -1;
    double best_slope = max_slope;
    for (const int axis : {2, 0, 1}) {
        if (d[0][axis] == 0 || d[0][axis] * d[1][axis] <= 0 || d[0][axis] * d[2][axis] <= 0) continue;
        double slope = 0;
        for (const auto& v : d)
            for (int other = 0; other < 3; ++other)
                if (other != axis) slope = std::max(slope, std::fabs(v[other] / v[axis]));
        // z serves as long as it can: its layers are the cheapest to store.
        if (axis == 2 && slope <= 1.5) return 2;
        if (slope < best_slope) best = axis, best_slope = slope;
    }
    return best;
}

bool TubeBuilder::missesBox(const Corner* const* corners, int count, int) const {
    // Outside one side of the box from start to end.
    bool below[3] = {true, true, true}, above[3] = {true, true, true};
    for (int i = 0; i < count; ++i) {
        const glm::dvec3 p = indexPosition(corners[i]->position), d = indexDirection(corners[i]->direction);
        const double end = std::min(corners[i]->end_distance, std::max(0.0, exitDistance(p, d)));
        const glm::dvec3 q = p + d * end;
        for (int a = 0; a < 3; ++a) {
            below[a] = below[a] && std::max(p[a], q[a]) < frame_.min[a] - 0.5;
            above[a] = above[a] && std::min(p[a], q[a]) > frame_.max[a] + 0.5;
        }
    }
    return below[0] || below[1] || below[2] || above[0] || above[1] || above[2];
}

CornerRay TubeBuilder::cornerRay(const Corner& corner, int axis, double end_distance) const {
    const auto axes = axesFor(axis);
    const glm::dvec3 p = indexPosition(corner.position), d = indexDirection(corner.direction);
    CornerRay ray;
    ray.u = p[axes[0]], ray.v = p[axes[1]], ray.w = p[axes[2]];
    ray.du_dw = d[axes[0]] / d[axes[2]], ray.dv_dw = d[axes[1]] / d[axes[2]];
    const double end = ray.w + d[axes[2]] * end_distance;
    ray.w_end = static_cast<float>(std::clamp(end, -1e30, 1e30));
    return ray;
}

void TubeBuilder::countTube(const Corner* const* corners, const glm::dvec3& arriving, bool culled) {
    for (int i = 0; i < 3; ++i) {
        const Corner& c = *corners[i];
        const glm::dvec3 third = arriving / 3.0;
        if (c.fate == CornerFate::Hidden) continue;
        if (light_.counts_emission) power_.emitted += mean(third);
        if (c.fate == CornerFate::Blocked) {
            if (light_.counts_emission) power_.absorbed_surface += mean(third);
            continue;
        }
        if (light_.counts_emission)
            power_.reflected += mean(third) * c.untraced, power_.dropped += mean(third) * c.dropped;
        if (c.fate != CornerFate::Lit) continue;
        const glm::dvec3 power = third * c.fraction;
        if (culled) {
            power_.culled += mean(power);
            continue;
        }
        glm::dvec3 left = power;
        if (extinction_ != glm::dvec3(0)) {
            const double exit = std::max(0.0, exitDistance(indexPosition(c.position), indexDirection(c.direction)));
            const double length = std::min(c.hit_distance, exit);
            for (int k = 0; k < 3; ++k) {
                if (extinction_[k] <= 0) continue;
                left[k] *= std::exp(-extinction_[k] * length);
                const double lost = (power[k] - left[k]) / 3;
                power_.absorbed_medium += lost * light_.absorption[k] / extinction_[k];
                power_.scattered += lost * light_.scattering[k] / extinction_[k];
            }
        }
        (c.end_object == Corner::kEndsOnSurface ? power_.dropped
         : c.end_object >= 0                    ? power_.received
                                                : power_.escaped) += mean(left);
    }
}

std::uint8_t TubeBuilder::cornerIndex(int s, const Corner& corner, double end_distance) {
    OpenBlock& open = open_[static_cast<std::size_t>(s)];
    TubeSet& set = sets_[static_cast<std::size_t>(s)];
    const CornerRay ray = cornerRay(corner, set.axis, end_distance);
    for (std::size_t i = open.params.size(); i-- > 0;)
        if (open.params[i].position == corner.param.position && open.params[i].normal == corner.param.normal &&
            open.ends[i] == ray.w_end)
            return static_cast<std::uint8_t>(i);
    open.params.push_back(corner.param);
    open.ends.push_back(ray.w_end);
    set.corners.push_back(ray);
    if (light_.density == TubeDensity::Linear) set.spreads.emplace_back();
    return static_cast<std::uint8_t>(open.params.size() - 1);
}

void TubeBuilder::closeBlock(int s) {
    OpenBlock& open = open_[static_cast<std::size_t>(s)];
    TubeSet& set = sets_[static_cast<std::size_t>(s)];
    if (!open.triangles.empty())
        set.blocks.push_back(
            {BlockTopology::fromTriangles(static_cast<int>(open.params.size()), std::move(open.triangles)),
             open.first_corner, open.first_tube});
    open = OpenBlock{};
}

void TubeBuilder::add(const Corner& a, const Corner& b, const Corner& c) {
    const Corner* corners[3] = {&a, &b, &c};
    const glm::dvec3 area = 0.5 * glm::cross(b.position - a.position, c.position - a.position);
    const double facing = -glm::dot(area, light_.direction);
    const double across = light_.two_sided ? std::fabs(facing) : std::max(0.0, facing);
    const glm::dvec3 arriving = light_.irradiance * across;
    double fraction = 0;
    for (const Corner* corner : corners)
        if (corner->fate == CornerFate::Lit) fraction += corner->fraction / 3;
    const bool directed = a.direction != glm::dvec3(0) && b.direction != glm::dvec3(0) && c.direction != glm::dvec3(0);
    const int axis = fraction > 0 && directed ? chooseAxis(a, b, c, kLastSlope) : -1;
    if (fraction > 0 && axis < 0) {
        // At the floor of refinement, and still no tube: a corner without a ray, or rays that part by 90 degrees.
        const PowerLedger before = power_;
        countTube(corners, arriving, true);
        power_.dropped += power_.culled - before.culled;
        power_.culled = before.culled;
        return;
    }
    const bool culled = axis >= 0 && missesBox(corners, 3, axis);
    countTube(corners, arriving, culled);
    if (axis < 0 || culled) return;

    const bool positive = indexDirection(a.direction)[axis] > 0;
    const int s = axis * 2 + (positive ? 1 : 0);
    TubeSet& set = sets_[static_cast<std::size_t>(s)];
    OpenBlock& open = open_[static_cast<std::size_t>(s)];
    if (open.triangles.size() >= kBlockTubes || open.params.size() + 3 > kBlockCorners) closeBlock(s);
    if (open.triangles.empty()) {
        open.first_corner = static_cast<std::uint32_t>(set.corners.size());
        open.first_tube = static_cast<std::uint32_t>(set.tubes.size());
    }
    double ends[3] = {a.end_distance, b.end_distance, c.end_distance};
    if (light_.ends_matter && !sameEnd(a, b, c)) {
        const bool lit[3] = {a.fate == CornerFate::Lit, b.fate == CornerFate::Lit, c.fate == CornerFate::Lit};
        double first = std::numeric_limits<double>::infinity();
        for (int i = 0; i < 3; ++i)
            if (lit[i]) first = std::min(first, ends[i]);
        ends[0] = ends[1] = ends[2] = first;
    }
    BlockTopology::Triangle triangle{};
    for (int i = 0; i < 3; ++i) triangle.corner[i] = cornerIndex(s, *corners[i], ends[i]);
    open.triangles.push_back(triangle);

    TubeConstants tube{};
    for (int k = 0; k < 3; ++k) tube.power[k] = static_cast<float>(arriving[k] * fraction);
    glm::dvec3 travel(0);
    double length = 0;
    for (const Corner* corner : corners) {
        const double per_layer = 1 / std::fabs(indexDirection(corner->direction)[axis]);
        length += per_layer / 3;
        travel += corner->direction * per_layer / 3.0;
    }
    tube.length = static_cast<float>(length);
    for (int k = 0; k < 3; ++k) tube.travel[k] = static_cast<float>(travel[k]);
    set.tubes.push_back(tube);
    ++tubes_;

    const double weight = mean(arriving) * fraction;
    const auto axes = axesFor(axis);
    const glm::dvec3 d = indexDirection(a.direction);
    set.slope_power += weight;
    set.slope_u_power += weight * d[axes[0]] / d[axis];
    set.slope_v_power += weight * d[axes[1]] / d[axis];
}

void TubeBuilder::reserve(int sense, std::size_t corners, std::size_t tubes) {
    TubeSet& set = sets_[sense < 0 ? 4 : 5];
    set.corners.reserve(corners), set.tubes.reserve(tubes);
}

std::array<TubeSet, 6>& TubeBuilder::finish() {
    for (int s = 0; s < 6; ++s) closeBlock(s);
    return sets_;
}

}  // namespace photic
