// SPDX-License-Identifier: Apache-2.0
// A volume that is baked in tiles, and joined, is the one that is baked whole.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "bake/baker/bake_cost.h"
#include "bake/baker/bake_slabs.h"
#include "bake/baker/merge_tiles.h"
#include "bake/baker/report_json.h"
#include "bake/field/scene_grid.h"
#include "bake/field/scene_needed_voxels.h"
#include "bake/file/file_bytes.h"
#include "bake/volume/vdb_bytes.h"
#include "tests/baker/pool_scene.h"

namespace photic {
namespace {

namespace fs = std::filesystem;
using test::Record;

class Tiles : public testing::Test {
protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / fmt::format("photic_tiles_{}", ::getpid());
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    std::string path(const std::string& name) const { return (folder_ / name).string(); }

    static void write(CheckedFile& file, const LightVolume& volume, const BakeChoices& choices) {
        writeVdb(file, volume, choices.file);
        file.commit();
    }

    /// Bakes a scene whole, to "whole.vdb".
    BakeReport bakeWhole(const Scene& scene, const BakeChoices& choices = {}) const {
        Record record;
        const BakedScene baked = bakeScene(scene, record, choices);
        CheckedFile file(path("whole.vdb"));
        write(file, baked.volume, choices);
        return baked.report;
    }

    /// Bakes one of its tiles.
    TileFile bakeTile(const Scene& scene, int index, int count, BakeChoices choices = {}) const {
        Record record;
        choices.tile = Tile{index, count};
        const BakedScene baked = bakeScene(scene, record, choices);
        const std::string name = fmt::format("tile{}of{}.vdb", index, count);
        CheckedFile file(path(name));
        write(file, baked.volume, choices);
        if (baked.standard_error) {
            CheckedFile error(path("error_" + name));
            write(error, *baked.standard_error, choices);
        }
        return {path(name), name};
    }

    MergedTiles merge(const std::vector<TileFile>& tiles, const std::string& name = "merged.vdb") const {
        CheckedFile file(path(name));
        const MergedTiles merged = mergeTiles(tiles, file);
        file.commit();
        return merged;
    }

    std::string refusal(const std::vector<TileFile>& tiles) const {
        try {
            merge(tiles);
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Input);
            EXPECT_FALSE(fs::exists(path("merged.vdb")));
            return error.what();
        }
        ADD_FAILURE() << "it was merged";
        return {};
    }

    /// Where two volumes' files differ, but for what both ledgers say; empty where they do not.
    std::string difference(const std::string& one, const std::string& other) const {
        const FileBytes a(path(one)), b(path(other));
        const VdbFile p = parseVdb(a.data(), a.size()), q = parseVdb(b.data(), b.size());
        VdbMetadata of_p = p.metadata, of_q = q.metadata;
        of_p.erase("photic:ledger"), of_q.erase("photic:ledger");
        for (const auto& [key, text] : of_p)
            if (of_q[key] != text) return fmt::format("{} is {} and {}", key, text, of_q[key]);
        if (of_p != of_q) return "one of them says more";
        if (p.grids.size() != q.grids.size()) return fmt::format("{} and {} grids", p.grids.size(), q.grids.size());
        for (std::size_t g = 0; g < p.grids.size(); ++g) {
            const VdbGrid &m = p.grids[g], &n = q.grids[g];
            if (m.name != n.name) return m.name + " and " + n.name;
            if (m.leaves.size() != n.leaves.size())
                return fmt::format("{}: {} and {} leaves", m.name, m.leaves.size(), n.leaves.size());
            int differ = 0;
            for (std::size_t i = 0; i < m.leaves.size(); ++i) {
                const VdbLeaf &x = m.leaves[i], &y = n.leaves[i];
                const std::size_t size = m.bytesOf(x);
                if (x.origin != y.origin || size != n.bytesOf(y) ||
                    std::memcmp(a.data() + x.mask, b.data() + y.mask, size) != 0)
                    ++differ;
            }
            if (differ > 0) return fmt::format("{}: {} of {} leaves differ", m.name, differ, m.leaves.size());
        }
        return {};
    }

