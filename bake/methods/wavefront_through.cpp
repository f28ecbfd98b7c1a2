// SPDX-License-Identifier: Apache-2.0
// Tubes that meet sharp surfaces: what is refracted and what is reflected go on as tubes of other fronts, from where
// the three rays meet the surface, so that nothing is lost between the two and nothing counts twice.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/methods/graded_space.h"
#include "bake/methods/wavefront_state.h"

namespace photic {

/// What a surface does to the three rays of a tube.
struct FrontSweep::Through {
    std::array<std::uint32_t, 3> from{};  ///< of the front's rays
    std::array<const RayEnd*, 3> met{};
    std::array<OpticalScene::Event, 3> event{};

    const SpecularBranch* branch(std::size_t corner, bool crosses) const {
        const SpecularEvent& light = event[corner].light;
        for (std::size_t b = 0; b < static_cast<std::size_t>(light.count); ++b)
            if (light.branches[b].crosses == crosses) return &light.branches[b];
        return nullptr;
    }
};

/// Ends a tube on the surface that most of its rays meet, or the middle one. A ray that meets something else goes on as
/// that one does: the tube is as narrow as it can be.
FrontSweep::TubeEnd FrontSweep::handedOn(const Front& front, const Front::Tube& tube, const std::vector<RayEnd>& rays,
                                         const RayEnd& middle, State& state) {
    // Corners of a body part what comes to their sides, however close to each other.
    constexpr double kAlike = 0.85;  // cosine
    const auto alike = [&](const RayEnd& end, const RayEnd& other) {
        return end.target == other.target && end.inside == other.inside &&
               (glm::dot(end.direction, end.meeting.face) < 0) == (glm::dot(other.direction, other.meeting.face) < 0) &&
               glm::dot(end.meeting.normal, other.meeting.normal) > kAlike;
    };
    const RayEnd* chosen = &middle;
    int most = 0;
    std::uint32_t stands_for = tube.ray[0];
    for (const std::uint32_t ray : tube.ray) {
        if (rays[ray].target.kind != Target::Kind::Surface || !rays[ray].meets()) continue;
        const auto with =
            std::count_if(tube.ray, tube.ray + 3, [&](std::uint32_t other) { return alike(rays[other], rays[ray]); });
        if (with > most || (with == most && &rays[ray] == &middle))
            most = static_cast<int>(with), chosen = &rays[ray], stands_for = ray;
    }
    std::array<std::uint32_t, 3> from{};
    TubeEnd end;
    end.ends = end.handed_on = true;
    for (std::size_t c = 0; c < 3; ++c) {
        from[c] = alike(rays[tube.ray[c]], *chosen) ? tube.ray[c] : stands_for;
        end.deposit[c] = rays[from[c]].deposit;
        end.last = std::max(end.last, front.sense * end.deposit[c]);
    }
    if (most < 3 && lost_) lost_->push_back(tube.source);
    handOn(front, tube, rays, from, state);
    return end;
}

void FrontSweep::handOn(const Front& front, const Front::Tube& tube, const std::vector<RayEnd>& rays,
                        const std::array<std::uint32_t, 3>& from, State& state) {
    const GradedSpace& space = *space_->beyond;
    Through through;
    through.from = from;
    glm::dvec3 left(0);
    for (std::size_t c = 0; c < 3; ++c) through.met[c] = &rays[from[c]], left += through.met[c]->left / 3.0;
    countLoss(tube.power, left);
    const int surface = through.met[0]->target.index;
    // Light that is too faint, or has met enough surfaces.
    if (tube.events >= space_->limits.events || channelMean(tube.power) < tube.least) {
        totals_.power.dropped += channelMean(tube.power * left);
        return;
    }
    glm::dvec3 crossing(0), reflected(0);
    int crossings = 0, reflections = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const RayEnd& met = *through.met[c];
        through.event[c] = space.eventOn(surface, met.inside, met.direction, met.meeting);
        OpticalScene::Event& event = through.event[c];
        if (event.void_surface) {
            // Light goes on as it came.
            event.light.branches[0] = {met.direction, glm::dvec3(1), true};
            event.light.count = 1;
        }
        const glm::dvec3 arrives = tube.power * met.left / 3.0;
        totals_.power.reflected += event.light.untraced * channelMean(arrives);
        totals_.power.dropped += event.light.dropped * channelMean(arrives);
        totals_.power.absorbed_surface += channelMean(event.light.absorbed * arrives);
        if (const SpecularBranch* branch = through.branch(c, true)) crossing += branch->fraction * arrives, ++crossings;
        if (const SpecularBranch* branch = through.branch(c, false))
            reflected += branch->fraction * arrives, ++reflections;
    }
    // Where total reflection begins inside of a tube, all of its light takes the way that all of its rays have.
    constexpr double kMuch = 0.02;
    const double power = channelMean(tube.power);
    const auto partly = [&](glm::dvec3& light, int rays_with, glm::dvec3& other, int others) {
        if (rays_with == 0 || rays_with == 3) return;
        if (lost_ && channelMean(light) > kMuch * power) lost_->push_back(tube.source);
        if (others == 3)
            other += light;
        else
            totals_.power.dropped += channelMean(light);
        light = glm::dvec3(0);
    };
    partly(crossing, crossings, reflected, reflections);
    partly(reflected, reflections, crossing, crossings);
    if (crossings == 3) layBranch(front, tube, through, true, crossing, state);
    if (reflections == 3) layBranch(front, tube, through, false, reflected, state);
}

