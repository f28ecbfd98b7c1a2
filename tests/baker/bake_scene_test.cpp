// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/bake_scene.h"

#include <gtest/gtest.h>

#include <fstream>
#include <glm/geometric.hpp>

#include "bake/baker/bake_cost.h"
#include "bake/baker/post_steps.h"
#include "bake/field/prefilter.h"
#include "bake/methods/catalogue.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"
#include "tests/baker/pool_scene.h"

namespace photic {
namespace {

using test::poolScene;
using test::Record;
using test::sceneFor;

/// Largest difference of two fields on the same voxels, over the largest value.
double difference(const LightField& a, const LightField& b) {
    double most = 0, largest = 0;
    const GridFrame& f = a.frame();
    for (int x = f.min.x; x <= f.max.x; ++x)
        for (int y = f.min.y; y <= f.max.y; ++y)
            for (int z = f.min.z; z <= f.max.z; ++z)
                for (int c = 0; c < a.channels().count(); ++c) {
                    const double v = double(a.value({x, y, z}, c));
                    most = std::max(most, std::fabs(v - double(b.value({x, y, z}, c))));
                    largest = std::max(largest, std::fabs(v));
                }
    return most / largest;
}

// Receivers in water see by its index; a body of glass is something that stands beside them, whatever it is made of.
TEST(BakeScene, SaysTheIndexOfWhatReceiversStandIn) {
    constexpr const char* kBall = R"(
[[medium]]
name = "glass"
ior = 1.5
[[surface]]
name = "ball"
kind = "sphere"
position = [0, 0, -0.2]
radius = 0.1
inside = "glass"
event = "refract"
)";
    Record monitor;
    const auto iorOf = [&](const Scene& scene) { return bakeScene(scene, monitor).volume.metadata.at("ior"); };
    const Scene pool = poolScene();
    const std::string water = iorOf(pool);
    EXPECT_NEAR(std::stod(water), 1.333, 1e-3);
    Scene ball = poolScene(kBall);
    ball.bake.method = "beams";
    EXPECT_EQ(iorOf(ball), water);
    ball.surfaces.erase(ball.surfaces.begin());
    EXPECT_EQ(iorOf(ball), "1");
}

// An upright pane in the water: what it turns back, all of what meets it slantwise enough, is no longer there.
TEST(BakeScene, SaysWhatAPaneTurnsBack) {
    const std::string folder = testing::TempDir();
    std::ofstream(folder + "/pane.obj")
        << "v 0.1 -0.5 -0.6\nv 0.1 0.5 -0.6\nv 0.1 0.5 -0.05\nv 0.1 -0.5 -0.05\nf 1 2 3 4\n";
    const auto warnings = [&](const std::string& event) {
        Scene scene = poolScene("[[surface]]\nname = \"pane\"\nkind = \"mesh\"\nfile = \"" + folder +
                                "/pane.obj\"\nior_below = 1.333\nevent = \"" + event + "\"\n");
        scene.bake.method = "beams";
        scene.lights[0].direction = glm::normalize(glm::dvec3(0.8, 0.1, -0.6));
        Record monitor;
        const PowerLedger power = bakeScene(scene, monitor).report.power;
        std::string all;
        for (const std::string& warning : monitor.warnings) all += warning + "\n";
        EXPECT_EQ(all.find("is reflected at surfaces that only refract ('water', 'pane')") != all.npos,
                  power.reflected > 0.1 * power.emitted)
            << power.reflected / power.emitted << "\n"
            << all;
        return power.reflected / power.emitted;
    };
    EXPECT_GT(warnings("refract"), 0.1);
    EXPECT_LT(warnings("both"), 0.1);
}

TEST(BakeScene, IsTheMethodsFieldWithAllThatAVolumeHolds) {
    for (const Method& method : methodCatalogue()) {
        Scene scene = sceneFor(method, "[medium]\nabsorption = 0.1\nscattering = 0.2\nanisotropy = 0.3\n");
        scene.bake.method = method.name;
        Record monitor;
        const BakedScene baked = bakeScene(scene, monitor);
        const BakeResult own = method.bake(scene, baked.volume.field.neededPtr(), {}, monitor);
        EXPECT_EQ(difference(own.field, baked.volume.field), 0) << method.name;

        const auto& metadata = baked.volume.metadata;
        EXPECT_EQ(metadata.at("method"), method.name);
        if (scene.medium.present()) {
            EXPECT_EQ(metadata.at("scattering"), "0.2");
            EXPECT_EQ(metadata.at("anisotropy"), "0.3");
        }
        EXPECT_EQ(metadata.at("scene_hash").size(), 16u);
        EXPECT_EQ(baked.volume.scalars.contains("density"), scene.medium.present()) << method.name;
        EXPECT_EQ(baked.volume.reference_irradiance, scene.referenceIrradiance());

        const BakeReport& report = baked.report;
        EXPECT_EQ(report.threads, threadCount());
        EXPECT_EQ(report.needed_voxels, own.field.needed().count());
        EXPECT_EQ(report.reference_irradiance, scene.referenceIrradiance());
        EXPECT_EQ(report.field_bytes, own.field.bytes());
        EXPECT_NE(std::find(report.skipped.begin(), report.skipped.end(), "colour: light and medium are white"),
                  report.skipped.end());
        EXPECT_EQ(baked.standard_error.has_value(), method.standard_error == StandardError::PerVoxel) << method.name;
    }
}

TEST(BakeScene, WarnsOnceInBothPlaces) {
    Scene scene = poolScene();
    scene.bake.method = "wave";
    scene.bake.method_options["wave"]["points"] = {3.5, "test"};
    scene.lights.push_back(scene.lights.front());
    Record monitor;
    const BakedScene baked = bakeScene(scene, monitor);
    EXPECT_FALSE(monitor.warnings.empty());
    EXPECT_EQ(baked.report.warnings, monitor.warnings);
    for (const std::string& warning : monitor.warnings)
        EXPECT_EQ(std::count(monitor.warnings.begin(), monitor.warnings.end(), warning), 1) << warning;
}

TEST(BakeScene, PrefiltersAndTakesSteps) {
    Scene scene = poolScene("[bake]\ngrids = [\"irradiance\", \"direction\", \"caustic\"]\n");
    Monitor monitor;
    BakedScene plain = bakeScene(scene, monitor);
    EXPECT_EQ(plain.volume.metadata.at("prefilter"), "false");

    BakeChoices choices;
    choices.post = {"sharpen=2,1"};
    scene.bake.prefilter = true;
    const BakedScene worked = bakeScene(scene, monitor, choices);
    EXPECT_EQ(worked.volume.metadata.at("prefilter"), "true");
    prefilterForTrilinear(plain.volume.field);
    EXPECT_EQ(difference(plain.volume.field, worked.volume.field), 0);
    applyPostSteps(choices.post, plain.volume);
    EXPECT_EQ(difference(plain.volume.scalars.at("caustic"), worked.volume.scalars.at("caustic")), 0);
    EXPECT_NE(plain.volume.metadata.at("scene_hash"), worked.volume.metadata.at("scene_hash"));
}

/// Suns from opposite sides add up to light from above: the numbers say how much of it a wall is not handed.
TEST(BakeScene, SaysWhatOpposedSunsLose) {
    const auto warned = [](const std::string& direction, double irradiance) -> std::string {
        Record monitor;
        bakeScene(poolScene("[[light]]\ntype = \"sun\"\nangular_diameter = 0\ndirection = " + direction +
                            "\nirradiance = " + std::to_string(irradiance) + "\n[bake]\nlobes = 1\n"),
                  monitor);
        for (const std::string& w : monitor.warnings)
            if (w.find("rays cross") != std::string::npos) return w;
        return "";
    };
    // The scene's own sun shines along (0.2, 0.1, -0.9).
    EXPECT_EQ(warned("[0.2, 0.1, -0.9]", 1000), "") << "one direction is all that there is";
    EXPECT_EQ(warned("[-3, -1.5, -0.9]", 3), "") << "a thousandth changes nothing";
    const std::string opposed = warned("[-3, -1.5, -0.9]", 3000);
    EXPECT_NE(opposed, "");
    double share = 0;
    ASSERT_EQ(std::sscanf(opposed.c_str(), "%lf %%", &share), 1) << opposed;
    EXPECT_GT(share, 50) << opposed;
}

TEST(BakeScene, SaysWhichReceiversLieAtTheEdge) {
    const auto warned = [](double z) {
        Record monitor;
        Scene scene = poolScene("[[object]]\nname = \"shelf\"\nplane = { point = [0, 0, " + std::to_string(z) +
                                "], normal = [0, 0, 1] }\n");
        bakeScene(scene, monitor);
        return std::any_of(monitor.warnings.begin(), monitor.warnings.end(),
                           [](const std::string& w) { return w.starts_with("shelf lies at the edge"); });
    };
    // The lowest voxels are centred at -0.71875.
    EXPECT_FALSE(warned(-0.71));
    EXPECT_TRUE(warned(-0.73));
    EXPECT_FALSE(warned(-0.9)) << "outside of the box there is nothing to say";
}

TEST(BakeScene, RefusesWhatDoesNotFitTheMemory) {
    const Scene scene = poolScene();
    Monitor monitor;
    BakeChoices choices;
    choices.max_memory_bytes = 1000000;
    try {
        bakeScene(scene, monitor, choices);
        FAIL() << "a megabyte is too little for any bake";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Failed);
        EXPECT_NE(std::string(error.what()).find("--max-memory"), std::string::npos) << error.what();
    }
}

TEST(BakeScene, RefusesTablesOfMethodsThatAreNone) {
    Scene scene = poolScene("[bake.beems]\nmesh = 3\n");
    Monitor monitor;
    EXPECT_THROW(bakeScene(scene, monitor), Error);
}

}  // namespace
}  // namespace photic
