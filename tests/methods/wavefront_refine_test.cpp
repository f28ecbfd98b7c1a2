// SPDX-License-Identifier: Apache-2.0
// Tubes of fronts that are halved where rays go apart unevenly.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bake/methods/graded_space.h"
#include "bake/methods/wavefront_refine.h"
#include "bake/paths/emission.h"
#include "tests/methods/wavefront_scenes.h"

namespace photic {
namespace {

const std::string kBox = "min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]\nresolution = 24",
                  kLens = medium("{ kind = \"luneburg\", radius = 0.4 }") + "[bake]\npaths = \"all\"\n",
                  kLamp = "type = \"point\"\npower = 1\nposition = [0.9, 0.2, 0.48]";

/// A launched front, and what it was launched from.
struct Launched {
    explicit Launched(const std::string& light)
        : scene(sceneOf(kBox, light, kLens)),
          frame(sceneFrame(scene)),
          space(scene, frame, {}),
          samples(lightSamples(scene.lights[0], 1)),
          launch(space.launch(samples[0].source, 1, 0, nullptr)) {
        Monitor monitor;
        space.sample(0, monitor);
        front = launchFronts(launch, scene.lights[0], samples[0]).front();
    }
    Scene scene;
    GridFrame frame;
    GradedSpace space;
    std::vector<LightSample> samples;
    FrontLaunch launch;
    Front front;
};

/// Bends of many sizes, without order.
FrontBends someBends(const Front& front) {
    FrontBends bends(front.cells);
    std::uint32_t random = 12345;
    for (FrontBends::Edge& edge : bends.edges) {
        random = 1664525 * random + 1013904223;
        const double share = (random >> 8) / 16777216.0;
        edge.bend = share < 0.7 ? 0.0f : static_cast<float>(std::pow(40.0, share) / 40);
    }
    return bends;
}

TEST(WavefrontRefine, HalvingLosesNoPowerAndLeavesNoCracks) {
    for (const std::string& light : {kDown, kLamp}) {
        const Launched of(light);
        const LaunchPlane plane(of.launch, of.samples[0]);
        const FrontBends bends = someBends(of.front);
        std::vector<std::uint32_t> from;
        const Front out = FrontRefiner::halveEdges(plane, of.front, &bends, 0.25, {3, 17, 18},
                                                   std::numeric_limits<std::size_t>::max(), from);
        ASSERT_GT(out.tubes.size(), 3 * of.front.tubes.size() / 2);
        ASSERT_EQ(from.size(), out.tubes.size());
        // Each tube's power is that of its parts.
        std::vector<double> power(of.front.tubes.size(), 0.0);
        std::vector<int> parts(of.front.tubes.size(), 0);
        for (std::size_t t = 0; t < out.tubes.size(); ++t) power[from[t]] += out.tubes[t].power.x, ++parts[from[t]];
        for (std::size_t t = 0; t < power.size(); ++t) EXPECT_NEAR(power[t] / of.front.tubes[t].power.x, 1, 1e-9) << t;
        for (const std::size_t whole : {3, 17, 18}) EXPECT_GE(parts[whole], 4) << whole;
        // An edge that has a tube on one side alone lies on the rim of all.
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
        for (const Front::Tube& tube : out.tubes)
            for (std::size_t c = 0; c < 3; ++c) ++sides[std::minmax(tube.ray[c], tube.ray[(c + 1) % 3])];
        glm::dvec2 low(1e300), high(-1e300);
        for (const Front::Ray& ray : out.rays)
            low = glm::min(low, plane.placeOf(ray)), high = glm::max(high, plane.placeOf(ray));
        for (const auto& [edge, count] : sides) {
            ASSERT_LE(count, 2);
            if (count == 2) continue;
            const glm::dvec2 a = plane.placeOf(out.rays[edge.first]), b = plane.placeOf(out.rays[edge.second]);
            bool on_rim = false;
            for (int k = 0; k < 2; ++k)
                for (const double side : {low[k], high[k]})
                    on_rim = on_rim || (std::fabs(a[k] - side) < 1e-9 && std::fabs(b[k] - side) < 1e-9);
            EXPECT_TRUE(on_rim) << a.x << ", " << a.y << " to " << b.x << ", " << b.y;
        }
    }
}

TEST(WavefrontRefine, WhereTubesWouldBeTooManyWhatBendsMostIsHalved) {
    const Launched of(kDown);
    const LaunchPlane plane(of.launch, of.samples[0]);
    const FrontBends bends = someBends(of.front);
    std::vector<std::uint32_t> from;
    const std::size_t most = 5 * of.front.tubes.size() / 4;
    FrontCoarse coarse;
    const Front out = FrontRefiner::halveEdges(plane, of.front, &bends, 0.25, {}, most, from, &coarse);
    EXPECT_LE(out.tubes.size(), most);
    EXPECT_GT(out.tubes.size(), of.front.tubes.size());
    // It says what is left as it was.
    EXPECT_TRUE(coarse.too_many);
    EXPECT_GT(coarse.power, 0);
    EXPECT_GT(coarse.by, 0.25);
    FrontCoarse none_left;
    FrontRefiner::halveEdges(plane, of.front, &bends, 2, {}, ~std::size_t{0}, from, &none_left);
    EXPECT_FALSE(none_left.too_many);
    EXPECT_EQ(none_left.power, 0);
    // Without bends nothing is halved.
    const FrontBends none(of.front.cells);
    EXPECT_EQ(FrontRefiner::halveEdges(plane, of.front, &none, 0.25, {}, most, from).tubes.size(),
              of.front.tubes.size());
}

TEST(WavefrontRefine, ABakeSaysWhatIsCoarserThanItWasAskedFor) {
    const auto said = [](const Scene& scene) {
        const Bake b = bake(scene);
        for (const std::string& what : b.report().skipped)
            if (what.find("halving of all tubes") != std::string::npos) return what;
        return std::string();
    };
    Scene scene = sceneOf(kBox, kLamp, kLens);
    scene.bake.tolerance = 1e-4;
    EXPECT_NE(said(scene).find("four times as many"), std::string::npos) << said(scene);
    EXPECT_NE(said(scene).find("'spacing'"), std::string::npos);
    scene.bake.tolerance = 100;
    EXPECT_EQ(said(scene), "");
}

TEST(WavefrontRefine, LightIsAsFinerFrontsHaveIt) {
    struct Case {
        std::string what, domain, light, media;
        double limit, without;  ///< with halving at most, and without it at least
    };
    for (const Case& c :
         {Case{"a lamp beside a lens", kBox, kLamp, kLens, 0.025, 0.05},
          Case{"a headlamp over a hot road", "min = [0, -0.3, 0]\nmax = [1.6, 0.3, 0.6]\nvoxel_size = 0.025",
               "type = \"spot\"\npower = 1\nposition = [-0.5, 0, 0.5]\ndirection = [1, 0, -0.24]\nangle = 12",
               medium("{ kind = \"hot_air\", ground = 0, height = 0.12, n = 1.000277, drop = 0.07 }"), 0.02, 0.03}}) {
        Scene scene = sceneOf(c.domain, c.light, c.media);
        const Bake halved = bake(scene);
        EXPECT_LT(halved.report().power.imbalance(), 1e-9) << c.what;
        EXPECT_LT(halved.report().path.imbalance(), 3e-5) << c.what;
        scene.bake.tolerance = 1e6;  // nothing is halved for its bend
        const Bake plain = bake(scene), fine = bake(scene, with("spacing", 0.125));
        fmt::print("  {}: {:.2f} % off, {:.2f} % without halving\n", c.what, 100 * apart(halved, fine),
                   100 * apart(plain, fine));
        EXPECT_LT(apart(halved, fine), c.limit) << c.what;
        EXPECT_GT(apart(plain, fine), c.without) << c.what;
    }
}

}  // namespace
}  // namespace photic
