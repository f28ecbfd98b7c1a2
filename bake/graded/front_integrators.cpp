// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/front_integrators.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bake/graded/ray_integrator.h"

namespace photic {
namespace {

constexpr int kLayers = 16;
// Rows, as BentRows orders them.
enum Row { kU, kV, kSlopeU, kSlopeV, kLit, kMomentum, kLeft };

void step(FrontIntegrator integrator, const GradedIndex& index, double length, double voxel, GradedRay& ray) {
    constexpr double kTolerance = 1e-6;  // voxels
    if (integrator == FrontIntegrator::Yoshida)
        stepYoshida(index, length, ray);
    else if (integrator == FrontIntegrator::Controlled && length > 0)
        stepControlled(index, length, kTolerance * voxel, ray);
    else
        stepRungeKutta(index, length, ray);
}

/// One ray on its way through a slab.
class Follower {
public:
    Follower(FrontIntegrator integrator, const FrontPlaces& places, const FrontMarch& march)
        : integrator_(integrator), places_(places), march_(march), index_(*places.index) {}

    void take(const FrontRays& rays, std::size_t r) {
        const double voxel[3] = {double(rays.u[r]), double(rays.v[r]), double(rays.w[r])},
                     momentum[3] = {double(rays.pu[r]), double(rays.pv[r]), march_.sense * double(rays.pw[r])};
        for (int a = 0; a < 3; ++a) {
            const int axis = places_.axes[a];
            ray_.position[axis] = nodes().first_world[axis] + (voxel[a] - places_.first_node[axis]) * spacing(axis);
            ray_.momentum[axis] = momentum[a];
        }
        ray_.optical_path = rays.time.empty() ? 0 : double(rays.time[r]);
        lit_ = rays.lit[r] > 0;
        for (int k = 0; k < 3; ++k) depth_[k] = rays.depth[k].empty() ? 0 : double(rays.depth[k][r]);
    }
    void put(FrontRays& rays, std::size_t r) const {
        rays.u[r] = static_cast<float>(voxelAlong(0)), rays.v[r] = static_cast<float>(voxelAlong(1)),
        rays.w[r] = static_cast<float>(voxelAlong(2));
        rays.pu[r] = static_cast<float>(momentumAlong(0)), rays.pv[r] = static_cast<float>(momentumAlong(1)),
        rays.pw[r] = static_cast<float>(march_.sense * momentumAlong(2));
        rays.lit[r] = lit_ ? 1.0f : 0.0f;
        if (!rays.time.empty()) rays.time[r] = static_cast<float>(ray_.optical_path);
        for (int k = 0; k < 3; ++k)
            if (!rays.depth[k].empty()) rays.depth[k][r] = static_cast<float>(depth_[k]);
    }

    /// To a plane [voxels along w]; a ray that starts beyond it waits.
    /// @return false, and leaves the ray, where it turns away
    bool goTo(double plane) {
        if (march_.sense * (plane - voxelAlong(2)) <= 0) return true;
        const GradedRay before = ray_;
        const int w = places_.axes[2];
        const double target = nodes().first_world[w] + (plane - places_.first_node[w]) * spacing(w);
        constexpr int kTries = 8;
        constexpr double kOnPlane = 1e-9;  // voxels
        for (int i = 0; i < kTries; ++i) {
            const double left = target - ray_.position[w];
            if (std::fabs(left) < kOnPlane * spacing(w)) break;
            step(integrator_, index_, left / ray_.momentum[w], spacing(w), ray_);
            const double forward = march_.sense * ray_.momentum[w], n = glm::length(ray_.momentum);
            if (forward < double(march_.least_cosine) * n || !std::isfinite(n)) {
                ray_ = before;
                return false;
            }
        }
        ray_.position[w] = target;
        const glm::dvec3 middle = 0.5 * (before.position + ray_.position);
        lit_ = lit_ || std::fabs(places_.index->at(middle).half_square - double(march_.air)) > double(march_.least_lit);
        if (march_.media && march_.media->of_node) attenuate(middle, glm::distance(before.position, ray_.position));
        return true;
    }

