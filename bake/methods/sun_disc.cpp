// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/sun_disc.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "bake/optics/snell.h"
#include "bake/optics/tangent_frame.h"
#include "bake/paths/emission.h"
#include "bake/paths/launch_domain.h"

namespace photic {
namespace {

/// [voxels]. Measured on a pool with a ball and walls: 0.43 and 0.72 % (L1) from 32 sampled directions at 0.3 and 0.7.
constexpr double kWidestBlurOverShadows = 1.0;

/// [voxels]: where the disc reaches no further, its middle stands for it.
constexpr double kNarrowest = 0.05;
constexpr int kFewest = 5;

double angularRadius(const Light& light) { return 0.5 * light.angular_diameter_deg * std::numbers::pi / 180; }

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
            // Roberts' R2 sequence.
            const glm::dvec2 x(std::fmod(0.5 + 0.7548776662466927 * i, 1.0),
                               std::fmod(0.5 + 0.5698402909980532 * i, 1.0));
            const glm::dvec2 uv = domain.min + x * (domain.max - domain.min);
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

bool blurServes(const Scene& scene, const Light& light, const GridFrame& frame) {
    if (scene.surfaces.size() != 1) return false;
    const Surface& surface = scene.surfaces.front();
    if (!surface.height_field || surface.event == SurfaceEvent::Both) return false;
    const bool silhouettes = std::any_of(scene.objects.begin(), scene.objects.end(), [](const Object& object) {
        return object.blocks() && !std::holds_alternative<Plane>(object.shape);
    });
    if (!silhouettes) return true;
    const auto kernel = discKernels(surface, light, frame);
    const auto reach = [&](int k) {  // of the ellipse along x and y [voxels]; it grows evenly with depth
        const glm::dmat2 disc = kernel(k).disc_from_unit;
        return std::max(std::hypot(disc[0].x, disc[1].x), std::hypot(disc[0].y, disc[1].y));
    };
    return std::max(reach(frame.min.z), reach(frame.max.z)) <= kWidestBlurOverShadows;
}

std::function<LayerKernel(int)> discKernels(const Surface& surface, const Light& light, const GridFrame& frame) {
    const double level = 0.5 * (surface.height_field->minZ() + surface.height_field->maxZ());
    const bool refract = surface.event == SurfaceEvent::Refract;
    const double radius = angularRadius(light);
    const auto slope = [&](const glm::dvec3& d) {
        const Interface i = interfaceAt(d, {0, 0, 1}, surface.ior_above, surface.ior_below);
        const glm::dvec3 out = refract ? i.refracted : i.reflected;
        return glm::dvec2(out.x / out.z, out.y / out.z);
    };
    const TangentFrame disc(light.direction);
    const double s = std::sin(radius), c = std::cos(radius);
    // Central differences over the disc itself, in world x and y for each metre of z.
    const glm::dvec2 along_x =
        0.5 * (slope(c * light.direction + s * disc.across) - slope(c * light.direction - s * disc.across));
    const glm::dvec2 along_y =
        0.5 * (slope(c * light.direction + s * disc.up) - slope(c * light.direction - s * disc.up));
    const glm::dmat2 index_from_world =
        glm::inverse(glm::dmat2(frame.worldFromIndex()[0].x, frame.worldFromIndex()[0].y, frame.worldFromIndex()[1].x,
                                frame.worldFromIndex()[1].y));
    const glm::dmat2 per_metre = index_from_world * glm::dmat2(along_x, along_y);
    return [=](int k) {
        const double depth = level - frame.worldFromIndex({0, 0, k}).z;
        const bool lit = refract ? depth > 0 : depth < 0;
        return LayerKernel{lit ? per_metre * std::fabs(depth) : glm::dmat2(0.0)};
    };
}

int discSamples(const OpticalScene& optics, const Light& light, int most) {
    const double radius = angularRadius(light);
    if (radius <= 0 || most <= 1) return 1;
    const TangentFrame disc(light.direction);
    const LightSample middle = lightSamples(light, 1).front();
    double sum = 0, power = 0;
    for (std::size_t s = 0; s < optics.scene().surfaces.size(); ++s) {
        const int surface = static_cast<int>(s);
        const Emission emission(optics.scene(), surface, middle);
        for (const EmittedRay& ray : somePoints(optics, emission, light)) {
            if (optics.arrival(ray.position, ray.direction) != PathOutcome::Lit) continue;
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
