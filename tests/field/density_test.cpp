// SPDX-License-Identifier: Apache-2.0
#include "bake/field/density.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace photic {
namespace {

/// z = 0.3 x + 0.1, or moved along x by 0.2 sin(3 u) with the height of where it came from.
class Slope final : public HeightField {
public:
    explicit Slope(double displacement) : displacement_(displacement) {}
    SurfacePoint at(glm::dvec2 uv) const override {
        return {{uv.x + displacement_ * std::sin(3 * uv.x), uv.y, 0.3 * uv.x + 0.1}, {-0.3, 0, 1}};
    }
    double minZ() const override { return -10; }
    double maxZ() const override { return 10; }
    double maxDisplacement() const override { return displacement_; }
    double featureSize() const override { return 1; }

private:
    double displacement_;
};

GridFrame frameOf(double voxel_size) {
    GridFrame frame;
    frame.setWorldFromIndex(glm::dmat3(voxel_size));
    frame.origin_world = glm::dvec3(voxel_size / 2);
    frame.min = glm::ivec3(std::lround(-1 / voxel_size));
    frame.max = glm::ivec3(std::lround(1 / voxel_size) - 1);
    return frame;
}

Scene sceneWith(std::shared_ptr<const HeightField> heights, std::shared_ptr<const TriangleMesh> mesh) {
    Scene scene;
    Surface surface;
    surface.height_field = std::move(heights);
    surface.mesh = std::move(mesh);
    scene.surfaces.push_back(surface);
    return scene;
}

LightField densityOf(const Scene& scene, const GridFrame& frame) {
    return mediumDensity(scene, std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame)));
}

/// A quadrilateral with z = 0.3 x + 0.1 over |x|, |y| <= half, its normal up or down.
std::shared_ptr<TriangleMesh> slopeMesh(double half, bool up, double raise = 0) {
    auto mesh = std::make_shared<TriangleMesh>();
    for (const glm::dvec2 c : {glm::dvec2(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
        mesh->positions.push_back({c.x * half, c.y * half, 0.3 * c.x * half + 0.1 + raise});
    }
    mesh->normals.assign(4, {0, 0, up ? 1 : -1});
    mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
    if (!up) mesh->triangles = {{0, 2, 1}, {0, 3, 2}};
    return mesh;
}

TEST(SurfaceAbove, UndoesHorizontalDisplacement) {
    const Slope slope(0.2);
    for (double x = -1; x <= 1; x += 0.13) {
        const SurfacePoint point = surfaceAbove(slope, {x, 0.4});
        EXPECT_NEAR(point.position.x, x, 1e-6);
        EXPECT_NEAR(point.position.y, 0.4, 1e-12);
    }
}

TEST(MediumDensity, FillsBelowAHeightField) {
    const GridFrame frame = frameOf(0.0625);
    const LightField density = densityOf(sceneWith(std::make_shared<Slope>(0), nullptr), frame);
    for (int i = frame.min.x; i <= frame.max.x; i += 3) {
        for (int k = frame.min.z; k <= frame.max.z; ++k) {
            const glm::dvec3 p = frame.worldFromIndex({i, 5, k});
            const double expected = std::clamp((0.3 * p.x + 0.1 - p.z) / 0.0625 + 0.5, 0.0, 1.0);
            EXPECT_NEAR(static_cast<double>(density.value({i, 5, k}, 0)), expected, 1e-6);
        }
    }
}

TEST(MediumDensity, ItsVolumeIsThatBelowTheSurface) {
    // 2 x 2 m, from z = -1 to a mean height of 0.1 m. Exact for a plane but for the columns' sampling.
    for (const double h : {0.25, 0.125, 0.0625}) {
        const LightField density = densityOf(sceneWith(std::make_shared<Slope>(0), nullptr), frameOf(h));
        EXPECT_NEAR(density.sum(0) * h * h * h, 4 * 1.1, 1e-5) << h;
    }
}

TEST(MediumDensity, AMeshFillsTheColumnsThatItCoversOnTheSideAwayFromItsNormal) {
    const GridFrame frame = frameOf(0.0625);
    const LightField heights = densityOf(sceneWith(std::make_shared<Slope>(0), nullptr), frame);
    const LightField up = densityOf(sceneWith(nullptr, slopeMesh(0.5, true)), frame);
    const LightField down = densityOf(sceneWith(nullptr, slopeMesh(0.5, false)), frame);
    for (int i = frame.min.x; i <= frame.max.x; ++i) {
        for (int j = frame.min.y; j <= frame.max.y; ++j) {
            const glm::dvec3 p = frame.worldFromIndex({i, j, 0});
            const bool covered = std::fabs(p.x) < 0.5 && std::fabs(p.y) < 0.5;
            for (int k = frame.min.z; k <= frame.max.z; k += 2) {
                const auto below = static_cast<double>(heights.value({i, j, k}, 0));
                EXPECT_NEAR(static_cast<double>(up.value({i, j, k}, 0)), covered ? below : 0, 1e-6);
                EXPECT_NEAR(static_cast<double>(down.value({i, j, k}, 0)), covered ? 1 - below : 0, 1e-6);
            }
        }
    }
}

TEST(MediumDensity, ColumnsLeanWithAShearedGrid) {
    GridFrame frame = frameOf(0.0625);
    frame.setWorldFromIndex({0.0625, 0, 0, 0, 0.0625, 0, 0.02, -0.01, 0.0625});
    const LightField heights = densityOf(sceneWith(std::make_shared<Slope>(0), nullptr), frame);
    const LightField mesh = densityOf(sceneWith(nullptr, slopeMesh(20, true)), frame);
    double difference = 0;
    for (int slot = 0; slot < mesh.leafCount(); ++slot) {
        const glm::ivec3 v = mesh.needed().leafOrigin(slot) + 3;
        // Along a leaning column the surface is crossed elsewhere than right above: they agree to the slope's part of
        // it.
        difference = std::max(difference, std::fabs(static_cast<double>(heights.value(v, 0) - mesh.value(v, 0))));
    }
    EXPECT_LT(difference, 0.5 * 0.3 * 0.02 / 0.0625 + 0.02);
    EXPECT_NEAR(mesh.sum(0) / heights.sum(0), 1, 1e-3);
}

TEST(MediumDensity, MirrorsHoldNoMedium) {
    Scene scene = sceneWith(std::make_shared<Slope>(0), nullptr);
    scene.surfaces[0].event = SurfaceEvent::Reflect;
    EXPECT_EQ(densityOf(scene, frameOf(0.25)).sum(0), 0);
}

}  // namespace
}  // namespace photic