    /// What a lane's rows hold, at a plane.
    void write(double plane, bool timed, float (*rows)[kLayers], int lane) const {
        const double forward = momentumAlong(2), wide = march_.sense * (plane - voxelAlong(2));
        for (int a = 0; a < 2; ++a) {
            const double slope = momentumAlong(a) / forward * spacing(places_.axes[2]) /
                                 spacing(places_.axes[static_cast<std::size_t>(a)]);
            // Before a ray starts it is where it would come from.
            rows[kU + a][lane] = static_cast<float>(voxelAlong(a) + slope * march_.sense * wide);
            rows[kSlopeU + a][lane] = static_cast<float>(slope);
        }
        rows[kLit][lane] = lit_ ? 1.0f : 0.0f;
        const double square = glm::dot(ray_.momentum, ray_.momentum);
        rows[kMomentum][lane] = static_cast<float>(std::sqrt(square));
        for (int k = 0; k < march_.channels; ++k) rows[kLeft + k][lane] = static_cast<float>(std::exp(-depth_[k]));
        if (timed)
            rows[kLeft + march_.channels][lane] = static_cast<float>(
                ray_.optical_path + wide * spacing(places_.axes[2]) * square / (march_.sense * forward));
    }

private:
    const SplineIndex::Nodes& nodes() const { return places_.index->nodes(); }
    double spacing(int axis) const { return nodes().spacing[axis]; }
    double voxelAlong(int a) const {
        const int axis = places_.axes[a];
        return (ray_.position[axis] - nodes().first_world[axis]) / spacing(axis) + places_.first_node[axis];
    }
    double momentumAlong(int a) const { return ray_.momentum[places_.axes[a]]; }
    void attenuate(const glm::dvec3& place, double length) {
        const FrontMedia& media = *march_.media;
        const std::size_t strides[3] = {media.stride_u, media.stride_v, media.stride_w};
        std::size_t node = 0;
        for (int a = 0; a < 3; ++a) {
            const int axis = places_.axes[a];
            const double at = std::round((place[axis] - nodes().first_world[axis]) / spacing(axis));
            node += static_cast<std::size_t>(std::clamp(at, 0.0, nodes().count[axis] - 1.0)) * strides[a];
        }
        const std::uint8_t medium = media.of_node[node];
        for (int k = 0; k < march_.channels && medium > 0; ++k)
            depth_[k] += double(media.extinction[medium][k]) * length;
    }

    FrontIntegrator integrator_;
    const FrontPlaces& places_;
    const FrontMarch& march_;
    SplineGradedIndex index_;
    GradedRay ray_;
    bool lit_ = false;
    double depth_[3] = {0, 0, 0};
};

}  // namespace

void marchFrontBy(FrontIntegrator integrator, const FrontPlaces& places, const FrontMarch& march, FrontRays& rays,
                  std::size_t first, std::size_t count, float* rows, std::size_t stride) {
    const bool timed = !rays.time.empty();
    const int kinds = kLeft + march.channels + (timed ? 1 : 0);
    const int per_layer = integrator == FrontIntegrator::Controlled ? 1 : places.steps;
    Follower ray(integrator, places, march);
    for (std::size_t r = first; r < std::min(first + count, rays.count); ++r) {
        ray.take(rays, r);
        float table[kLeft + 4][kLayers] = {};
        for (int i = 0; i < march.layers; ++i) {
            const int lane = march.sense > 0 ? i : march.layers - 1 - i;
            const double plane = march.first_w + lane;
            for (int s = 0; s < per_layer && rays.stopped[r] < 0; ++s) {
                const double target = plane - march.sense * static_cast<double>(per_layer - 1 - s) / per_layer;
                if (!ray.goTo(target)) rays.stopped[r] = static_cast<std::int8_t>(lane);
            }
            ray.write(plane, timed, table, lane);
        }
        ray.put(rays, r);
        if (!rows) continue;
        float* out = rows + r * stride;
        for (int kind = 0; kind < kinds; ++kind)
            for (int lane = 0; lane < kLayers; ++lane) *out++ = table[kind][std::min(lane, march.layers - 1)];
    }
}

}  // namespace photic