    /// Tiles of a scene are the whole.
    void expectTheWhole(const Scene& scene, int count, const BakeChoices& choices = {}) const {
        const BakeReport whole = bakeWhole(scene, choices);
        std::vector<TileFile> tiles;
        for (int i = count; i >= 1; --i) tiles.push_back(bakeTile(scene, i, count, choices));
        const MergedTiles merged = merge(tiles);
        EXPECT_EQ(difference("whole.vdb", "merged.vdb"), "");
        EXPECT_EQ(fs::file_size(path("whole.vdb")) / 100, fs::file_size(path("merged.vdb")) / 100);
        for (const auto term : PowerLedger::kTerms) EXPECT_EQ(merged.power.*term, whole.power.*term);
        EXPECT_NEAR(merged.path.deposited / whole.path.deposited, 1, 1e-12);
        // What is expected is reckoned in single precision, tube by tube at each border.
        EXPECT_NEAR(merged.path.expected / whole.path.expected, 1, 1e-5);
        EXPECT_LT(merged.path.imbalance(), 1e-5);
        EXPECT_EQ(merged.active_voxels, readVdb(path("whole.vdb")).field.needed().count());
    }

    fs::path folder_;
};

// Where voxels lie oddly in the grid's blocks, and blurs, waves and walls cross from tile to tile.
constexpr double kOddVoxel = 1.0 / 43;
constexpr const char* kWall = R"(
[[object]]
name = "wall"
plane = { point = [0.31, 0, 0], normal = [-1, 0.2, 0.1] }
)";

TEST_F(Tiles, OfAPoolAreTheWhole) { expectTheWhole(test::poolScene(kWall, kOddVoxel), 8); }

TEST_F(Tiles, OfAnyNumberAreTheWhole) {
    const Scene scene = test::poolScene(kWall, 1.0 / 25);
    for (const int count : {1, 2, 3, 5, 13}) expectTheWhole(scene, count);
}

TEST_F(Tiles, OfABandAroundReceiversAreTheWhole) {
    Scene scene = test::poolScene(std::string(kWall) + "[bake]\nwhere = \"receivers\"\n", 1.0 / 60);
    expectTheWhole(scene, 8);
}

TEST_F(Tiles, OfColourAMediumAndAllGridsAreTheWhole) {
    expectTheWhole(test::poolScene("[medium]\nabsorption = [0.6, 0.2, 0.1]\nscattering = 0.1\n[bake]\nwhere = "
                                   "\"media\"\ngrids = [\"irradiance\", \"direction\", \"caustic\", \"density\"]\n",
                                   1.0 / 40),
                   8);
}

TEST_F(Tiles, BelowASunWithADiscAreTheWhole) {
    Scene scene = test::poolScene(kWall, kOddVoxel);
    scene.lights.front().angular_diameter_deg = 6;  // 1.6 voxels at the floor
    expectTheWhole(scene, 8);
}

TEST_F(Tiles, OfALeaningGridAreTheWhole) {
    Scene scene = test::poolScene({}, kOddVoxel);
    scene.lights.front().direction = glm::dvec3(0.7, 0.2, -0.9);
    scene.domain.shear_mode = ShearMode::Light;
    expectTheWhole(scene, 8);
}

TEST_F(Tiles, WithTwoLobesAreTheWhole) {
    // A mirror below the water sends light back up in a part of it.
    Scene scene = test::poolScene(R"(
[[light]]
type = "sun"
name = "west"
direction = [-0.9, 0.1, -0.3]
irradiance = 700.0
angular_diameter = 4
)",
                                  kOddVoxel);
    const BakeReport whole = bakeWhole(scene);
    ASSERT_TRUE(readVdb(path("whole.vdb")).second.has_value());
    expectTheWhole(scene, 8);
}