/// Begins what goes on along one branch.
void FrontSweep::layBranch(const Front&, const Front::Tube& tube, const Through& through, bool crosses,
                           const glm::dvec3& power, State& state) {
    if (!(channelMean(power) > 0)) return;
    const GradedSpace& space = *space_->beyond;
    const MediumStack inside = crosses ? through.event[0].beyond : through.met[0]->inside;
    const FrontSpace& there = space.spaceOf(inside);
    std::array<Front::Ray, 3> rays;
    for (std::size_t c = 0; c < 3; ++c) {
        const RayEnd& met = *through.met[c];
        rays[c].voxel = field_.frame().indexFromWorld(met.meeting.position);
        rays[c].momentum = std::sqrt(2 * std::max(there.halfSquareAt(met.meeting.position), 1e-12)) *
                           through.branch(c, crosses)->direction;
        rays[c].lit = true, rays[c].time = met.time, rays[c].surface = met.target.index;
    }
    // Rays that go apart so far speak for nothing that lies between them.
    constexpr double kApart = 0.985;  // cosine
    for (std::size_t c = 0; c < 3 && lost_; ++c)
        if (glm::dot(glm::normalize(rays[c].momentum), glm::normalize(rays[(c + 1) % 3].momentum)) < kApart) {
            lost_->push_back(tube.source);
            break;
        }
    const std::pair<int, int> best = bestWay(-1, rays);
    if (best.first < 0) {
        totals_.power.dropped += channelMean(power);
        if (lost_) lost_->push_back(tube.source);
        return;
    }
    const FrontWay way = wayOf(best.first, best.second, inside);
    Front& next = state.next[way];
    next.axis = best.first, next.sense = best.second, next.inside = inside;
    auto& places = state.places[way];
    Front::Tube out = tube;
    out.power = power;
    if (!through.event[0].void_surface) ++out.events;
    for (std::size_t c = 0; c < 3; ++c) {
        // No lane of a ray that turned away has these numbers.
        const int branch = crosses ? -1000001 : -1000002;
        const auto [place, fresh] =
            places.emplace(std::pair{through.from[c], branch}, static_cast<std::uint32_t>(next.rays.size()));
        if (fresh) next.rays.push_back(rays[c]);
        out.ray[c] = place->second;
    }
    next.tubes.push_back(out);
}

}  // namespace photic
