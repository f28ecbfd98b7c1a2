// SPDX-License-Identifier: Apache-2.0
// Every scene of examples/glass against photons, voxel by voxel, in units of the photons' own standard error. It prints
// the table of docs/accuracy.md.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bake/paths/triangle_tree.h"
#include "bake/scene/load_toml.h"
#include "tests/conformance/bake_scene.h"

namespace photic {
namespace {

constexpr std::int64_t kShifts = 256;  ///< Student's t of so many repeats adds 0.6 % to chi^2/n
constexpr double kMost = 0.01;         ///< standard error of the voxels compared, of their light
constexpr double kBias = 0.005;        ///< allowance, added to it in quadrature
constexpr double kCareful = 0.02;      ///< tolerance that tubes converge to [voxels]

struct Example {
    const char* name;
    int resolution;
    std::int64_t photons;
    double usual,
        careful;  ///< bias of voxels that no surface cuts, at the default tolerance and a careful one; 0: not baked
};

/// Voxels that photons know well, by how far tubes are from them.
struct Deviations {
    struct Voxel {
        double difference, error, unfocused;  ///< shares of the photons' light
    };
    std::vector<Voxel> voxels;

    /// chi^2/n where tubes may be off by a share of a voxel's light, and by a share of the unfocused light.
    double chi2(double bias, double of_unfocused = 0) const {
        double sum = 0;
        for (const Voxel& v : voxels)
            sum += v.difference * v.difference /
                   (v.error * v.error + bias * bias + std::pow(of_unfocused * v.unfocused, 2));
        return sum / static_cast<double>(std::max<std::size_t>(1, voxels.size()));
    }
    /// The share that, added to the noise in quadrature, explains all.
    double bias() const {
        if (chi2(0) <= 1) return 0;
        double low = 0, high = 1e3;
        for (int i = 0; i < 60; ++i) (chi2(0.5 * (low + high)) > 1 ? low : high) = 0.5 * (low + high);
        return high;
    }
    void print(const char* example, const char* which) const {
        fmt::print(
            "  {}, {}: {} voxels, chi^2/n {:.3g}, with 0.5 % of their light {:.3g}, with 0.5 % of the unfocused "
            "light {:.3g}; 1 with a bias of {:.2g} %\n",
            example, which, voxels.size(), chi2(0), chi2(kBias), chi2(kBias, kBias), 100 * bias());
    }
};

struct Compared {
    Deviations away, cut;  ///< of voxels that no surface or object reaches into, and of the others
};

Compared compare(const Scene& scene, const TriangleTree& tree, const Baked& tubes, const Baked& photons) {
    const GridFrame& frame = photons.field().frame();
    const LightField& error = photons.result.standard_error->field;
    Compared out;
    for (int k = frame.min.z; k <= frame.max.z; ++k)
        for (int j = frame.min.y; j <= frame.max.y; ++j)
            for (int i = frame.min.x; i <= frame.max.x; ++i) {
                const double light = photons.irradiance(i, j, k), s = error.value({i, j, k}, 0);
                if (!(s > 0 && s <= kMost * light)) continue;
                ConvexRegion voxel;
                voxel.include(frame.worldFromIndex(glm::dvec3(i, j, k) - 0.5));
                voxel.include(frame.worldFromIndex(glm::dvec3(i, j, k) + 0.5));
                (tree.reaches(voxel) ? out.cut : out.away)
                    .voxels.push_back(
                        {tubes.irradiance(i, j, k) / light - 1, s / light, scene.referenceIrradiance() / light});
            }
    return out;
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
    const Compared usual = compare(scene, tree, whole(bakeScene(scene, "beams")), photons);
    usual.away.print(example.name, "by default");
    usual.cut.print(example.name, "by default, voxels that something cuts");
    ASSERT_GT(usual.away.voxels.size(), 30u);
    EXPECT_LT(usual.away.bias(), example.usual);
    if (example.careful == 0) return;  // minutes
    scene.bake.tolerance = kCareful;
    const Compared careful = compare(scene, tree, whole(bakeScene(scene, "beams")), photons);
    careful.away.print(example.name, "tolerance 0.02");
    careful.cut.print(example.name, "tolerance 0.02, voxels that something cuts");
    EXPECT_LT(careful.away.bias(), example.careful);
}

INSTANTIATE_TEST_SUITE_P(
    Examples, GlassAgreement,
    testing::Values(Example{"glass_ball", 48, 4'000'000, 0.11, 0.024}, Example{"ring", 48, 8'000'000, 0.016, 0.0055},
                    Example{"mirror_sphere", 48, 8'000'000, 0.007, 0.005},
                    Example{"prism", 48, 4'000'000, 0.008, 0.0065}, Example{"discoball", 48, 4'000'000, 0.034, 0.027},
                    Example{"lens_check", 48, 8'000'000, 0.0085, 0.008}, Example{"wine_glass", 48, 2'000'000, 0.02, 0},
                    Example{"aquarium", 24, 4'000'000, 0.08, 0}),
    [](const auto& example) { return std::string(example.param.name); });

}  // namespace
}  // namespace photic