TEST_F(Tiles, StoredOtherwiseAreTheWhole) {
    const Scene scene = test::poolScene({}, 1.0 / 24);
    for (const Compression compression : {Compression::None, Compression::Blosc, Compression::Zip}) {
        BakeChoices choices;
        choices.file = {compression, compression == Compression::Blosc};
        expectTheWhole(scene, 4, choices);
    }
}

TEST_F(Tiles, OfPhotonsAreTheWholeWithTheirStandardError) {
    Scene scene = test::poolScene(kWall, 1.0 / 24);
    scene.bake.method = "photons";
    scene.bake.method_options["photons"] = {{"count", {std::int64_t{20000}, "test"}}};
    for (const Where where : {Where::Everywhere, Where::Receivers}) {
        scene.bake.where = where;
        expectTheWhole(scene, 4);
        Record record;
        const BakedScene baked = bakeScene(scene, record);
        CheckedFile file(path("whole_error.vdb"));
        write(file, *baked.standard_error, {});
        std::vector<TileFile> errors;
        for (int i = 1; i <= 4; ++i) {
            const std::string name = fmt::format("error_tile{}of4.vdb", i);
            errors.push_back({path(name), name});
        }
        merge(errors, "merged_error.vdb");
        EXPECT_EQ(difference("whole_error.vdb", "merged_error.vdb"), "");
    }
}

TEST_F(Tiles, OfBentLightAreTheWhole) {
    Scene scene = test::lensScene(kOddVoxel);
    scene.bake.method = "wavefront";
    scene.bake.grids.arrival_time = true;
    expectTheWhole(scene, 8);
}

TEST_F(Tiles, ThatAreDarkAddNothing) {
    // Light in a corner of the box alone: most tiles have none.
    Scene scene = test::poolScene({}, 1.0 / 24);
    scene.domain.max.z = 3;
    expectTheWhole(scene, 8);
    // And none at all.
    scene.domain.min.z = 1;
    bakeWhole(scene);
    merge({bakeTile(scene, 1, 2), bakeTile(scene, 2, 2)});
    EXPECT_EQ(difference("whole.vdb", "merged.vdb"), "");
}

TEST_F(Tiles, OneAfterAnotherInSlabsAreTheWhole) {
    const Scene scene = test::poolScene(kWall, kOddVoxel);
    const BakeReport whole = bakeWhole(scene);
    Record record;
    BakeChoices choices;
    std::vector<Stage> stages;
    choices.expect = [&](const std::vector<Stage>& expected) { stages = expected; };
    CheckedFile file(path("merged.vdb"));
    const BakedSlabs slabs = bakeInSlabs(scene, 5, file, record, choices);
    file.commit();
    EXPECT_EQ(difference("whole.vdb", "merged.vdb"), "");
    EXPECT_EQ(slabs.report.needed_voxels, whole.needed_voxels);
    EXPECT_EQ(slabs.report.active_voxels, readVdb(path("whole.vdb")).field.needed().count());
    EXPECT_LT(slabs.report.field_bytes, whole.field_bytes / 2);
    // To the outside, one stage that goes on.
    ASSERT_EQ(stages.size(), 1U);
    double last = 0;
    for (const Record::Step& step : record.steps) {
        EXPECT_EQ(step.stage, stages.front().name);
        EXPECT_GE(step.fraction, last);
        last = step.fraction;
    }
    EXPECT_GT(last, 0.9);
    std::size_t files = 0;
    for (const auto& entry : fs::directory_iterator(folder_)) files += entry.is_regular_file();
    EXPECT_EQ(files, 2U) << "slabs are left behind";
}

