// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bake/file/index_volume_file.h"
#include "bake/graded/object_samples.h"
#include "bake/report/monitor.h"
#include "bake/scene/graded_index.h"
#include "bake/scene/triangle_mesh.h"
#include "photic/bent_rays.h"
#include "tests/runtime/environment_map.h"
#include "tests/runtime/gpu_fixture.h"
#include "tests/runtime/scene_view.h"

namespace photic::test {

using namespace runtime;

inline std::vector<runtime::IndexVolume> readBack(const std::vector<IndexVolumeObject>& objects) {
    const std::string bytes = indexVolumeBytes(objects);
    auto volumes = readIndexVolumes(bytes.data(), bytes.size());
    if (!volumes) {
        ADD_FAILURE() << volumes.error().message;
        return {};
    }
    return *volumes;
}

inline GradedObject objectOf(std::shared_ptr<const GradedIndex> index) {
    GradedObject object;
    object.name = "object";
    object.index = {std::move(index)};
    return object;
}

/// An object as photic export writes it.
inline IndexVolumeObject exported(const GradedObject& object, double voxel) {
    Monitor monitor;
    ObjectSamples s = sampleObject({object}, 0, {voxel, {glm::dvec3(-1), glm::dvec3(1)}}, monitor);
    return {object.name,
            s.world_from_node,
            s.origin_world,
            s.count,
            s.spline,
            s.attenuation,
            s.glow,
            s.faces,
            object.scattering,
            object.anisotropy,
            s.box_low,
            s.box_high,
            s.sharp_sides,
            object.face.albedo,
            object.face.roughness,
            s.coat};
}

/// A ball of one index whose face is a smooth step of `width` nodes.
inline IndexVolumeObject ball(double n, double radius, double voxel, double width,
                              const glm::dvec3& centre = glm::dvec3(0)) {
    IndexVolumeObject object;
    object.name = "ball";
    const int half = static_cast<int>(std::ceil(radius / voxel + 3 * width)) + 4;
    object.count = glm::ivec3(2 * half + 1);
    object.world_from_node = glm::dmat3(voxel);
    object.origin_world = centre - voxel * half;
    object.box_low = glm::vec3(1), object.box_high = glm::vec3(2 * half - 1);
    object.spline.emplace_back();
    for (int z = -half; z <= half; ++z)
        for (int y = -half; y <= half; ++y)
            for (int x = -half; x <= half; ++x) {
                const double d = (radius / voxel - std::sqrt(double(x * x + y * y + z * z))) / width;
                const double t = std::clamp(0.5 + 0.5 * d, 0.0, 1.0);
                object.spline[0].push_back(static_cast<float>((n * n - 1) / 2 * t * t * (3 - 2 * t)));
                object.faces.push_back(std::fabs(d) < 2 ? 255 : 0);
            }
    return object;
}

/// An object that is a mesh, closed and of one index, with sharp faces. Nodes are 0.01 m.
inline IndexVolumeObject sharpMesh(const TriangleMesh& mesh, double n, bool smooth = true) {
    IndexVolumeObject object;
    object.name = "mesh";
    object.world_from_node = glm::dmat3(0.01);
    object.shape.emplace();
    object.shape->index = glm::dvec3(n);
    for (const glm::dvec3& p : mesh.positions) object.shape->positions.emplace_back(p / 0.01);
    for (const glm::dvec3& normal : mesh.normals)
        if (smooth) object.shape->normals.emplace_back(normal);
    object.shape->triangles = mesh.triangles;
    return object;
}
/// The same of a ball, exact.
inline IndexVolumeObject sharpBall(double n, double radius, const glm::dvec3& centre = glm::dvec3(0)) {
    IndexVolumeObject object = sharpMesh({}, n);
    object.name = "ball";
    object.shape->ball = glm::vec4(centre / 0.01, radius / 0.01);
    return object;
}

/// Fresnel's reflectance, averaged over both polarisations.
inline double fresnel(double cos_in, double n1, double n2) {
    const double sin_out = std::sqrt(1 - cos_in * cos_in) * n1 / n2;
    if (sin_out >= 1) return 1;
    const double cos_out = std::sqrt(1 - sin_out * sin_out);
    const double s = (n1 * cos_in - n2 * cos_out) / (n1 * cos_in + n2 * cos_out),
                 p = (n2 * cos_in - n1 * cos_out) / (n2 * cos_in + n1 * cos_out);
    return 0.5 * (s * s + p * p);
}

/// A slab across x, wide enough for all rays, with faces of some nodes or sharp sides.
inline IndexVolumeObject slab(double n, bool sharp, double absorption = 0) {
    IndexVolumeObject object;
    object.name = "slab";
    object.count = {41, 40, 40};
    object.world_from_node = {{0.02, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}};
    object.origin_world = {-0.4, -1.95, -1.95};
    object.box_low = sharp ? glm::vec3(10, 1, 1) : glm::vec3(1),
    object.box_high = sharp ? glm::vec3(30, 38, 38) : glm::vec3(39, 38, 38);
    object.sharp_sides = sharp;
    object.spline.emplace_back();
    for (int i = 0; i < 41 * 40 * 40; ++i) {
        const int x = i % 41;
        const bool inside = sharp || (x >= 10 && x <= 30);
        object.spline[0].push_back(inside ? static_cast<float>((n * n - 1) / 2) : 0.0F);
        object.faces.push_back(!sharp && (std::abs(x - 10) < 4 || std::abs(x - 30) < 4) ? 255 : 0);
        if (absorption > 0)
            object.attenuation.emplace_back(inside ? absorption : 0.0, 0.0F, 0.0F, inside ? 1.0F : 0.0F);
    }
    return object;
}

/// Light of one strength, 200 W/m2, along a direction, in a box around everything.
inline NvdbSpec evenLight(const glm::dvec3& along) {
    NvdbSpec spec;
    spec.min = {-2, -2, -2}, spec.max = {18, 18, 18};
    spec.world_from_index = {0.2, 0, 0, 0, 0.2, 0, 0, 0, 0.2};
    spec.origin_world = {-1.6, -1.6, -1.6};
    spec.json = R"({"reference_irradiance": 100})";
    const glm::vec3 flux(2.0 * glm::normalize(along));
    spec.values = [flux](int, int, int) -> LightValues { return {flux.x, flux.y, flux.z, 2, 2, 2, 2}; };
    return spec;
}

inline glm::dvec3 directionOf(const float* pixel) {
    return glm::normalize(glm::dvec3(pixel[0], pixel[1], pixel[2]) * 2.0 - 1.0);
}

/// Pixels that see an object, of surroundings whose radiance is 1, 2 and 0.5 everywhere: the same everywhere in them.
inline void expectUniform(const std::vector<float>& pixels) {
    int touched = 0;
    for (std::size_t i = 0; i < pixels.size(); i += 4) {
        if (pixels[i] < 0) continue;
        ++touched;
        EXPECT_NEAR(pixels[i], 1, 2e-5);
        EXPECT_NEAR(pixels[i + 1], 2, 4e-5);
        EXPECT_NEAR(pixels[i + 2], 0.5, 1e-5);
    }
    EXPECT_GT(touched, 300);
}

class BentRays : public WithGpu {
protected:
    void TearDown() override {
        pass_.reset();
        WithGpu::TearDown();
    }

