// SPDX-License-Identifier: Apache-2.0
// Every input that cannot be used: its exit code, a message that names what is wrong, nothing left behind, and an
// existing output as it was.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "bake/image/image.h"
#include "tests/cli/program.h"
#include "tests/cli/schema.h"

namespace photic::test {
namespace {

using Strings = std::vector<std::string>;
constexpr const char* kOldVolume = "the old volume";

/// Runs a bake that must fail, with an old output in place.
void expectRefused(const Workplace& place, const Strings& extra, int code, const Strings& words) {
    place.write("pool.vdb", kOldVolume);
    const Strings before = place.names();
    Strings arguments{"bake", "pool.toml"};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    const Outcome outcome = photic(place, arguments);
    EXPECT_EQ(outcome.code, code) << outcome.err;
    for (const std::string& word : words)
        EXPECT_NE(outcome.err.find(word), std::string::npos) << "'" << word << "' is not in: " << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(place.names(), before);
    EXPECT_EQ(place.read("pool.vdb"), kOldVolume);

    // The same as an event, and as its last.
    arguments.push_back("--progress=json");
    const Outcome with_events = photic(place, arguments);
    EXPECT_EQ(with_events.code, code);
    const auto events = with_events.events();
    ASSERT_FALSE(events.empty());
    EXPECT_EQ(schemaBreaches(events.back(), "progress.md", "`error`"), Strings{});
    EXPECT_EQ(events.back()["code"], code);
}

void expectSceneRefused(const PoolText& pool, int code, const Strings& words) {
    const Workplace place;
    place.write("pool.toml", pool.text());
    expectRefused(place, {}, code, words);
}

/// A height map of 16 x 16 floats as EXR.
void writeHeights(const Workplace& place, const std::string& name, const std::function<float(int, int)>& height) {
    Image image{16, 16, 1, std::vector<float>(256)};
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) image.at(x, y, 0) = height(x, y);
    }
    writeExr((place / name).string(), image);
}

constexpr const char* kMapSurface = "file = \"water.exr\"\nchannel = \"Y\"";

TEST(BadInput, MissingScene) {
    const Workplace place;
    expectRefused(place, {}, 3, {"pool.toml"});
}

TEST(BadInput, SceneThatIsNoToml) {
    const Workplace place;
    place.write("pool.toml", "photic = 1\n[domain\n");
    expectRefused(place, {}, 3, {"pool.toml:2"});
}

TEST(BadInput, MissingHeightMap) {
    PoolText pool;
    pool.surface = kMapSurface;
    expectSceneRefused(pool, 3, {"water.exr"});
}

TEST(BadInput, TruncatedHeightMap) {
    const Workplace place;
    PoolText pool;
    pool.surface = kMapSurface;
    place.write("pool.toml", pool.text());
    writeHeights(place, "water.exr", [](int x, int) { return 0.001F * static_cast<float>(x); });
    const std::string whole = place.read("water.exr");
    for (const double share : {0.0, 0.1, 0.6, 0.95}) {
        place.write("water.exr", whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
        expectRefused(place, {}, 3, {"water.exr"});
    }
}

TEST(BadInput, HeightsThatAreNoNumbers) {
    for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity()}) {
        const Workplace place;
        PoolText pool;
        pool.surface = kMapSurface;
        place.write("pool.toml", pool.text());
        writeHeights(place, "water.exr", [bad](int x, int y) { return x == 5 && y == 7 ? bad : 0.0F; });
        expectRefused(place, {}, 3, {"water.exr", "5", "7"});
    }
}

TEST(BadInput, ZeroVoxelSize) {
    PoolText pool;
    for (const double size : {0.0, -0.1}) {
        pool.voxel_size = size;
        expectSceneRefused(pool, 3, {"pool.toml:5", "voxel_size"});
    }
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    expectRefused(place, {"--voxel-size", "0"}, 2, {"--voxel-size"});
    expectRefused(place, {"--resolution", "-3"}, 2, {"--resolution"});
}

TEST(BadInput, ABoxOfAMillionMillionVoxels) {
    PoolText pool;
    pool.voxel_size = 0.00017;  // 2 m x 2 m x 1.3 m: 1.06e12 voxels
    expectSceneRefused(pool, 3, {"pool.toml:2", "2^38", "use voxels of"});
    // Fewer, but more than fit in the memory that is allowed.
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    expectRefused(place, {"--resolution", "2000", "--max-memory", "1GB"}, 4, {"--max-memory", "receivers"});
    expectRefused(place, {"--resolution", "2000", "--max-memory", "100MB", "--where", "receivers"}, 4,
                  {"--max-memory"});
}

TEST(BadInput, UnknownKeys) {
    PoolText pool;
    pool.bake = "quadratur = 2";
    expectSceneRefused(pool, 3, {"pool.toml:", "quadratur", "did you mean", "quadrature"});
    pool.bake = "[bake.beams]\nmesch = 2";
    expectSceneRefused(pool, 3, {"mesch", "did you mean", "mesh"});
    pool.bake = "[bake.beems]\nmesh = 2";
    expectSceneRefused(pool, 3, {"beems", "did you mean", "beams"});
    pool.bake = "method = \"beems\"";
    expectSceneRefused(pool, 3, {"beems", "beams"});
    pool.bake = "grids = [\"irradience\"]";
    expectSceneRefused(pool, 3, {"irradience", "irradiance"});
}