TEST_F(Tiles, AreAskedForWhereABakeDoesNotFit) {
    Record record;
    Scene scene = test::poolScene({}, 1.0 / 128);
    const Method& method = chooseMethod("beams", scene);
    BakeChoices choices;
    const std::int64_t whole = bakeCost(scene, method, sceneFrame(scene), nullptr, choices).memory_bytes;
    choices.max_memory_bytes = whole;
    EXPECT_EQ(slabsToFit(scene, record, choices).slabs, 1);
    choices.max_memory_bytes = whole * 95 / 100;
    const auto [slabs, each] = slabsToFit(scene, record, choices);
    EXPECT_GT(slabs, 1);
    // Each of them fits with a fifth to spare, and what is said of it is what bakes it.
    EXPECT_LT(static_cast<double>(each.memory_bytes), 0.8 * 0.95 * static_cast<double>(whole));
    const auto all = std::make_shared<NeededVoxels>(NeededVoxels::everything(sceneFrame(scene)));
    std::int64_t largest = 0;
    for (int slab = 1; slab <= slabs; ++slab) {
        const auto part = cutTile(scene, method, all, Tile{slab, slabs}, {});
        largest = std::max(largest, bakeCost(scene, method, sceneFrame(scene), part.get(), choices).memory_bytes);
    }
    EXPECT_LE(largest, each.memory_bytes);
    EXPECT_GT(static_cast<double>(largest), 0.95 * static_cast<double>(each.memory_bytes));

    const auto why = [&] {
        try {
            slabsToFit(scene, record, choices);
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Failed);
            return std::string(error.what());
        }
        return std::string("it fits");
    };
    choices.max_memory_bytes = 1000;
    EXPECT_NE(why().find("64 would not be enough"), std::string::npos) << why();
    choices.max_memory_bytes = whole / 2;
    scene.bake.prefilter = true;
    EXPECT_NE(why().find("prefilter"), std::string::npos) << why();
    scene.bake.prefilter = false, scene.bake.method = "eikonal";
    EXPECT_NE(why().find("'eikonal'"), std::string::npos) << why();
}

TEST_F(Tiles, ThatDoNotBelongTogetherAreRefusedByName) {
    const Scene scene = test::poolScene({}, 1.0 / 24);
    const TileFile one = bakeTile(scene, 1, 3), two = bakeTile(scene, 2, 3), three = bakeTile(scene, 3, 3);
    const auto expectRefused = [&](const std::vector<TileFile>& tiles, const std::vector<std::string>& words) {
        const std::string why = refusal(tiles);
        for (const std::string& word : words) EXPECT_NE(why.find(word), std::string::npos) << word << ": " << why;
    };
    const auto renamed = [&](const TileFile& tile, const std::string& name) {
        fs::copy_file(tile.path, path(name), fs::copy_options::overwrite_existing);
        return TileFile{path(name), name};
    };
    expectRefused({one, three}, {"1 of 3 tiles is missing: 2"});
    expectRefused({two}, {"2 of 3 tiles are missing: 1, 3"});
    expectRefused({one, two, three, renamed(two, "again.vdb")}, {"tile2of3.vdb", "again.vdb", "2/3"});
    bakeWhole(scene);
    expectRefused({one, two, {path("whole.vdb"), "whole.vdb"}}, {"whole.vdb", "no tile"});

    const auto other = [&](const Scene& scene_of, const BakeChoices& choices = {}) {
        fs::copy_file(three.path, path("kept.vdb"), fs::copy_options::overwrite_existing);
        const TileFile tile = renamed(bakeTile(scene_of, 3, 3, choices), "other.vdb");
        fs::copy_file(path("kept.vdb"), three.path, fs::copy_options::overwrite_existing);
        return tile;
    };
    Scene changed = scene;
    changed.hash ^= 1;
    expectRefused({one, two, other(changed)}, {"other.vdb", "another scene", "tile1of3.vdb"});
    changed = scene, changed.frame = 7;
    expectRefused({one, two, other(changed)}, {"other.vdb", "another frame", "7"});
    expectRefused({one, two, other(test::poolScene({}, 1.0 / 25))}, {"another grid", "0.04"});
    changed = scene, changed.bake.tolerance = 0.5;
    expectRefused({one, two, other(changed)}, {"other settings", "\"tolerance\":0.5"});
    BakeChoices choices;
    choices.file.compression = Compression::Zip;
    expectRefused({one, two, other(scene, choices)}, {"other.vdb", "zip"});
    expectRefused({renamed(bakeTile(scene, 1, 2), "half.vdb"), two, three}, {"count", "2/3"});
}

