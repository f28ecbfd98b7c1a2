// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "bake/methods/catalogue.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/scene.h"
#include "tests/support/tube_scenes.h"

namespace photic::test {

/// A scene without water: a sun of 1 W/m2 straight down, and a grid of `cells`^3 voxels over [-1, 1]^3.
struct GlassScene {
    Scene scene;
    GridFrame frame;
    explicit GlassScene(int cells, const glm::dvec3& sun = {0, 0, -1}) {
        scene.file = "test.toml";
        Light light;
        light.name = "sun", light.direction = glm::normalize(sun), light.irradiance = glm::dvec3(1);
        scene.lights.push_back(light);
        Medium air, glass;
        air.name = "air", glass.name = "glass", glass.ior = 1.5;
        scene.media = {air, glass};
        const double h = 2.0 / cells;
        frame = GridFrame(glm::dmat3(h), glm::dvec3(0.5 * h), glm::ivec3(-cells / 2), glm::ivec3(cells / 2 - 1));
        scene.domain.min = glm::dvec3(-1), scene.domain.max = glm::dvec3(1), scene.domain.voxel_size = h;
    }
    Surface& add(TriangleMesh mesh, SurfaceEvent event) {
        Surface surface;
        surface.name = "glass", surface.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
        surface.event = event, surface.closed = true, surface.medium_above = 0, surface.medium_below = 1;
        scene.surfaces.push_back(surface);
        return scene.surfaces.back();
    }
    Surface& addSphere(const glm::dvec3& centre, double radius, SurfaceEvent event) {
        Surface& surface = add(support::sphereMesh(24, centre, radius), event);
        surface.sphere = Sphere{centre, radius}, surface.center = centre;
        return surface;
    }
    BakeResult bake(const Method& method, const GivenOptions& options = {}) const {
        Monitor monitor;
        return method.bake(scene, std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame)), options,
                           monitor);
    }
};

inline GivenOptions option(const std::string& name, OptionValue value) { return {{name, {std::move(value), "test"}}}; }

/// Sum of |a - b| over the voxels over the sum of b, in the mean of the channels.
inline double relativeL1(const LightField& a, const LightField& b) {
    double apart = 0, sum = 0;
    const GridFrame& frame = a.frame();
    for (int x = frame.min.x; x <= frame.max.x; ++x)
        for (int y = frame.min.y; y <= frame.max.y; ++y)
            for (int z = frame.min.z; z <= frame.max.z; ++z)
                apart += std::fabs(a.irradiance({x, y, z}) - b.irradiance({x, y, z})), sum += b.irradiance({x, y, z});
    return apart / sum;
}

}  // namespace photic::test