    /// What an eye sees, row 0 at the bottom: RGBA, -1 where the pass left a pixel.
    std::vector<float> seen(const std::vector<IndexVolumeObject>& objects, const Eye& eye, Surroundings surroundings,
                            const BentRayOptions& options = {}, std::vector<PlacedObject> placed = {}) {
        const auto volumes = readBack(objects);
        auto gpu = GpuIndexVolumes::upload(*gpu_, volumes);
        if (!gpu) {
            ADD_FAILURE() << gpu.error().message;
            return {};
        }
        if (!pass_) {
            auto made = BentRayPass::create(*gpu_);
            if (!made) {
                ADD_FAILURE() << made.error().message;
                return {};
            }
            pass_ = std::make_unique<BentRayPass>(std::move(*made));
        }
        const DrawnView view(gl_, eye, [](const glm::dvec3&, const glm::dvec3&) { return std::nullopt; });
        view.fill(-1, -1, -1);
        GBuffer surfaces = view.surfaces;
        surfaces.depth = 0;
        for (unsigned i = 0; placed.size() < objects.size(); ++i)
            placed.push_back({i, PlacedObject{}.world_from_object});
        const Status drawn = pass_->draw(surfaces, view.target, *gpu, placed, surroundings, {}, options);
        EXPECT_TRUE(drawn.ok()) << drawn.error().message;
        return view.pixels();
    }

    Surroundings around(const DirectionMap& directions) const {
        Surroundings s;
        s.environment = directions.texture;
        return s;
    }

    std::unique_ptr<BentRayPass> pass_;  // its shaders take a second to compile: one a test
};

inline Eye eyeAt(const glm::dvec3& position, double degrees, int size = 64) {
    Eye eye;
    eye.position = position, eye.target = {0, 0, 0};
    eye.vertical_degrees = degrees, eye.width = size, eye.height = size;
    return eye;
}

inline constexpr double kDegree = M_PI / 180;

}  // namespace photic::test
