// SPDX-License-Identifier: Apache-2.0
// What a bake says of its look-ups against an exact map of the floor, and voxels that it chooses for an error.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bake/baker/error_goal.h"
#include "bake/baker/lookup_advice.h"
#include "bake/baker/report_json.h"
#include "bake/field/scene_grid.h"
#include "bake/picture/volume_lookup.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/wave_field.h"
#include "bake/threads/parallel_for.h"
#include "tests/baker/pool_scene.h"
#include "tests/support/pool3.h"

namespace photic {
namespace {

using test::Record;

constexpr int kTexels = 512;  // of the exact map, over 2 m

/// The focused pool with its floor, half a metre of water beside it and two voxels below.
Scene poolOver(double voxel_size, double disc_deg, const std::string& bake = {}) {
    truth::pool3::SceneText text;
    text.voxel_size = voxel_size, text.z_min = truth::pool3::kFloor - 2 * voxel_size;
    text.angular_diameter_deg = disc_deg, text.half = {1.1, 1.1}, text.bake = bake, text.irradiance = 1000;
    text.objects = "[[object]]\nname = \"floor\"\nplane = { point = [0, 0, -1.5], normal = [0, 0, 1] }\n";
    Monitor monitor;
    return parseScene(truth::pool3::sceneToml(text), "pool3.toml", ".", 0, monitor);
}

/// Look-ups, mean over texels, against the exact map.
double trueError(const LightVolume& volume, const truth::FloorMap& exact) {
    const VolumeLookup lookup(volume);
    const double texel = 2.0 / kTexels;
    double apart = 0, sum = 0;
    for (int y = 0; y < kTexels; ++y)
        for (int x = 0; x < kTexels; ++x) {
            double found = 0;
            for (const double a : {0.25, 0.75})
                for (const double b : {0.25, 0.75})
                    found += lookup.receiverIrradiance({-1 + (x + a) * texel, -1 + (y + b) * texel, -1.5}, {0, 0, 1}).x;
            apart += std::fabs(found / 4 - 1000 * exact.at(x, y)), sum += 1000 * exact.at(x, y);
        }
    return apart / sum;
}

BakeChoices measured(Measure how = Measure::Wholly) {
    BakeChoices choices;
    choices.measure = how, choices.detail = 2.0 / kTexels;
    return choices;
}

TEST(LookupError, IsThatAgainstTheExactFloor) {
    for (const double disc : {0.0, 0.53}) {
        const truth::FloorMap exact = disc > 0 ? truth::pool3::exactDiscFloor() : truth::pool3::exactFloor();
        ASSERT_EQ(exact.size, kTexels);
        for (const double voxel : {2.0 / 64, 2.0 / 160}) {
            Record record;
            const BakedScene baked = bakeScene(poolOver(voxel, disc), record, measured());
            ASSERT_EQ(baked.report.receivers.size(), 1u) << voxel;
            const ReceiverError& error = baked.report.receivers.front();
            EXPECT_EQ(error.name, "floor");
            EXPECT_NEAR(error.detail, 2.0 / kTexels, 2e-5);
            const double right = trueError(baked.volume, exact);
            EXPECT_NEAR(error.relative_l1 / right, 1, 0.1) << voxel << ' ' << disc << ' ' << right;
            // A few strips of it, for a quarter of the time.
            const BakedScene quick = bakeScene(poolOver(voxel, disc), record, measured(Measure::Quickly));
            ASSERT_EQ(quick.report.receivers.size(), 1u);
            EXPECT_NEAR(quick.report.receivers.front().relative_l1 / right, 1, 0.35) << voxel << ' ' << disc;
        }
    }
}

TEST(LookupError, KnowsWhatNarrowerVoxelsWouldBring) {
    Record record;
    const double voxel = 2.0 / 64;
    const BakedScene baked = bakeScene(poolOver(voxel, 0), record, measured());
    const double now = baked.measured.largest();
    // The farther ahead, the less is known: what happens across the receiver is not in its map of light.
    for (const auto& [part, within] : {std::pair{0.5, 0.25}, {0.25, 0.7}}) {
        const double size = voxelSizeFor(part * now, baked.measured, voxel);
        ASSERT_GT(size, 0);
        const double then = bakeScene(withVoxels(poolOver(voxel, 0), size), record, measured()).measured.largest();
        EXPECT_NEAR(then / (part * now), 1, within) << part;
    }
    EXPECT_NE(baked.report.advice.find("--where receivers"), std::string::npos) << baked.report.advice;
    EXPECT_NE(baked.report.advice.find(" MB and "), std::string::npos) << baked.report.advice;
}

// Two triangles a thousand times as wide as the domain: what lies in it is looked at, on texels of its own.
TEST(LookupError, OfAMeshIsThatOfThePlaneThatItLiesIn) {
    Record record;
    Scene scene = poolOver(2.0 / 64, 0);
    BakeChoices choices;
    choices.measure = Measure::Wholly;
    const double plane = bakeScene(scene, record, choices).measured.largest();
    TriangleMesh mesh;
    mesh.positions = {{-1000, -1000, -1.5}, {1000, -1000, -1.5}, {1000, 1000, -1.5}, {-1000, 1000, -1.5}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    scene.objects.front().shape = std::make_shared<const TriangleMesh>(mesh);
    const BakedScene baked = bakeScene(scene, record, choices);
    ASSERT_EQ(baked.report.receivers.size(), 1u);
    EXPECT_NEAR(baked.measured.largest() / plane, 1, 0.03);
    EXPECT_NEAR(baked.report.receivers.front().share, 1, 0.06);  // but for the voxels at the domain's side
    // Texels of a micrometre would be more than there is memory for.
    choices.detail = 1e-6;
    const BakedScene fine = bakeScene(scene, record, choices);
    EXPECT_GT(fine.report.receivers.front().detail, 1e-4);
}

// A step before a higher one: its sides are larger than its top, dark, and covered or under ground. What bleeds into
// them by look-ups made 870 % of it.
TEST(LookupError, OfAStepIsThatOfWhatIsSeenOfIt) {
    Scene scene = poolOver(2.0 / 64, 0);
    const auto step = [&](const std::string& name, const glm::dvec3& min, const glm::dvec3& max) {
        Object object;
        object.name = name, object.shape = std::make_shared<const TriangleMesh>(boxMesh(min, max));
        scene.objects.push_back(object);
    };
    step("high", {-0.5, -2, -1.7}, {-0.2, 2, -0.5});
    step("low", {-0.2, -2, -1.7}, {0.2, 2, -0.9});
    Record record;
    const BakedScene baked = bakeScene(scene, record, measured());
    const auto& said = baked.report.receivers;
    const auto low = std::find_if(said.begin(), said.end(), [](const ReceiverError& e) { return e.name == "low"; });
    ASSERT_NE(low, said.end());
    EXPECT_LT(low->relative_l1, 0.5);
}

TEST(LookupError, IsTheSameForAnyNumberOfThreads) {
    Record record;
    std::vector<std::string> said;
    for (const int threads : {1, 3}) {
        setThreadCount(threads);
        said.push_back(bakeScene(poolOver(2.0 / 64, 0.53), record, measured(Measure::Quickly))
                           .volume.metadata.at("receiver_errors"));
    }
    setThreadCount(0);
    EXPECT_EQ(said[0], said[1]);
}

TEST(LookupError, OfFlatWaterIsNothing) {
    Record record;
    Scene scene = poolOver(2.0 / 64, 0);
    scene.surfaces.front().height_field = makeFlatField(0);
    const BakedScene baked = bakeScene(scene, record, measured());
    ASSERT_EQ(baked.report.receivers.size(), 1u);
    EXPECT_LT(baked.report.receivers.front().relative_l1, 1e-3);
    EXPECT_EQ(baked.report.advice, "");
}

TEST(LookupError, IsReachedWhereItIsAskedFor) {
    for (const double goal : {0.1, 0.04}) {
        Record record;
        Scene scene = poolOver(2.0 / 64, 0);
        scene.bake.error = goal;
        const BakedScene baked = bakeToError(scene, record, measured());
        EXPECT_LE(baked.measured.largest(), goal);
        EXPECT_LE(trueError(baked.volume, truth::pool3::exactFloor()), 1.1 * goal);
        // Not with far more voxels than it takes.
        EXPECT_GE(baked.measured.largest(), 0.4 * goal);
        EXPECT_LT(baked.volume.field.needed().count(), baked.volume.field.frame().voxelCount() / 4);
        EXPECT_TRUE(record.warnings.empty()) << record.warnings.front();
        // The same inputs are the same scene, whatever voxels came out.
        EXPECT_EQ(baked.volume.metadata.at("scene_hash"), inputHash(scene, chooseMethod("auto", scene), measured()));
    }
}

// Of voxels that are narrower than a texel the light, known by the texel, says nothing: they get narrower all the same.
TEST(LookupError, IsReachedWithVoxelsNarrowerThanTexels) {
    Record record;
    Scene scene = poolOver(2.0 / 64, 0);
    scene.bake.error = 0.02;
    BakeChoices choices = measured();
    choices.detail = 0.016, choices.seconds = 1000;
    const BakedScene baked = bakeToError(scene, record, choices);
    EXPECT_LT(baked.volume.field.frame().worldFromIndex()[0].x, 0.5 * choices.detail);
    EXPECT_LE(baked.measured.largest(), 0.02);
    EXPECT_TRUE(record.warnings.empty()) << record.warnings.front();
}

// What light that glass throws is off by takes longer to measure than a quarter of the bake.
TEST(LookupError, OfGlassIsReachedWhereItIsAskedFor) {
    Record record;
    Scene scene = loadScene(PHOTIC_SOURCE_DIR "/examples/glass/glass_ball.toml", 0, record);
    scene.lights.front().angular_diameter_deg = 0;
    scene.bake.error = 0.2;
    BakeChoices choices;
    choices.seconds = 1000;
    const BakedScene baked = bakeToError(scene, record, choices);
    ASSERT_EQ(baked.measured.errors.size(), 1u) << baked.measured.not_measured;
    EXPECT_LE(baked.measured.largest(), 0.2);
    EXPECT_TRUE(record.warnings.empty()) << record.warnings.front();
}

TEST(LookupError, ThatCannotBeReachedIsSaid) {
    Record record;
    Scene scene = poolOver(2.0 / 64, 0);
    scene.bake.error = 1e-4;
    const BakedScene baked = bakeToError(scene, record, measured());
    EXPECT_GT(baked.measured.largest(), 1e-4);
    EXPECT_NE(std::find_if(record.warnings.begin(), record.warnings.end(),
                           [](const std::string& w) { return w.find("was asked for") != std::string::npos; }),
              record.warnings.end());
    // Without a receiver there is nothing to look up on.
    scene.objects.clear();
    EXPECT_THROW(bakeToError(scene, record, measured()), Error);
}

TEST(LookupError, IsAimedAtWhereNothingIsAskedFor) {
    Record record;
    Scene scene = poolOver(2.0 / 64, 0.53);
    EXPECT_FALSE(scene.bake.sizes_itself);  // it has a voxel size
    scene.bake.sizes_itself = true;
    const BakedScene baked = bakeToError(scene, record, measured());
    EXPECT_LE(baked.measured.largest(), 0.02);
    EXPECT_LE(trueError(baked.volume, truth::pool3::exactDiscFloor()), 1.1 * 0.02);
    EXPECT_TRUE(record.warnings.empty()) << record.warnings.front();
    // Within less than that takes: what was reached, and what stood against it.
    BakeChoices little = measured();
    little.budget_bytes = 0.2 * static_cast<double>(baked.volume.field.needed().count());
    const BakedScene less = bakeToError(scene, record, little);
    EXPECT_GT(less.measured.largest(), 0.02);
    ASSERT_FALSE(record.warnings.empty());
    EXPECT_NE(record.warnings.front().find("is aimed at"), std::string::npos) << record.warnings.front();
    EXPECT_NE(record.warnings.front().find("--voxel-size"), std::string::npos) << record.warnings.front();
    // Nothing to look up on: the voxels that the domain has by itself.
    scene.objects.clear();
    EXPECT_EQ(bakeToError(scene, record, measured()).volume.field.frame().voxelVolume(),
              sceneFrame(scene).voxelVolume());
}

TEST(LookupError, StandsInTheVolume) {
    Record record;
    const BakedScene baked = bakeScene(poolOver(2.0 / 64, 0), record, measured());
    const std::vector<ReceiverError> read = readReceiverErrors(baked.volume.metadata.at("receiver_errors"));
    ASSERT_EQ(read.size(), 1u);
    EXPECT_EQ(read.front().name, "floor");
    EXPECT_EQ(read.front().relative_l1, baked.report.receivers.front().relative_l1);
    EXPECT_NE(wordsOf(read).find("floor: look-ups are off by"), std::string::npos);
    EXPECT_TRUE(readReceiverErrors("{").empty());
    EXPECT_TRUE(bakeScene(poolOver(2.0 / 64, 0), record).report.receivers.empty()) << "nobody asked";
}

}  // namespace
}  // namespace photic
