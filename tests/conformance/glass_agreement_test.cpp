// SPDX-License-Identifier: Apache-2.0
// Every scene of examples/glass against photons, voxel by voxel, in units of the photons' own standard error. It prints
// the table of docs/accuracy.md.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <variant>

#include "bake/field/deviations.h"
#include "bake/paths/triangle_tree.h"
#include "bake/scene/load_toml.h"
#include "tests/conformance/bake_scene.h"

namespace photic {
namespace {

constexpr std::int64_t kShifts = 256;    ///< Student's t of so many repeats adds 0.6 % to chi^2/n
constexpr double kMost = 0.01;           ///< standard error of the voxels compared, of their light
constexpr double kBias = 0.005;          ///< allowance, added to it in quadrature
constexpr double kAtSilhouettes = 1e-3;  ///< of the power, lost where bodies begin and end
constexpr double kLedger = 1e-5;
constexpr double kCareful = 0.02;  ///< tolerance that tubes converge to [voxels]

struct Example {
    const char* name;
    int resolution;
    std::int64_t photons;
    double usual,
        careful;    ///< bias of voxels that no surface cuts, at the default tolerance and a careful one; 0: not baked
    double twelve;  ///< at the careful one with twelve points a layer
    double finer;   ///< the same of means over 3^3 voxels a third as wide, at the default tolerance; 0: not baked
};

struct Compared {
    Deviations away, cut;  ///< of voxels that no surface or object reaches into, and of the others
};

/// Voxels that photons know well, by how far tubes are from them.
Compared compare(const TriangleTree& tree, const std::function<double(const glm::ivec3&)>& tubes,
                 const Baked& photons) {
    const GridFrame& frame = photons.field().frame();
    const LightField& error = photons.result.standard_error->field;
    Compared out;
    for (int k = frame.min.z; k <= frame.max.z; ++k)
        for (int j = frame.min.y; j <= frame.max.y; ++j)
            for (int i = frame.min.x; i <= frame.max.x; ++i) {
                const double light = photons.irradiance(i, j, k), s = error.value({i, j, k}, 0);
                const double found = tubes({i, j, k});
                if (!(s > 0 && s <= kMost * light) || !std::isfinite(found)) continue;
                ConvexRegion voxel;
                voxel.include(frame.worldFromIndex(glm::dvec3(i, j, k) - 0.5));
                voxel.include(frame.worldFromIndex(glm::dvec3(i, j, k) + 0.5));
                (tree.reaches(voxel) ? out.cut : out.away).add(found, light, s);
            }
    return out;
}

Compared compare(const TriangleTree& tree, const Baked& tubes, const Baked& photons) {
    return compare(
        tree, [&](const glm::ivec3& v) { return tubes.irradiance(v.x, v.y, v.z); }, photons);
}

/// Whether a voxel lies before all planes as a whole: behind them light goes on for two voxels, of whatever width.
bool liesBeforePlanes(const Scene& scene, const GridFrame& frame, const glm::ivec3& voxel) {
    const glm::dvec3 centre = frame.worldFromIndex(glm::dvec3(voxel));
    for (const Object& object : scene.objects) {
        const Plane* plane = std::get_if<Plane>(&object.shape);
        const glm::dvec3 half = 0.5 * glm::dvec3(frame.worldFromIndex()[0][0]);
        if (plane && glm::dot(centre - plane->point, plane->normal) < glm::dot(half, glm::abs(plane->normal)))
            return false;
    }
    return true;
}

/// Of tubes in voxels a third as wide: the mean over the 3^3 that a voxel holds. Those that reach out of the finer
/// grid, which ends nearer to the scene's box, or behind a plane are left out.
Compared compareFiner(const Scene& scene, const TriangleTree& tree, const Baked& finer, const Baked& photons) {
    const auto mean = [&](const glm::ivec3& v) {
        const glm::dvec3 centre = photons.field().frame().worldFromIndex(glm::dvec3(v));
        const glm::dvec3 index = finer.field().frame().indexFromWorld(centre);
        const glm::ivec3 middle(glm::round(index));
        EXPECT_LT(glm::length(index - glm::dvec3(middle)), 1e-6) << "voxels do not hold one another";
        const GridFrame& frame = finer.field().frame();
        if (glm::any(glm::lessThan(middle - 1, frame.min)) || glm::any(glm::greaterThan(middle + 1, frame.max)) ||
            !liesBeforePlanes(scene, photons.field().frame(), v))
            return std::numeric_limits<double>::quiet_NaN();
        double sum = 0;
        for (int i = 0; i < 27; ++i)
            sum += finer.irradiance(middle.x + i % 3 - 1, middle.y + i / 3 % 3 - 1, middle.z + i / 9 - 1);
        return sum / 27;
    };
    return compare(tree, mean, photons);
}

void print(const Scene& scene, const char* example, const char* which, const Deviations& voxels) {
    fmt::print(
        "  {}, {}: {} voxels, chi^2/n {:.3g}, with 0.5 % of their light {:.3g}, with 0.5 % of the unfocused light "
        "{:.3g}; 1 with a bias of {:.2g} %\n",
        example, which, voxels.count(), voxels.chi2(), voxels.chi2(kBias),
        voxels.chi2(kBias, kBias * scene.referenceIrradiance()), 100 * voxels.bias());
}

// What falls at silhouettes is told from what is not followed, and is little.
void holdGivenUp(const char* example, const BakeReport& report) {
    ASSERT_TRUE(report.given_up && report.astride);
    const double emitted = report.power.emitted;
    fmt::print(
        "  {}, given up: at silhouettes {:.2g}, turned {:.2g}, events {:.2g}, threshold {:.2g}; astride {:.2g}\n",
        example, report.given_up->outlines / emitted, report.given_up->turned / emitted,
        report.given_up->events / emitted, report.given_up->threshold / emitted, *report.astride / emitted);
    EXPECT_NEAR(report.given_up->sum(), report.power.dropped, 1e-9 * emitted);
    EXPECT_LT(report.given_up->outlines, kAtSilhouettes * emitted);
    EXPECT_LT(report.path.imbalance(), kLedger);
    EXPECT_LT(report.power.imbalance(), kLedger);
}

class GlassAgreement : public testing::TestWithParam<Example> {};

TEST_P(GlassAgreement, VoxelsArePhotons) {
    const Example example = GetParam();
    Monitor quiet;
    Scene scene = loadScene(fmt::format("{}/examples/glass/{}.toml", PHOTIC_SOURCE_DIR, example.name), 0, quiet);
    const glm::dvec3 size = scene.domain.max - scene.domain.min;
    scene.domain.voxel_size = std::max({size.x, size.y, size.z}) / example.resolution;
    scene.domain.layer_height = 0;
    for (Light& light : scene.lights) light.angular_diameter_deg = 0;
    scene.bake.quadrature = 4;
    const Baked photons = whole(bakeScene(
        scene, "photons",
        option("count", example.photons) | option("shifts", kShifts) | option("sampling", std::string("random"))));
    const TriangleTree tree(scene);
    const Baked tubes = whole(bakeScene(scene, "beams"));
    holdGivenUp(example.name, tubes.result.report);
    const Compared usual = compare(tree, tubes, photons);
    print(scene, example.name, "by default", usual.away);
    print(scene, example.name, "by default, voxels that something cuts", usual.cut);
    ASSERT_GT(usual.away.count(), 30u);
    EXPECT_LT(usual.away.bias(), example.usual);
    // What is off by the width of voxels, and not by the tubes, falls with it.
    if (example.finer > 0) {
        Scene in_finer = scene;
        in_finer.domain.voxel_size /= 3;
        const Compared finer = compareFiner(scene, tree, whole(bakeScene(in_finer, "beams")), photons);
        print(scene, example.name, "voxels a third as wide", finer.away);
        print(scene, example.name, "voxels a third as wide, of those that something cuts", finer.cut);
        EXPECT_LT(finer.away.bias(), example.finer);
    }
    if (example.careful == 0) return;  // minutes
    scene.bake.tolerance = kCareful;
    const Compared careful = compare(tree, whole(bakeScene(scene, "beams")), photons);
    print(scene, example.name, "tolerance 0.02", careful.away);
    print(scene, example.name, "tolerance 0.02, voxels that something cuts", careful.cut);
    EXPECT_LT(careful.away.bias(), example.careful);
    // Outlines of light cross voxels: what four points of a layer miss of them twelve see.
    scene.bake.quadrature = 12;
    const Compared twelve = compare(tree, whole(bakeScene(scene, "beams")), photons);
    print(scene, example.name, "tolerance 0.02, twelve points", twelve.away);
    print(scene, example.name, "tolerance 0.02, twelve points, voxels that something cuts", twelve.cut);
    EXPECT_LT(twelve.away.bias(), example.twelve);
}

INSTANTIATE_TEST_SUITE_P(Examples, GlassAgreement,
                         testing::Values(Example{"glass_ball", 48, 4'000'000, 0.11, 0.024, 0.024, 0},
                                         Example{"ring", 48, 8'000'000, 0.016, 0.0055, 0.0055, 0},
                                         Example{"mirror_sphere", 48, 8'000'000, 0.007, 0.005, 0.005, 0.005},
                                         Example{"prism", 48, 400'000, 0.004, 0.004, 0.004, 0},
                                         Example{"discoball", 48, 4'000'000, 0.034, 0.027, 0.014, 0.01},
                                         Example{"lens_check", 48, 8'000'000, 0.0085, 0.008, 0.008, 0},
                                         Example{"wine_glass", 48, 2'000'000, 0.02, 0, 0, 0.012},
                                         Example{"aquarium", 24, 4'000'000, 0.06, 0, 0, 0.04}),
                         [](const auto& example) { return std::string(example.param.name); });

}  // namespace
}  // namespace photic
