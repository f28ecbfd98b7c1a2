// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

#include "bake/scene/scene.h"

/// Small scenes for the tests of the methods, built without files.
namespace photic::test_scenes {

/// z = amplitude cos(wavenumber x); flat for amplitude 0.
class CosineField final : public HeightField {
public:
    CosineField(double amplitude, double wavenumber) : a_(amplitude), k_(wavenumber) {}
    SurfacePoint at(glm::dvec2 uv) const override {
        return {{uv.x, uv.y, a_ * std::cos(k_ * uv.x)}, {a_ * k_ * std::sin(k_ * uv.x), 0, 1}};
    }
    double minZ() const override { return -std::fabs(a_); }
    double maxZ() const override { return std::fabs(a_); }
    double featureSize() const override {
        return a_ == 0 ? std::numeric_limits<double>::infinity() : 2 * std::numbers::pi / k_ / 8;
    }

private:
    double a_, k_;
};

inline GridFrame boxFrame(const glm::dvec3& low, const glm::ivec3& size, const glm::dvec3& voxel) {
    return {glm::dmat3(voxel.x, 0, 0, 0, voxel.y, 0, 0, 0, voxel.z), low + 0.5 * voxel, glm::ivec3(0), size - 1};
}

/// Water z = 0 or a wave about it, one sun of 1 W/m2 at `zenith` [rad] towards +x and a little +y.
inline Scene waterScene(double zenith, std::shared_ptr<const HeightField> field = std::make_shared<CosineField>(0, 1)) {
    Scene scene;
    scene.file = "test.toml";
    Light sun;
    sun.name = "sun";
    sun.direction = {std::sin(zenith) * 0.8, std::sin(zenith) * 0.6, -std::cos(zenith)};
    sun.irradiance = glm::dvec3(1);
    scene.lights = {sun};
    Surface water;
    water.name = "water";
    water.height_field = std::move(field);
    water.size = {4, 4};
    water.outside = Outside::Flat;
    scene.surfaces = {water};
    return scene;
}

/// A rectangle of two triangles; its normal is along cross(u, v).
inline std::shared_ptr<TriangleMesh> rectangle(const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v) {
    auto mesh = std::make_shared<TriangleMesh>();
    mesh->positions = {corner, corner + u, corner + u + v, corner + v};
    mesh->normals.assign(4, glm::normalize(glm::cross(u, v)));
    mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

inline Object planeObject(const glm::dvec3& point, const glm::dvec3& normal, Role role = Role::Receiver) {
    Object object;
    object.name = "plane";
    object.shape = Plane{point, normal};
    object.role = role;
    return object;
}

inline Object meshObject(std::shared_ptr<const TriangleMesh> mesh, Role role) {
    Object object;
    object.name = "mesh";
    object.shape = std::move(mesh);
    object.role = role;
    return object;
}

}  // namespace photic::test_scenes
