// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/crest_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bake/scene/surface_samples.h"

namespace photic {
namespace {

/// Height of a field above a point of the world's plane: the parameter is sought whose displaced position lies there.
double heightAbove(const HeightField& field, glm::dvec2 place) {
    glm::dvec2 uv = place;
    SurfacePoint point = field.at(uv);
    for (int i = 0; i < 4 && field.maxDisplacement() > 0; ++i) {
        uv -= glm::dvec2(point.position) - place;
        point = field.at(uv);
    }
    return point.position.z;
}

/// Whether the surface itself lies between a place on it and the sun.
bool behindACrest(const HeightField& field, const glm::dvec3& place, const glm::dvec3& light) {
    const double rise = -light.z, longest = (field.maxZ() - place.z) / rise;
    const double along = glm::length(glm::dvec2(light));
    const double wanted = 4 * longest * along / field.featureSize();
    const int steps = static_cast<int>(std::clamp(wanted, 16.0, 256.0));
    for (int i = 1; i < steps; ++i) {
        const glm::dvec3 p = place - light * (longest * i / steps);
        if (p.z < heightAbove(field, glm::dvec2(p))) return true;
    }
    return false;
}

}  // namespace

std::vector<std::string> crestWarnings(const Scene& scene) {
    std::vector<std::string> out;
    for (const Surface& surface : scene.surfaces) {
        if (!surface.height_field || !std::isfinite(surface.height_field->featureSize())) continue;
        const std::vector<SurfaceSample> samples = samplesOf(surface, scene.domain, 1024);
        for (const Light& light : scene.lights) {
            if (light.position || light.direction.z >= 0) continue;
            // A smooth surface stands in its own light only where a part of it turns away from it.
            if (std::none_of(samples.begin(), samples.end(), [&](const SurfaceSample& sample) {
                    return -glm::dot(light.direction, sample.normal) < 0.02;
                }))
                continue;
            double shaded = 0, all = 0;
            for (const SurfaceSample& sample : samples) {
                const double lit = -glm::dot(light.direction, sample.normal) * sample.area;
                if (lit <= 0) continue;
                all += lit;
                if (behindACrest(*surface.height_field, sample.position, light.direction)) shaded += lit;
            }
            if (shaded > 1e-3 * all)
                out.push_back(
                    fmt::format("{:.3g} % of the light of '{}' on '{}' ({:.3g} W in the domain) falls behind a crest: "
                                "waves do not shade each other in this method, so that light is baked as if it "
                                "arrived; raise the light, lower the waves, or choose a method that follows rays",
                                100 * shaded / all, light.name, surface.name, meanIrradiance(light) * shaded));
        }
    }
    return out;
}

}  // namespace photic
