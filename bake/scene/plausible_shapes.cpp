// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/plausible_shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/scene/scattered_points.h"

namespace photic {
namespace {

using Warnings = std::vector<std::string>;

struct Bounds {
    glm::dvec3 low{std::numeric_limits<double>::infinity()}, high{-low};
    glm::dvec3 size() const { return high - low; }
    std::string inWords() const { return fmt::format("{:.3g} x {:.3g} x {:.3g} m", size().x, size().y, size().z); }
};

Bounds boundsOf(const TriangleMesh& mesh) {
    Bounds bounds;
    for (const glm::dvec3& p : mesh.positions)
        bounds.low = glm::min(bounds.low, p), bounds.high = glm::max(bounds.high, p);
    return bounds;
}

constexpr const char* kUnits =
    "if the file is not in metres, give a scale (centimetres: 0.01, millimetres: 0.001, inches: 0.0254)";

/// A sheet of water so much larger or smaller than the domain that its file must be in other units.
void otherUnits(const Scene& scene, const Surface& surface, Warnings& out) {
    // Seas may be wide, and few are as high as what they are baked over.
    constexpr double kTiny = 0.01, kWide = 20, kHigh = 1;
    const glm::dvec3 box = scene.domain.max - scene.domain.min;
    const Bounds bounds = boundsOf(*surface.mesh);
    const double wide = std::max(bounds.size().x, bounds.size().y), domain = std::max(box.x, box.y);
    if (wide < kTiny * domain)
        out.push_back(
            fmt::format("the water '{}' is {} large, in a domain of {:.3g} x {:.3g} m, so that next to no "
                        "light comes through it: give a larger scale",
                        surface.name, bounds.inWords(), box.x, box.y));
    if (wide > kWide * domain && bounds.size().z > kHigh * box.z)
        out.push_back(fmt::format("the water '{}' is {} large, around a domain of {:.3g} x {:.3g} x {:.3g} m: {}",
                                  surface.name, bounds.inWords(), box.x, box.y, box.z, kUnits));
}

void otherUnits(const Scene& scene, const Object& object, Warnings& out) {
    constexpr double kLarge = 10;  // along each axis: a floor or a landscape may be wide
    const auto* mesh = std::get_if<std::shared_ptr<const TriangleMesh>>(&object.shape);
    if (!mesh) return;
    const Bounds bounds = boundsOf(**mesh);
    const glm::dvec3 box = scene.domain.max - scene.domain.min;
    const double voxel = scene.domain.voxel_size;
    if (object.receives() && std::max({bounds.size().x, bounds.size().y, bounds.size().z}) < voxel)
        out.push_back(
            fmt::format("the receiver '{}' is {} large, less than a voxel of {:.3g} m: its light is that of "
                        "what lies around it; use a smaller voxel_size, or give a larger scale",
                        object.name, bounds.inWords(), voxel));
    if (glm::all(glm::greaterThan(bounds.size(), kLarge * box)))
        out.push_back(fmt::format("the object '{}' is {} large, around a domain of {:.3g} x {:.3g} x {:.3g} m: {}",
                                  object.name, bounds.inWords(), box.x, box.y, box.z, kUnits));
}

/// The mean square by which a mesh's normals depart from those that its own faces give, and by which those differ from
/// their mean.
struct Leaning {
    double from_faces = 0, of_faces = 0;
};
Leaning leaningOf(const TriangleMesh& mesh) {
    std::vector<glm::dvec3> faces(mesh.positions.size(), glm::dvec3(0));
    std::vector<double> weight(mesh.positions.size(), 0);
    for (const auto& t : mesh.triangles) {
        const auto& p = mesh.positions;
        const glm::dvec3 area = glm::cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
        for (const std::uint32_t corner : t) faces[corner] += area, weight[corner] += glm::length(area);
    }
    Leaning leaning;
    glm::dvec3 mean(0);
    double all = 0;
    for (std::size_t i = 0; i < faces.size(); ++i) {
        if (!(glm::length(faces[i]) > 0)) continue;
        const glm::dvec3 face = glm::normalize(faces[i]), off = mesh.normals[i] - face;
        leaning.from_faces += weight[i] * glm::dot(off, off);
        mean += weight[i] * face, all += weight[i];
    }
    if (!(all > 0)) return leaning;
    leaning.from_faces /= all;
    leaning.of_faces = std::max(0.0, 1 - glm::dot(mean, mean) / (all * all));
    return leaning;
}

/// Normals of a file that are not those of its shape, as of waves that were raised after the normals were made: light
/// is bent by the normals.
void normalsOfAnotherShape(const Surface& surface, Warnings& out) {
    constexpr double kOther = 0.5;     // of what the faces differ among one another; of a coarse sine it is 0.05
    constexpr double kNotSeen = 1e-4;  // the square of 0.6 degrees
    if (!surface.smooth || surface.sphere || surface.event == SurfaceEvent::Mirror) return;
    const Leaning leaning = leaningOf(*surface.mesh);
    if (leaning.of_faces < kNotSeen || leaning.from_faces < std::max(kNotSeen, kOther * leaning.of_faces)) return;
    const double degrees = 2 * std::asin(std::min(1.0, 0.5 * std::sqrt(leaning.from_faces))) * 57.29577951308232;
    out.push_back(fmt::format(
        "the normals in the file of '{}' lean by {:.2g} degrees (root mean square) from those of its faces, "
        "and light is bent by the normals, as if the shape were another; export it without normals, or "
        "with ones made anew",
        surface.name, degrees));
}

/// Water that bends nothing, since its index is that of what lies above it.
void bendsNothing(const Surface& surface, Warnings& out) {
    const bool refracts = surface.event == SurfaceEvent::Refract || surface.event == SurfaceEvent::Both;
    if (!refracts || surface.thin || surface.medium_above >= 0 || surface.medium_below >= 0) return;
    if (surface.ior_above == surface.ior_below)
        out.push_back(
            fmt::format("'{}' bends no light: its index is {} on both sides; for water give ior_below = "
                        "1.333, for glass 1.5",
                        surface.name, surface.ior_below));
}

void twoInOnePlace(const Scene& scene, Warnings& out) {
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const Surface &a = scene.surfaces[j], &b = scene.surfaces[i];
            if (!a.mesh || !b.mesh || a.mesh->positions != b.mesh->positions) continue;
            out.push_back(
                fmt::format("'{}' lies exactly where '{}' does, with all of its {} triangles: light is bent twice "
                            "there; leave one of them out",
                            b.name, a.name, a.mesh->triangles.size()));
        }
}

/// Mean squares of a height field's height and slope along its patch's rim, as a part of those within.
double rimShare(const Surface& surface) {
    constexpr int kPlaces = 256;
    constexpr double kWithin = 0.98;  // where a map fades out is its own affair
    double rim = 0, within = 0;
    const auto squares = [&](glm::dvec2 part) {
        const SurfacePoint point = surface.height_field->at(glm::dvec2(surface.center) + surface.size * part);
        const glm::dvec2 slope = point.normal.z > 0 ? glm::dvec2(point.normal) / point.normal.z : glm::dvec2(0);
        const double height = (point.position.z - surface.center.z) / std::max(surface.size.x, surface.size.y);
        return glm::dot(slope, slope) + height * height;
    };
    for (int i = 0; i < kPlaces; ++i) {
        const glm::dvec2 place = scatteredPoint(i) - 0.5;
        within += squares(kWithin * place);
        rim += squares(i % 2 == 0 ? glm::dvec2(place.x, i % 4 == 0 ? 0.5 : -0.5) * kWithin
                                  : glm::dvec2(i % 4 == 1 ? 0.5 : -0.5, place.y) * kWithin);
    }
    return within > 0 ? rim / within : 0;
}

/// The horizontal way of a sun's light through level water, for each metre down.
glm::dvec2 runBelow(const Light& light, const Surface& surface) {
    const double across = glm::length(glm::dvec2(light.direction));
    const double sine = across * surface.ior_above / surface.ior_below;
    if (!(sine < 1) || across == 0) return glm::dvec2(0);
    return glm::dvec2(light.direction) / across * (sine / std::sqrt(1 - sine * sine));
}

/// Waves end with their patch, and beyond it the water is flat: light that comes in there lights the domain evenly.
void flatBesideThePatch(const Scene& scene, const Surface& surface, Warnings& out) {
    constexpr double kAtRest = 0.01;  // of the mean squares within: waves that die away before the rim
    constexpr double kNotSeen = 0.01;
    constexpr int kPlaces = 10000;
    if (!surface.height_field || surface.outside != Outside::Flat || surface.event != SurfaceEvent::Refract) return;
    if (!std::isfinite(surface.height_field->featureSize()) || rimShare(surface) < kAtRest) return;
    const Domain& box = scene.domain;
    const double level = surface.center.z;
    if (box.min.z >= level) return;
    const glm::dvec2 center(surface.center), half = 0.5 * surface.size;
    for (const Light& light : scene.lights) {
        if (light.position || light.direction.z >= 0) continue;
        const glm::dvec2 run = runBelow(light, surface);
        int beside = 0;
        glm::dvec2 reach(0);  // of what light comes in through
        for (int i = 0; i < kPlaces; ++i) {
            const glm::dvec2 part = scatteredPoint(i);
            const double depth = (level - box.min.z) * (i + 0.5) / kPlaces;
            const glm::dvec2 place = glm::dvec2(box.min) + glm::dvec2(box.max - box.min) * part - depth * run - center;
            reach = glm::max(reach, glm::abs(place));
            beside += glm::any(glm::greaterThan(glm::abs(place), half));
        }
        if (beside < kNotSeen * kPlaces) continue;
        if (beside == kPlaces) {
            out.push_back(fmt::format(
                "no light that comes into the domain passes the waves of '{}': its patch lies about ({:.6g}, {:.6g}), "
                "{:.3g} x {:.3g} m, and beside it the water is flat; move it, or the domain",
                surface.name, center.x, center.y, surface.size.x, surface.size.y));
            continue;
        }
        out.push_back(fmt::format(
            "{:.3g} % of the water in the domain gets the light of '{}' through flat water beside the patch of '{}', "
            "where its waves end ({:.3g} x {:.3g} m): a strip without caustics, with an edge; make the patch {:.3g} x "
            "{:.3g} m, or give outside = \"periodic\"",
            100.0 * beside / kPlaces, light.name, surface.name, surface.size.x, surface.size.y,
            std::ceil(20 * reach.x * 1.05) / 10, std::ceil(20 * reach.y * 1.05) / 10));
    }
}

}  // namespace

std::vector<std::string> shapeWarnings(const Scene& scene) {
    Warnings out;
    for (const Surface& surface : scene.surfaces) {
        flatBesideThePatch(scene, surface, out);
        if (!scene.index) bendsNothing(surface, out);
        if (!surface.mesh) continue;
        const bool refracts = surface.event == SurfaceEvent::Refract || surface.event == SurfaceEvent::Both;
        if (refracts && !surface.closed && !surface.thin) otherUnits(scene, surface, out);
        normalsOfAnotherShape(surface, out);
    }
    for (const Object& object : scene.objects) otherUnits(scene, object, out);
    twoInOnePlace(scene, out);
    return out;
}

}  // namespace photic