TEST_F(Tiles, AreRefusedWhereTheyWouldNotBeTheWhole) {
    const auto refusedFor = [&](const Scene& scene, const BakeChoices& choices, const std::string& word) {
        try {
            bakeTile(scene, 1, 2, choices);
            ADD_FAILURE() << word << " was baked";
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Usage);
            EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
        }
    };
    Scene scene = test::poolScene("[bake]\ngrids = [\"irradiance\", \"direction\", \"caustic\"]\n");
    BakeChoices choices;
    choices.post = {"sharpen=1,2"};
    refusedFor(scene, choices, "--post");
    scene.bake.prefilter = true;
    refusedFor(scene, {}, "prefilter");
    scene.bake.prefilter = false;
    for (const char* whole : {"eikonal", "wave"}) {
        scene.bake.method = whole;
        refusedFor(scene, {}, whole);
    }
}

TEST(TileBoxes, CoverTheFrameOnceAndEvenly) {
    GridFrame frame(glm::dmat3(0.1), glm::dvec3(0), {-37, 5, -300}, {611, 260, 411});
    const NeededVoxels all = NeededVoxels::everything(frame);
    for (const int count : {1, 2, 7, 8, 64, 100}) {
        const std::vector<VoxelBox> boxes = tileBoxes(all, count);
        ASSERT_EQ(boxes.size(), static_cast<std::size_t>(count));
        std::int64_t sum = 0, largest = 0;
        for (std::size_t i = 0; i < boxes.size(); ++i) {
            const glm::ivec3 size = boxes[i].size();
            const std::int64_t voxels = std::int64_t{size.x} * size.y * size.z;
            sum += voxels, largest = std::max(largest, voxels);
            EXPECT_TRUE(size.x > 0 && size.y > 0 && size.z > 0);
            for (std::size_t j = 0; j < i; ++j) {
                const bool apart = boxes[i].min.x > boxes[j].max.x || boxes[j].min.x > boxes[i].max.x ||
                                   boxes[i].min.y > boxes[j].max.y || boxes[j].min.y > boxes[i].max.y ||
                                   boxes[i].min.z > boxes[j].max.z || boxes[j].min.z > boxes[i].max.z;
                EXPECT_TRUE(apart);
            }
        }
        EXPECT_EQ(sum, frame.voxelCount());
        EXPECT_LT(static_cast<double>(largest) * count / static_cast<double>(sum), 1.4) << count;
    }
    // As many as there are leaves, and not one more.
    GridFrame small(glm::dmat3(0.1), glm::dvec3(0), {0, 0, 0}, {23, 15, 7});
    EXPECT_EQ(tileBoxes(NeededVoxels::everything(small), 6).size(), 6U);
    EXPECT_THROW(tileBoxes(NeededVoxels::everything(small), 7), Error);
}

TEST(TileBoxes, ShareOutWhatIsNeeded) {
    Record record;
    Scene scene = test::poolScene("[bake]\nwhere = \"receivers\"\n", 1.0 / 200);
    const NeededVoxels band = sceneNeededVoxels(scene, sceneFrame(scene), record);
    const std::vector<VoxelBox> boxes = tileBoxes(band, 8);
    const auto whole = std::make_shared<const NeededVoxels>(band);
    std::int64_t sum = 0;
    for (const VoxelBox& box : boxes) {
        const NeededVoxels part = NeededVoxels::partOf(whole, box, 2);
        EXPECT_GT(part.count(), part.tileCount());
        EXPECT_GT(part.tileCount(), band.count() / 12);
        EXPECT_LT(part.tileCount(), band.count() / 6);
        sum += part.tileCount();
    }
    EXPECT_EQ(sum, band.count());
}

}  // namespace
}  // namespace photic