TEST(BadInput, FilesThatAreOneAndTheSame) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const std::string scene = place.read("pool.toml");
    expectRefused(place, {"--report", "pool.toml"}, 2, {"the scene", "the report", "one file"});
    expectRefused(place, {"-o", "pool.vdb", "--report", "./pool.vdb"}, 2, {"the report", "the volume"});
    expectRefused(place, {"-o", "pool.vdb", "--method", "photons", "--standard-error", "pool.vdb"}, 2,
                  {"the standard error"});
    EXPECT_EQ(place.read("pool.toml"), scene);
}

TEST(BadInput, ASurfaceThatTowersOverTheDomain) {
    PoolText pool;
    for (const char* height : {"1e30", "1e300"}) {
        pool.surface = std::string("waves = [{ amplitude = ") + height + ", wavelength = 1.0 }]";
        expectSceneRefused(pool, 3, {"water", "lower surface"});
    }
    pool = {};
    pool.bake = "[bake.beams]\nspacing = 1e-9";
    expectSceneRefused(pool, 3, {"larger spacing"});
}

TEST(BadInput, AnObjectBeyondAllBounds) {
    PoolText pool;
    pool.extra = "[[object]]\nname = \"moon\"\nsphere = { center = [-1e300, 0, -1], radius = 0.1 }\n";
    expectSceneRefused(pool, 3, {"moon", "from the origin"});
}

TEST(BadInput, AKeyWithoutABottom) {
    PoolText pool;
    for (int i = 0; i < 50000; ++i) pool.extra += "a.";
    pool.extra += "b = 1\n";
    expectSceneRefused(pool, 3, {"pool.toml:", "dotted"});
}

TEST(BadInput, ASunFromBelow) {
    PoolText pool;
    pool.sun_direction = "[0.4, 0.2, 0.5]";
    expectSceneRefused(pool, 3, {"pool.toml:", "direction"});
}

TEST(BadInput, MediaThatContradictThemselves) {
    PoolText pool;
    pool.extra = "[medium]\nabsorption = [-0.1, 0.1, 0.1]";
    expectSceneRefused(pool, 3, {"absorption", "-0.1"});
    pool.extra = "[medium]\nscattering = 0.1\nanisotropy = 1.5";
    expectSceneRefused(pool, 3, {"anisotropy", "1.5"});
    pool.extra = "[medium]\nabsorption = 0.1\n[medium]\nabsorption = 0.2";
    expectSceneRefused(pool, 3, {"pool.toml:", "medium"});
    // A medium below a surface that nothing passes.
    pool.extra = "[medium]\nabsorption = 0.1";
    pool.surface = "flat = true\nevent = \"reflect\"";
    expectSceneRefused(pool, 3, {"medium"});
}

TEST(BadInput, OutputsThatCannotBeWritten) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    place.write("file", "a regular file");
    std::filesystem::create_directory(place / "folder.vdb");
    expectRefused(place, {"-o", "file/pool.vdb"}, 4, {"file"});
    expectRefused(place, {"-o", "folder.vdb"}, 4, {"directory"});
    expectRefused(place, {"--report", "folder.vdb"}, 4, {"directory"});
    expectRefused(place, {"-o", "pool.exr"}, 2, {".vdb"});
}

TEST(BadInput, AWriteThatRunsOutOfSpace) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    place.write("pool.vdb", kOldVolume);
    for (const std::int64_t limit : {100, 5000, 40000}) {
        const Outcome outcome = photic(place, {"bake", "pool.toml", "--f32"}, limit);
        EXPECT_EQ(outcome.code, 4) << outcome.err;
        EXPECT_NE(outcome.err.find("pool.vdb"), std::string::npos) << outcome.err;
        EXPECT_EQ(place.names(), (Strings{"pool.toml", "pool.vdb"}));
        EXPECT_EQ(place.read("pool.vdb"), kOldVolume);
    }
    // Pictures and atlases too.
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    EXPECT_EQ(photic(place, {"picture", "pool.toml", "pool.vdb", "--receiver", "floor"}, 5000).code, 4);
    EXPECT_EQ(photic(place, {"export", "pool.vdb", "-o", "atlas.exr"}, 5000).code, 4);
    EXPECT_EQ(place.names(), (Strings{"pool.toml", "pool.vdb"}));
}

TEST(BadInput, VolumesThatAreNone) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    place.write("text.vdb", "no volume at all");
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    const std::string whole = place.read("pool.vdb");
    place.write("half.vdb", whole.substr(0, whole.size() / 2));
    const Strings before = place.names();
    for (const std::string name : {"missing.vdb", "text.vdb", "half.vdb"}) {
        for (const Strings& command :
             {Strings{"inspect", name}, Strings{"inspect", name, "--json"}, Strings{"compare", "pool.vdb", name},
              Strings{"picture", "pool.toml", name}, Strings{"export", name, "-o", "a.exr"}}) {
            const Outcome outcome = photic(place, command);
            EXPECT_EQ(outcome.code, 3) << command[0] << ' ' << outcome.err;
            EXPECT_NE(outcome.err.find(name), std::string::npos) << outcome.err;
            EXPECT_EQ(outcome.out, "");
        }
    }
    EXPECT_EQ(place.names(), before);
}

TEST(BadInput, WhatIsNotBuiltYetIsRefusedByName) {
    PoolText pool;
    pool.bake = "method = \"beams\"\ngrids = [\"irradiance\", \"arrival_time\"]";
    expectSceneRefused(pool, 3, {"arrival_time"});
}

}  // namespace
}  // namespace photic::test
