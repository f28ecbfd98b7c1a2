// SPDX-License-Identifier: Apache-2.0
// Tubes that turn away from the axis of their front, and go on along another.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bake/graded/ray_integrator.h"
#include "bake/methods/wavefront_state.h"

namespace photic {

/// Finds the tubes that turned away in a chunk, and hands them on.
void FrontSweep::turnAway(const Front& front, const Chunk& chunk, State& state) {
    state.turned.clear();
    for (std::size_t t = 0; t < front.tubes.size(); ++t) {
        if (!state.alive[t] || (!state.ends.empty() && state.ends[t].ends)) continue;
        int earliest = -1;
        for (const std::uint32_t ray : front.tubes[t].ray) {
            const int lane = state.rays.stopped[ray];
            if (lane < 0) continue;
            earliest = earliest < 0 ? lane : front.sense > 0 ? std::min(earliest, lane) : std::max(earliest, lane);
        }
        if (earliest < 0) continue;
        state.turned.push_back({static_cast<std::uint32_t>(t), earliest});
        state.alive[t] = 0;
        passOn(front, chunk, state, state.turned.back());
    }
}

/// Carries a ray on through some part of a layer, with its index: straight on it would keep an energy that it does not
/// have at a face, and leave glass that reflects it.
void FrontSweep::carryOn(int axis, double layers, Front::Ray& ray) const {
    const GridFrame& frame = field_.frame();
    if (!space_->index) {
        const double length =
            std::fabs(layers * frame.worldFromIndex()[axis][axis] / glm::normalize(ray.momentum)[axis]);
        ray.voxel += frame.indexDirection(length * glm::normalize(ray.momentum));
        ray.time += length * glm::length(ray.momentum);
        return;
    }
    const SplineGradedIndex index(*space_->index);
    GradedRay on{frame.worldFromIndex(ray.voxel), ray.momentum, 0};
    constexpr int kSteps = 4;
    const double step = layers * frame.worldFromIndex()[axis][axis] / kSteps;
    for (int i = 0; i < kSteps; ++i)
        if (!stepBetweenPlanes(index, axis, step, on)) {
            // It turns around before it gets there: it goes on level from where it is.
            on.momentum[axis] = 0;
            break;
        }
    ray.voxel = frame.indexFromWorld(on.position), ray.momentum = on.momentum, ray.time += on.optical_path;
}

FrontSweep::Leaving FrontSweep::leave(const Front& front, const Chunk& chunk, const State& state, std::uint32_t ray,
                                      int lane) const {
    const auto axes = axesFor(front.axis);
    const BentRows& bent = state.packed.bent;
    const int before = lane - front.sense;  // the last lane that the tube passes
    // From the grid's first voxel, as rays and rows count.
    const int first_w = chunk.first - origin()[front.axis];
    const double face = first_w + lane - 0.5 * front.sense;
    Leaving out;
    glm::dvec3 slope, at;  // along (u, v, w)
    double n = 1;
    if (before >= 0 && before < chunk.layers) {
        const float* rows = &bent.values[ray * bent.rayStride()];
        const auto row = [&](int which) { return static_cast<double>(rows[which * BentRows::kLanes + before]); };
        slope = {row(BentRows::kSlopeU), row(BentRows::kSlopeV), 1};
        at = {row(BentRows::kU), row(BentRows::kV), first_w + before};
        n = row(BentRows::kMomentum);
        if (bent.timed) out.ray.time = state.time_origin + row(bent.timeRow());
        out.ray.lit = row(BentRows::kLit) > 0;
        for (int k = 0; k < 3; ++k) out.left[k] = row(BentRows::kLeft + std::min(k, bent.channels - 1));
    } else {
        const FrontRays& r = state.before;
        slope = {double(r.pu[ray]) * double(bent.voxel[2]) / double(bent.voxel[0]),
                 double(r.pv[ray]) * double(bent.voxel[2]) / double(bent.voxel[1]), 1};
        slope.x *= front.sense / double(r.pw[ray]), slope.y *= front.sense / double(r.pw[ray]);
        at = {double(r.u[ray]), double(r.v[ray]), double(r.w[ray])};
        n = glm::length(glm::dvec3(r.pu[ray], r.pv[ray], r.pw[ray]));
        out.ray.lit = r.lit[ray] > 0;
        if (bent.timed) out.ray.time = state.time_origin + double(r.time[ray]);
        for (int k = 0; k < 3; ++k)
            out.left[k] = state.attenuates ? std::exp(-double(r.depth[std::min(k, bent.channels - 1)][ray])) : 1.0;
    }
    glm::dvec3 direction;
    for (int a = 0; a < 3; ++a)
        out.ray.voxel[axes[static_cast<std::size_t>(a)]] = at[a] + origin()[axes[static_cast<std::size_t>(a)]],
        direction[axes[static_cast<std::size_t>(a)]] = front.sense * slope[a] * double(bent.voxel[a]);
    out.ray.momentum = n * glm::normalize(direction);
    // On to the face, unless the ray starts beyond it.
    if (front.sense * (face - at.z) > 0) carryOn(front.axis, face - at.z, out.ray);
    return out;
}

std::pair<int, int> bestWay(int but, const std::array<Front::Ray, 3>& rays) {
    glm::dvec3 mean(0);
    for (const Front::Ray& ray : rays) mean += glm::normalize(ray.momentum);
    std::pair<int, int> best{-1, 1};
    double best_cosine = 0.5;
    for (int a = 0; a < 3; ++a) {
        if (a == but) continue;
        const int sense = mean[a] > 0 ? 1 : -1;
        double least = 1;
        for (const Front::Ray& ray : rays) least = std::min(least, sense * ray.momentum[a] / glm::length(ray.momentum));
        if (least > best_cosine) best_cosine = least, best = {a, sense};
    }
    return best;
}

namespace {

constexpr double kLeastCosine = 0.5;  // to the axis along which a ray is followed

double cosineTo(const std::pair<int, int>& way, const Front::Ray& ray) {
    return way.second * ray.momentum[way.first] / glm::length(ray.momentum);
}

/// The axis and sense that suits most of three rays that none suits all of; of several such, where they agree best.
std::pair<int, int> mostWay(const std::array<Front::Ray, 3>& rays) {
    std::pair<int, int> best{0, 1};
    double most = -1;
    for (const Front::Ray& ray : rays)
        for (int a = 0; a < 3; ++a) {
            const std::pair<int, int> way{a, ray.momentum[a] > 0 ? 1 : -1};
            double sum = 0;
            for (const Front::Ray& other : rays)
                if (const double cosine = cosineTo(way, other); cosine > kLeastCosine) sum += 1 + cosine;
            if (sum > most) most = sum, best = way;
        }
    return best;
}

/// The ray that goes on for one of three along a way: itself, or of those that the way suits the one closest to it.
std::size_t nearestAlong(const std::pair<int, int>& way, const std::array<Front::Ray, 3>& rays, std::size_t ray) {
    if (cosineTo(way, rays[ray]) > kLeastCosine) return ray;
    std::size_t nearest = ray;
    double most = -2;
    for (std::size_t c = 0; c < 3; ++c) {
        if (!(cosineTo(way, rays[c]) > kLeastCosine)) continue;
        const double cosine = glm::dot(glm::normalize(rays[c].momentum), glm::normalize(rays[ray].momentum));
        if (cosine > most) most = cosine, nearest = c;
    }
    return nearest;
}

}  // namespace

void FrontSweep::passOn(const Front& front, const Chunk& chunk, State& state, const Turned& turned) {
    const Front::Tube& tube = front.tubes[turned.tube];
    std::array<Front::Ray, 3> rays;
    glm::dvec3 left(0);
    for (std::size_t c = 0; c < 3; ++c) {
        const Leaving leaving = leave(front, chunk, state, tube.ray[c], turned.lane);
        rays[c] = leaving.ray, left += leaving.left / 3.0;
        rays[c].source = front.rays[tube.ray[c]].source;
    }
    const glm::dvec3 power = tube.power * left;
    countLoss(tube.power, left);
    ++totals_.turned;
    if (tube.turns >= space_->limits.turns) {
        totals_.power.dropped += channelMean(power);
        return;
    }
    std::pair<int, int> best = bestWay(front.axis, rays);
    bool parted = tube.parted;
    std::array<std::uint32_t, 3> from{tube.ray[0], tube.ray[1], tube.ray[2]};
    if (best.first < 0) {
        // The tube is as narrow as it can be: it goes on as most of its rays do, once.
        if (lost_ || tube.parted) {
            if (lost_) lost_->push_back(tube.source);
            totals_.power.dropped += channelMean(power);
            return;
        }
        parted = true;
        best = mostWay(rays);
        const std::array<Front::Ray, 3> own = rays;
        for (std::size_t c = 0; c < 3; ++c)
            if (const std::size_t as = nearestAlong(best, own, c); as != c) rays[c] = own[as], from[c] = tube.ray[as];
    }
    const FrontWay way = wayOf(best.first, best.second, front.inside);
    Front& next = state.next[way];
    next.axis = best.first, next.sense = best.second, next.inside = front.inside;
    auto& places = state.places[way];
    Front::Tube out = tube;
    out.power = power, ++out.turns, out.parted = parted;
    for (std::size_t c = 0; c < 3; ++c) {
        const auto [place, fresh] =
            places.emplace(std::pair{from[c], chunk.first + turned.lane}, static_cast<std::uint32_t>(next.rays.size()));
        if (fresh) next.rays.push_back(rays[c]);
        out.ray[c] = place->second;
    }
    next.tubes.push_back(out);
}

}  // namespace photic
