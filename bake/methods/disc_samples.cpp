// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/disc_samples.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "bake/optics/tangent_frame.h"
#include "bake/paths/emission.h"
#include "bake/paths/launch_domain.h"
#include "bake/scene/scattered_points.h"

namespace photic {
namespace {

/// [voxels]: where the disc reaches no further, its middle stands for it.
constexpr double kNarrowest = 0.05;
constexpr int kFewest = 5;

// A ray of the disc's middle and two of its rim, through one point of a surface.
struct DiscRays {
    glm::dvec3 position[3], direction[3];
    MediumStack inside;
    double power = 0;
};

// Takes the branch that carries most of the middle's light; false where the rim's does not follow or nothing goes on.
bool takeStrongest(const OpticalScene& optics, int surface, const Meeting (&at)[3], DiscRays& rays) {
    bool crosses = false;
    for (int k = 0; k < 3; ++k) {
        const OpticalScene::Event event = optics.eventAt(surface, 0, rays.inside, rays.direction[k], at[k]);
        if (event.void_surface) return false;
        const SpecularBranch* taken = nullptr;
        for (int b = 0; b < event.light.count; ++b) {
            const SpecularBranch& branch = event.light.branches[static_cast<std::size_t>(b)];
            const bool stronger = !taken || channelMean(branch.fraction) > channelMean(taken->fraction);
            if (k == 0 ? stronger : branch.crosses == crosses) taken = &branch;
        }
        if (!taken) return false;
        if (k == 0) crosses = taken->crosses, rays.power *= channelMean(taken->fraction);
        rays.position[k] = at[k].position, rays.direction[k] = taken->direction;
        if (k == 2 && crosses) rays.inside = event.beyond;
    }
    return true;
}

// How far apart the three land [voxels], at most over their legs in the grid.
double farthestApart(const OpticalScene& optics, int surface, DiscRays& rays, Meeting (&at)[3]) {
    constexpr int kLegs = 4;
    const GridFrame& frame = optics.frame();
    double farthest = 0;
    for (int leg = 0; leg < kLegs && takeStrongest(optics, surface, at, rays); ++leg) {
        const OpticalScene::LegEnd end = optics.legEnd(rays.position[0], rays.direction[0], rays.inside);
        const double exit =
            frame.exitDistance(frame.indexFromWorld(rays.position[0]), frame.indexDirection(rays.direction[0]));
        const double length = std::min(end.hit.distance, std::max(exit, 0.0));
        const glm::dvec3 middle = rays.position[0] + length * rays.direction[0];
        for (int k = 1; k < 3; ++k) {
            // Where the other ray passes beside the middle's end.
            const double along = glm::dot(middle - rays.position[k], rays.direction[k]);
            const glm::dvec3 apart = rays.position[k] + along * rays.direction[k] - middle;
            farthest = std::max(farthest, glm::length(frame.indexDirection(apart)));
        }
        if (end.hit.target.kind != Target::Kind::Surface) break;
        surface = end.hit.target.index, rays.inside = end.inside, at[0] = end.meeting;
        for (int k = 1; k < 3; ++k) {
            const OpticalScene::LegEnd other = optics.legEnd(rays.position[k], rays.direction[k], rays.inside);
            if (other.hit.target != end.hit.target) return farthest;
            at[k] = other.meeting;
        }
    }
    return farthest;
}

// Some points that a surface is lit at, and the power that each stands for, in arbitrary units.
std::vector<EmittedRay> somePoints(const OpticalScene& optics, const Emission& emission, const Light& light) {
    constexpr int kPoints = 128;
    std::vector<EmittedRay> out;
    const Surface& surface = emission.surface();
    if (surface.height_field) {
        const LaunchDomain domain = launchDomain(optics.scene(), surface, light, optics.frame());
        for (int i = 0; i < kPoints && !domain.empty(); ++i) {
            const glm::dvec2 uv = domain.min + scatteredPoint(i) * (domain.max - domain.min);
            out.push_back(emission.at({{uv.x, uv.y, 0}, glm::dvec3(0)}, {0, 0, 1}));
        }
        return out;
    }
    const TriangleMesh& mesh = *surface.mesh;
    const std::size_t step = std::max<std::size_t>(1, mesh.triangles.size() / kPoints);
    for (std::size_t t = 0; t < mesh.triangles.size(); t += step) {
        const auto& c = mesh.triangles[t];
        const glm::dvec3 &p = mesh.positions[c[0]], &q = mesh.positions[c[1]], &r = mesh.positions[c[2]];
        const glm::dvec3 cross = glm::cross(q - p, r - p);
        if (!(glm::length(cross) > 0)) continue;
        const glm::dvec3 normal = mesh.normals[c[0]] + mesh.normals[c[1]] + mesh.normals[c[2]];
        out.push_back(emission.at({(p + q + r) / 3.0, normal}, glm::normalize(cross)));
    }
    return out;
}

}  // namespace

int discSamples(const OpticalScene& optics, const Light& light, int most) {
    const double radius = 0.5 * light.angular_diameter_deg * std::numbers::pi / 180;
    if (radius <= 0 || most <= 1) return 1;
    const TangentFrame disc(light.direction);
    const LightSample middle = lightSamples(light, 1).front();
    double sum = 0, power = 0;
    for (std::size_t s = 0; s < optics.scene().surfaces.size(); ++s) {
        const int surface = static_cast<int>(s);
        const Emission emission(optics.scene(), surface, middle);
        for (const EmittedRay& ray : somePoints(optics, emission, light)) {
            if (optics.arrivalOn(surface, ray.position, ray.direction) != PathOutcome::Lit) continue;
            DiscRays rays;
            Meeting at[3];
            rays.power = std::fabs(glm::dot(ray.direction, ray.face));
            rays.inside = optics.startingInside(surface, ray.direction, ray.face);
            const glm::dvec3 rim[3] = {glm::dvec3(0), disc.across, disc.up};
            for (int k = 0; k < 3; ++k) {
                at[k] = {ray.position, ray.normal, ray.face};
                rays.direction[k] = glm::normalize(light.direction + std::tan(radius) * rim[k]);
            }
            const double weight = rays.power, apart = farthestApart(optics, surface, rays, at);
            sum += weight * apart * apart, power += weight;
        }
    }
    if (!(power > 0) || sum <= kNarrowest * kNarrowest * power) return 1;
    // pi R^2 / n is each sample's share of the disc, a square of half a voxel.
    return std::clamp(static_cast<int>(std::ceil(4 * std::numbers::pi * sum / power)), std::min(kFewest, most), most);
}

}  // namespace photic
