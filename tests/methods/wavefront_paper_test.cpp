// SPDX-License-Identifier: Apache-2.0
// The paper's own simulator, beside closed forms and the method's own tubes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "bake/methods/wavefront.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"
#include "tests/methods/wavefront_scenes.h"

namespace photic {
namespace {

const GivenOptions kPaper = with("preset", std::string("paper"));

/// Mean relative difference of two bakes over places that count.
template <class Counts>
double apart(const Bake& a, const Bake& b, const Counts& counts) {
    const GridFrame& frame = a.field().frame();
    double difference = 0, sum = 0;
    for (int i = frame.min.x; i <= frame.max.x; ++i)
        for (int j = frame.min.y; j <= frame.max.y; ++j)
            for (int k = frame.min.z; k <= frame.max.z; ++k) {
                if (!counts(frame.worldFromIndex(glm::dvec3(i, j, k)))) continue;
                difference += std::fabs(a.fluence({i, j, k}) - b.fluence({i, j, k})), sum += b.fluence({i, j, k});
            }
    return difference / sum;
}

TEST(WavefrontPaper, EvenLightStaysEven) {
    const Bake b = bake(sceneOf("min = [-0.3, -0.3, -0.3]\nmax = [0.3, 0.3, 0.3]\nresolution = 24", kDown,
                                medium("{ kind = \"linear\", n0 = 1.3, slope = [0, 0, 0] }", "absorption = 0.5")),
                        kPaper);
    const GridFrame& frame = b.field().frame();
    // Samples lie up to half a voxel above the middle, and the least absorbed one is kept.
    for (const int k : {frame.min.z, 0, frame.max.z}) {
        const double depth = 0.3 - frame.worldFromIndex(glm::dvec3(0, 0, k)).z;
        EXPECT_NEAR(b.fluence({3, -2, k}), std::exp(-0.5 * depth), 0.5 * 0.025);
        EXPECT_NEAR(b.field().flux({3, -2, k}).z, -b.fluence({3, -2, k}), 1e-5);
    }
    EXPECT_LT(b.report().power.imbalance(), 1e-9);
    EXPECT_EQ(b.report().power.dropped, 0);
    EXPECT_EQ(b.result.metadata.at("arrivals"), "strongest");
}

TEST(WavefrontPaper, GoesToTheTubesBeforeCaustics) {
    double error[2];
    for (int k = 0; k < 2; ++k) {
        const Scene scene =
            sceneOf("min = [-0.4, -0.4, -0.8]\nmax = [0.4, 0.4, 0]\nresolution = " + std::to_string(32 << k), kDown,
                    medium("{ kind = \"selfoc\", n0 = 1.5, g = 1.4 }"));
        error[k] = apart(bake(scene, kPaper), bake(scene),
                         [](const glm::dvec3& p) { return p.z > -0.6 && p.z < -0.02 && std::hypot(p.x, p.y) < 0.1; });
    }
    EXPECT_LT(error[1], 0.1);
    EXPECT_GT(std::log2(error[0] / error[1]), 0.5);
}

/// The area between a patch's particles is that of a chord, and the Jacobian's that of a slope: where patches are small
/// they are one.
TEST(WavefrontPaper, TheParaxialAreaIsThatOfThePatchBeforeCaustics) {
    const GivenOptions paraxial = kPaper | with("area", std::string("jacobian"));
    double tubes[2], corners[2];
    for (int k = 0; k < 2; ++k) {
        const Scene scene =
            sceneOf("min = [-0.4, -0.4, -0.8]\nmax = [0.4, 0.4, 0]\nresolution = " + std::to_string(32 << k), kDown,
                    medium("{ kind = \"selfoc\", n0 = 1.5, g = 1.4 }"));
        const auto counts = [](const glm::dvec3& p) { return p.z > -0.6 && p.z < -0.02 && std::hypot(p.x, p.y) < 0.1; };
        const Bake by_jacobian = bake(scene, paraxial);
        EXPECT_LT(by_jacobian.report().power.imbalance(), 1e-9);
        tubes[k] = apart(by_jacobian, bake(scene), counts);
        corners[k] = apart(by_jacobian, bake(scene, kPaper), counts);
    }
    fmt::print("  paraxial areas: {:.2f} % from the tubes, {:.2f} % from areas between particles\n", 100 * tubes[1],
               100 * corners[1]);
    EXPECT_LT(tubes[1], 0.1);
    EXPECT_LT(corners[1], 0.03);
    EXPECT_GT(std::log2(tubes[0] / tubes[1]), 0.5);
}

TEST(WavefrontPaper, IsDarkBeyondCaustics) {
    // Parallel light in a rod meets on its axis, at g depth = pi / 2; tubes go on beyond, patches do not.
    const Scene scene = sceneOf("min = [-0.3, -0.3, -1.6]\nmax = [0.3, 0.3, 0]\nvoxel_size = 0.02", kDown,
                                medium("{ kind = \"selfoc\", n0 = 1.5, g = 1.4 }"));
    const Bake paper = bake(scene, kPaper), tubes = bake(scene);
    const auto lightIn = [](const Bake& b, double low, double high) {
        const GridFrame& frame = b.field().frame();
        double sum = 0;
        for (int i = frame.min.x; i <= frame.max.x; ++i)
            for (int j = frame.min.y; j <= frame.max.y; ++j)
                for (int k = frame.min.z; k <= frame.max.z; ++k) {
                    const glm::dvec3 p = frame.worldFromIndex(glm::dvec3(i, j, k));
                    if (p.z > low && p.z < high) sum += b.fluence({i, j, k});
                }
        return sum;
    };
    EXPECT_LT(lightIn(paper, -1.5, -1.3), 0.1 * lightIn(tubes, -1.5, -1.3));
    EXPECT_GT(paper.report().power.dropped, 0.8 * paper.report().power.emitted);
    EXPECT_LT(paper.report().power.imbalance(), 1e-9);
    EXPECT_LT(tubes.report().power.dropped, 1e-3 * tubes.report().power.emitted);
}

TEST(WavefrontPaper, SlantingLightComesInByTheSidesToo) {
    Scene scene = sceneOf("min = [-0.3, -0.3, -0.3]\nmax = [0.3, 0.3, 0.3]\nresolution = 24",
                          "type = \"sun\"\ndirection = [0.5, 0, -0.8660254]\nirradiance = 1\nangular_diameter = 0",
                          medium("{ kind = \"luneburg\", radius = 0.05 }"));
    scene.bake.paths = Paths::All;
    const Bake b = bake(scene, kPaper);
    const GridFrame& frame = b.field().frame();
    for (int j = frame.min.y; j <= frame.max.y; j += 5)
        for (int k = frame.min.z; k <= frame.max.z; ++k) EXPECT_NEAR(b.fluence({frame.min.x, j, k}), 1, 1e-3);
    EXPECT_LT(b.report().power.imbalance(), 1e-9);
}

TEST(WavefrontPaper, ThreadsChangeNoBit) {
    const Scene scene = sceneOf("min = [-0.4, -0.4, -0.5]\nmax = [0.4, 0.4, 0.4]\nresolution = 32", kDown,
                                medium("{ kind = \"luneburg\", radius = 0.3 }", "absorption = 0.3"));
    setThreadCount(1);
    const Bake one = bake(scene, kPaper);
    setThreadCount(3);
    const Bake three = bake(scene, kPaper);
    setThreadCount(0);
    EXPECT_EQ(one.report().power.escaped, three.report().power.escaped);
    for (int c = 0; c < 4; ++c) EXPECT_EQ(one.field().sum(c), three.field().sum(c));
}

TEST(WavefrontPaper, RefusesWhatThePaperDoesNotKnow) {
    const std::string domain = "min = [-1, -1, -1]\nmax = [1, 1, 1]\nresolution = 8",
                      lens = "{ kind = \"luneburg\", radius = 0.5 }";
    const auto refusal = [&](const Scene& scene, const GivenOptions& options) {
        try {
            (void)bake(scene, options);
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    const Scene plain = sceneOf(domain, kDown, medium(lens));
    EXPECT_EQ(refusal(plain, kPaper), "");
    EXPECT_NE(
        refusal(sceneOf(domain, kDown, medium(lens) + "[[object]]\nname = \"floor\"\nplane = { point = [0, 0, -1] }\n"),
                kPaper)
            .find("'floor'"),
        std::string::npos);
    EXPECT_NE(
        refusal(sceneOf(domain, kDown, medium("[" + lens + ", " + lens + ", " + lens + "]")), kPaper).find("one index"),
        std::string::npos);
    // Sharp surfaces, which an estimate beforehand stands.
    const Scene sharp = sceneOf(domain, kDown,
                                medium(lens) +
                                    "[[surface]]\nname = \"ball\"\nkind = \"sphere\"\nradius = 0.4\ninside = "
                                    "\"lens\"\n");
    EXPECT_NE(refusal(sharp, kPaper).find("'ball'"), std::string::npos);
    EXPECT_GT(findMethod("wavefront")->cost({sharp, sceneFrame(sharp), 512, kPaper}).stages.size(), 0u);
    Scene timed = plain;
    timed.bake.grids.arrival_time = true;
    EXPECT_NE(refusal(timed, kPaper).find("arrival_time"), std::string::npos);
    EXPECT_NE(refusal(plain, kPaper | with("integrator", std::string("yoshida"))).find("'integrator'"),
              std::string::npos);
    GivenOptions both = kPaper;
    both["arrivals"] = {std::string("strongest"), "test"};
    EXPECT_NE(refusal(plain, both).find("'arrivals'"), std::string::npos);
    // What only the preset has does nothing without it.
    EXPECT_NE(refusal(plain, with("area", std::string("jacobian"))).find("'area'"), std::string::npos);
    EXPECT_NE(refusal(plain, with("smooth", 0.5)).find("'smooth'"), std::string::npos);
}

}  // namespace
}  // namespace photic
