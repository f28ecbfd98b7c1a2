// SPDX-License-Identifier: Apache-2.0
// Small scenes and a grid around them, for the tests of paths and tubes.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "bake/field/grid_frame.h"
#include "bake/scene/scene.h"
#include "bake/scene/wave_field.h"

namespace photic::support {

/// Crossed sines [m], gentle enough for each ray to go on through z layers.
class Ripples final : public HeightField {
public:
    Ripples(double amplitude, double wave_number) : a_(amplitude), k_(wave_number) {}
    SurfacePoint at(glm::dvec2 p) const override {
        const double x = p.x * k_, y = p.y * k_ * 1.3;
        return {{p.x, p.y, a_ * (std::sin(x) + std::cos(y))}, {-a_ * k_ * std::cos(x), a_ * k_ * 1.3 * std::sin(y), 1}};
    }
    double minZ() const override { return -2 * a_; }
    double maxZ() const override { return 2 * a_; }
    double featureSize() const override { return 2 * 3.14159265358979 / (1.3 * k_) / 8; }

private:
    double a_, k_;
};

/// A box of two triangles a side, wound outwards.
inline TriangleMesh boxMesh(const glm::dvec3& low, const glm::dvec3& high) {
    TriangleMesh mesh;
    for (unsigned c = 0; c < 8; ++c) {
        mesh.positions.push_back({c & 1 ? high.x : low.x, c & 2 ? high.y : low.y, c & 4 ? high.z : low.z});
        mesh.normals.push_back(glm::normalize(mesh.positions.back() - 0.5 * (low + high)));
    }
    for (const auto& q : {std::array<std::uint32_t, 4>{0, 2, 3, 1},
                          {4, 5, 7, 6},
                          {0, 1, 5, 4},
                          {2, 6, 7, 3},
                          {0, 4, 6, 2},
                          {1, 3, 7, 5}})
        mesh.triangles.push_back({q[0], q[1], q[2]}), mesh.triangles.push_back({q[0], q[2], q[3]});
    return mesh;
}

/// A sphere of 2 n (2 n - 2) triangles, wound outwards, with smooth normals.
inline TriangleMesh sphereMesh(int n, const glm::dvec3& centre, double radius) {
    TriangleMesh mesh;
    const int columns = 2 * n;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i < columns; ++i) {
            const double theta = 3.14159265358979323846 * j / n, phi = 2 * 3.14159265358979323846 * i / columns;
            const glm::dvec3 d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
            mesh.positions.push_back(centre + radius * d), mesh.normals.push_back(d);
        }
    const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * columns + i % columns); };
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < columns; ++i) {
            if (j > 0) mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            if (j + 1 < n) mesh.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
        }
    return mesh;
}

inline Object meshObject(TriangleMesh mesh, Role role = Role::Receiver) {
    Object out;
    out.name = "mesh", out.shape = std::make_shared<const TriangleMesh>(std::move(mesh)), out.role = role;
    return out;
}

inline Object planeObject(const glm::dvec3& point, const glm::dvec3& normal, Role role = Role::Receiver) {
    Object out;
    out.name = "plane", out.shape = Plane{point, glm::normalize(normal)}, out.role = role;
    return out;
}

/// Water over [-1, 1]^2 with a sun; a grid of 40 x 40 x 40 voxels of 5 cm from z = -1.9 up to 0.1.
struct WaterScene {
    Scene scene;
    GridFrame frame;
    explicit WaterScene(std::shared_ptr<const HeightField> water, const glm::dvec3& sun = {0, 0, -1}) {
        Surface surface;
        surface.name = "water", surface.height_field = std::move(water), surface.size = {2, 2};
        surface.outside = Outside::Flat;
        scene.surfaces.push_back(surface);
        Light light;
        light.direction = glm::normalize(sun), light.irradiance = glm::dvec3(1);
        scene.lights.push_back(light);
        scene.domain.min = {-1, -1, -1.9}, scene.domain.max = {1, 1, 0.1}, scene.domain.voxel_size = 0.05;
        frame.setWorldFromIndex(glm::dmat3(0.05));
        frame.origin_world = {0.025, 0.025, 0.025};
        frame.min = {-20, -20, -38}, frame.max = {19, 19, 1};
    }
    explicit WaterScene(const glm::dvec3& sun = {0, 0, -1}) : WaterScene(makeFlatField(0), sun) {}
};

}  // namespace photic::support
