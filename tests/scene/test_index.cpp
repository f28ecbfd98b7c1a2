// SPDX-License-Identifier: Apache-2.0

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <sstream>

#include "bake/libraries/openvdb.h"
#include "bake/report/error.h"
#include "bake/scene/index_volume.h"
#include "tests/scene/scene_texts.h"

namespace photic {
namespace {

using test::SceneTest;
using test::SceneText;

const std::string kIndexFile = "[[index]]\nfile = \"index.vdb\"\n";

/// n = 1.3 + 0.1 x - 0.05 y + 0.02 z^2, of world places.
double quadratic(double x, double y, double z) { return 1.3 + 0.1 * x - 0.05 * y + 0.02 * z * z; }

class IndexVolumes : public SceneTest {
protected:
    void SetUp() override {
        SceneTest::SetUp();
        openvdb::initialize();
    }
    /// A grid of 0.25 m voxels, voxel (i, j, k) at 0.25 (i, j, k) + (0.1, 0, 0), over -12..12 along each axis.
    static openvdb::FloatGrid::Ptr boxGrid(const std::string& name) {
        auto grid = openvdb::FloatGrid::create(0);
        grid->setName(name);
        auto transform = openvdb::math::Transform::createLinearTransform(0.25);
        transform->postTranslate(openvdb::Vec3d(0.1, 0, 0));
        grid->setTransform(transform);
        for (int i = -12; i <= 12; ++i)
            for (int j = -12; j <= 12; ++j)
                for (int k = -12; k <= 12; ++k)
                    grid->tree().setValue({i, j, k}, float(quadratic(0.25 * i + 0.1, 0.25 * j, 0.25 * k)));
        return grid;
    }
    void writeGrids(const openvdb::GridPtrVec& grids) const { openvdb::io::File(path("index.vdb")).write(grids); }
    Scene loadWith(const std::string& index) {
        SceneText text;
        text.rest = index;
        return load(text);
    }
    void refusedIndex(const std::string& index, const std::string& where, const std::vector<std::string>& words) {
        SceneText text;
        text.rest = index;
        refused(text.all(), where, words);
    }
};

TEST_F(IndexVolumes, AreReadWithTheirTransform) {
    writeGrids({boxGrid("ior")});
    const Scene scene = loadWith(kIndexFile);
    ASSERT_TRUE(scene.index);
    for (const glm::dvec3 p : {glm::dvec3(0), glm::dvec3(0.3, -1.17, 2.11), glm::dvec3(-1.9, 0.01, -0.6)})
        EXPECT_NEAR(scene.index->at(p), quadratic(p.x, p.y, p.z), 1e-6);  // exact up to the second degree
    // A full box goes on as it is at its sides.
    EXPECT_NEAR(scene.index->at({9, 0, 0}), quadratic(3.1, 0, 0), 1e-6);
    EXPECT_NEAR(scene.index->steepest().x, 0.1, 1e-5);
    EXPECT_NEAR(scene.index->steepest().z, 0.02 * 2 * 3, 0.01);
    const std::uint64_t before = scene.hash;
    auto other = boxGrid("ior");
    other->tree().setValue({0, 0, 0}, 1.5f);
    writeGrids({other});
    EXPECT_NE(loadWith(kIndexFile).hash, before);
}

TEST_F(IndexVolumes, WhereTheyHoldNothingTheMediumIs) {
    auto grid = boxGrid("lens");
    grid->tree().setValueOff({0, 0, 0});
    writeGrids({grid, openvdb::Vec3SGrid::create()});
    const Scene scene = loadWith("[[index]]\nfile = \"index.vdb\"\ngrid = \"lens\"\n");
    EXPECT_FALSE(scene.index->full());
    EXPECT_NEAR(scene.index->at({0.1, 0, 0}), 1.333, 1e-6);
    EXPECT_NEAR(scene.index->at({50, 0, 0}), 1.333, 1e-6);
}

TEST_F(IndexVolumes, LayersNeedNoFile) {
    const Scene scene =
        loadWith("[[index]]\nlayers = [{ z = -1, n = 1.35 }, { z = 0, n = 1.33 }, { z = -2, n = 1.45 }]\n");
    EXPECT_NEAR(scene.index->at({7, -3, 0.5}), 1.33, 1e-6);
    EXPECT_NEAR(scene.index->at({0, 0, -0.5}), 1.34, 1e-6);
    EXPECT_NEAR(scene.index->at({0, 0, -1.25}), 1.375, 1e-6);
    EXPECT_NEAR(scene.index->at({0, 0, -9}), 1.45, 1e-6);
    EXPECT_NEAR(loadWith("[[index]]\nlayers = [{ z = 0, n = 1.4 }]\n").index->at({1, 2, 3}), 1.4, 1e-6);
}

TEST_F(IndexVolumes, HalfFloatsAreWarnedAbout) {
    auto grid = boxGrid("n");
    writeGrids({grid});
    loadWith(kIndexFile);
    EXPECT_TRUE(warnings_.messages.empty());
    grid->setSaveFloatAsHalf(true);
    writeGrids({grid});
    loadWith(kIndexFile);
    ASSERT_EQ(warnings_.messages.size(), 1u);
    EXPECT_NE(warnings_.messages[0].find("half floats, which hold an index near 1.33 to 0.001"), std::string::npos);
}

TEST_F(IndexVolumes, BadOnesAreRefused) {
    refusedIndex(kIndexFile, "s.toml:14:1", {"index.vdb", "No such file"});
    refusedIndex("[[index]]\n", "s.toml:13:1", {"'file'", "layers"});
    refusedIndex("[index]\nfile = \"a.vdb\"\n", "s.toml:13:", {"[[index]], with two brackets"});
    refusedIndex(kIndexFile + kIndexFile, "s.toml:15:1", {"2 index volumes"});
    refusedIndex("[[index]]\nlayers = []\n", "s.toml:14:1", {"empty"});
    refusedIndex("[[index]]\nlayers = [{ z = 0, n = 0 }]\n", "s.toml:14:", {"'n' is 0", "0.01"});
    refusedIndex("[[index]]\nlayers = [{ z = 0, n = 1 }, { z = 0, n = 2 }]\n", "s.toml:14:", {"two layers"});
    refusedIndex(kIndexFile + "layers = [{ z = 0, n = 1 }]\n", "s.toml:1", {"'file'", "'layers'"});
    write("index.vdb", "no volume at all");
    refusedIndex(kIndexFile, "s.toml:14:1", {"no .vdb file"});

    writeGrids({boxGrid("density"), boxGrid("temperature")});
    refusedIndex(kIndexFile, "s.toml:14:1", {"ior, index or n", "density (float)", "temperature (float)"});
    refusedIndex(kIndexFile + "grid = \"salt\"\n", "s.toml:14:1", {"no float grid 'salt'", "density (float)"});
    const auto bytes = [&] {
        std::ifstream in(path("index.vdb"), std::ios::binary);
        std::stringstream all;
        all << in.rdbuf();
        return all.str();
    }();
    for (const std::size_t part : {5, 100, 1000, 20000}) {
        write("index.vdb", bytes.substr(0, part));
        refusedIndex(kIndexFile, "s.toml:14:1", {"index.vdb"});
    }
    auto empty = openvdb::FloatGrid::create(1.3f);
    empty->setName("n");
    writeGrids({empty});
    refusedIndex(kIndexFile, "s.toml:14:1", {"no active voxel"});
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 0.0f,
                            -1.3f, 0.009f, 101.0f}) {
        auto grid = boxGrid("n");
        grid->tree().setValue({1, -2, 3}, bad);
        writeGrids({grid});
        refusedIndex(kIndexFile, "s.toml:14:1", {"voxel (1, -2, 3)", "0.01", "100"});
    }
}

/// Damaged files are refused, or what they say is read: OpenVDB itself writes past its buffers for some of these.
TEST_F(IndexVolumes, DamagedOnesDoNoHarm) {
    writeGrids({boxGrid("n")});
    std::ifstream in(path("index.vdb"), std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(in), {}};
    std::mt19937 random(5);
    int refusals = 0;
    const auto read = [&](const std::string& bytes) {
        try {
            readIndexVolume("index.vdb", bytes, "", 1.333, warnings_);
        } catch (const Error& e) {
            EXPECT_EQ(e.code(), ErrorCode::Input);
            EXPECT_NE(std::string(e.what()).find("index.vdb"), std::string::npos);
            ++refusals;
        }
    };
    for (int n = 0; n < 300; ++n) {
        std::string bytes = whole;
        for (int k = 0; k < 4; ++k)
            bytes[random() % (n % 2 ? bytes.size() : 1500)] ^= static_cast<char>(1u << random() % 8);
        read(bytes);
    }
    EXPECT_GT(refusals, 50);
    refusals = 0;
    for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 200) read(whole.substr(0, length));
    EXPECT_GE(refusals, 199);
}

}  // namespace
}  // namespace photic
