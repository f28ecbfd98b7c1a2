// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/plane_light.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>

#include "bake/field/disc_blur.h"
#include "bake/field/scene_grid.h"
#include "bake/methods/beams.h"
#include "bake/methods/catalogue.h"
#include "bake/methods/sun_disc.h"
#include "bake/optics/snell.h"

namespace photic {
namespace {

constexpr std::int64_t kDiscSamples = 8;
constexpr double kSilhouette = 0.5;  // [texels] of a shadow's edge, which the mean over a texel hides

/// The progress and the warnings of a bake within a bake are nobody's.
class QuietMonitor final : public Monitor {
public:
    explicit QuietMonitor(const Monitor& of) : of_(of) {}
    bool cancelled() const override { return of_.cancelled(); }

private:
    const Monitor& of_;
};

/// One layer of voxels, whose middle is the plane.
GridFrame layerOf(const PlaneTexels& texels) {
    return {glm::dmat3(texels.right, texels.up, texels.normal * texels.side()), texels.centre(0, 0), glm::ivec3(0),
            glm::ivec3(texels.columns - 1, texels.rows - 1, 0)};
}

/// A light of the scene on the layer: what comes to its front is the first lobe.
Scene onPlane(const Scene& scene, const Light& light, const PlaneTexels& texels, double tolerance) {
    Scene one = scene;
    one.lights = {light};
    one.bake.lobe_axis = -texels.normal;
    one.bake.quadrature = 1;
    one.bake.tolerance = tolerance / texels.side();
    one.bake.grids = GridSet{};
    return one;
}

GivenOptions optionsFor(const Scene& scene, bool blurred) {
    const std::string where = "planeIrradiance";
    GivenOptions options{{"silhouette", {kSilhouette, where}}};
    options["disc"] = {std::string(blurred ? "off" : "sample"), where};
    if (!blurred) options["disc_samples"] = {kDiscSamples, where};
    // A ray a texel: where tubes are as narrow as what they are shared out over, their bends are hidden by its mean.
    // Not so off glass and mirrors, whose light may spread from one texel over hundreds: there the tolerance decides.
    const bool bodies = std::any_of(scene.surfaces.begin(), scene.surfaces.end(),
                                    [](const Surface& s) { return s.height_field == nullptr; });
    if (!bodies) options["spacing"] = {1.0, where};
    return options;
}

/// The disc's image in the plane at some depth below the surface, in texels: where light lands on a level plane, slid
/// along the light into this one.
LayerKernel kernelAt(const Surface& surface, const Light& light, const PlaneTexels& texels, double depth) {
    const Interface i = interfaceAt(light.direction, {0, 0, 1}, surface.ior_above, surface.ior_below);
    const glm::dvec3 way = surface.event == SurfaceEvent::Refract ? i.refracted : i.reflected;
    const double facing = glm::dot(texels.normal, way);
    const glm::dmat2 level = discSlopes(surface, light) * std::fabs(depth);
    LayerKernel kernel;
    for (int radius = 0; radius < 2; ++radius) {
        const glm::dvec3 moved(level[radius], 0);
        const glm::dvec3 in_plane = moved - way * (glm::dot(texels.normal, moved) / facing);
        const double side = texels.side();
        kernel.disc_from_unit[radius] = {glm::dot(in_plane, texels.right) / (side * side),
                                         glm::dot(in_plane, texels.up) / (side * side)};
    }
    return kernel;
}

void blurRows(const Surface& surface, const Light& light, const PlaneTexels& texels, std::vector<float>& light_map) {
    const std::vector<float> sharp = light_map;
    const double level = 0.5 * (surface.height_field->minZ() + surface.height_field->maxZ());
    for (int j = 0; j < texels.rows; ++j) {
        const LayerKernel kernel = kernelAt(surface, light, texels, level - texels.centre(0, j).z);
        const double reach = std::max(std::hypot(kernel.disc_from_unit[0].x, kernel.disc_from_unit[1].x),
                                      std::hypot(kernel.disc_from_unit[0].y, kernel.disc_from_unit[1].y));
        constexpr double kWidest = 60;  // texels: light that grazes the plane
        if (!(reach < kWidest)) continue;
        const DiscStencil stencil = discStencil(kernel);
        if (stencil.radius == 0) continue;
        for (int i = 0; i < texels.columns; ++i) {
            double sum = 0, weights = 0;
            for (int dy = -stencil.radius; dy <= stencil.radius; ++dy)
                for (int dx = -stencil.radius; dx <= stencil.radius; ++dx) {
                    const int x = i + dx, y = j + dy;
                    if (x < 0 || y < 0 || x >= texels.columns || y >= texels.rows) continue;
                    const double w = stencil.at(dx, dy);
                    sum += w * double(sharp[static_cast<std::size_t>(y * texels.columns + x)]), weights += w;
                }
            if (weights > 0)
                light_map[static_cast<std::size_t>(j * texels.columns + i)] = static_cast<float>(sum / weights);
        }
    }
}

bool blurs(const Scene& scene, const Light& light) {
    return light.angular_diameter_deg > 0 && blurServes(scene, light, sceneFrame(scene));
}

}  // namespace

double PlaneTexels::side() const { return glm::length(right); }

std::string planeLightRefusal(const Scene& scene) { return beamsMethod().refusal(scene); }

std::vector<float> planeIrradiance(const Scene& scene, const PlaneTexels& texels, double tolerance,
                                   const Monitor& monitor) {
    const GridFrame frame = layerOf(texels);
    const auto needed = std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame));
    std::vector<float> all(static_cast<std::size_t>(texels.columns) * static_cast<std::size_t>(texels.rows));
    const Method method = beamsMethod();
    for (const Light& light : scene.lights) {
        QuietMonitor quiet(monitor);
        const bool blurred = blurs(scene, light);
        const BakeResult result =
            method.bake(onPlane(scene, light, texels, tolerance), needed, optionsFor(scene, blurred), quiet);
        std::vector<float> own(all.size());
        std::size_t n = 0;
        for (int j = 0; j < texels.rows; ++j)
            for (int i = 0; i < texels.columns; ++i)
                own[n++] = static_cast<float>(std::max(0.0, -glm::dot(texels.normal, result.field.flux({i, j, 0}))));
        if (blurred) blurRows(scene.surfaces.front(), light, texels, own);
        for (std::size_t i = 0; i < all.size(); ++i) all[i] += own[i];
    }
    return all;
}

bool planeLightIsQuick(const Scene& scene) {
    return std::all_of(scene.lights.begin(), scene.lights.end(),
                       [&](const Light& light) { return light.angular_diameter_deg <= 0 || blurs(scene, light); });
}

double planeLightSeconds(const Scene& scene, const PlaneTexels& texels, double tolerance) {
    const GridFrame frame = layerOf(texels);
    double seconds = 0;
    for (const Light& light : scene.lights) {
        const Scene one = onPlane(scene, light, texels, tolerance);
        const GivenOptions options = optionsFor(scene, blurs(scene, light));
        const double voxels = static_cast<double>(frame.voxelCount());
        for (const Stage& stage : beamsMethod().cost({one, frame, voxels, options}).stages) seconds += stage.seconds;
    }
    return seconds;
}

}  // namespace photic
