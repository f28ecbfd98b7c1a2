// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "bake/image/image.h"
#include "tests/cli/program.h"

namespace photic::test {
namespace {

using Strings = std::vector<std::string>;

struct PngSize {
    int width = 0, height = 0;
};
PngSize pngSize(const std::string& bytes) {
    const auto number = [&](std::size_t at) {
        int value = 0;
        for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
        return value;
    };
    return bytes.starts_with("\x89PNG") ? PngSize{number(16), number(20)} : PngSize{};
}

void bakeFlatPool(const Workplace& place) {
    PoolText pool;
    pool.surface = "flat = true";
    pool.sun_direction = "[0, 0, -1]";
    place.write("pool.toml", pool.text());
    const Outcome baked = photic(place, {"bake", "pool.toml"});
    ASSERT_EQ(baked.code, 0) << baked.err;
}

TEST(Picture, FloorUnderFlatWaterHasTheIrradianceOfFresnel) {
    const Workplace place;
    bakeFlatPool(place);
    const Outcome outcome = photic(place, {"picture", "pool.toml", "pool.vdb", "-o", "pictures", "--resolution", "64"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    for (const char* name :
         {"pool_floor.exr", "pool_floor.png", "pool_floor_map.png", "pool_xray_y.exr", "pool_xray_y_map.png"}) {
        EXPECT_TRUE(std::filesystem::exists(place / "pictures" / name)) << name;
    }
    const Image floor = readExr((place / "pictures/pool_floor.exr").string());
    ASSERT_EQ(floor.width, 64);
    ASSERT_EQ(floor.height, 64);
    const double transmitted = 1000 * (1 - std::pow(0.333 / 2.333, 2));
    for (const int x : {8, 32, 55}) {
        for (const int y : {8, 32, 55})
            EXPECT_NEAR(static_cast<double>(floor.at(x, y, 0)), transmitted, 2e-3 * transmitted);
    }
    EXPECT_EQ(pngSize(place.read("pictures/pool_floor.png")).width, 64);
    EXPECT_GT(pngSize(place.read("pictures/pool_floor_map.png")).width, 64 + 20);
}

TEST(Picture, SlicesViewsAndStripsAreMadeWhenAskedFor) {
    const Workplace place;
    bakeFlatPool(place);
    ASSERT_EQ(photic(place, {"picture", "pool.toml", "pool.vdb", "--slice", "z=-0.5", "--slice", "x=0.3",
                             "--resolution", "32"})
                  .code,
              0);
    EXPECT_EQ(place.names(), (Strings{"pool.toml", "pool.vdb", "pool_slice_x=0.3.exr", "pool_slice_x=0.3_map.png",
                                      "pool_slice_z=-0.5.exr", "pool_slice_z=-0.5_map.png"}));
    const Image slice = readExr((place / "pool_slice_z=-0.5.exr").string());
    const double transmitted = 1000 * (1 - std::pow(0.333 / 2.333, 2));
    EXPECT_NEAR(static_cast<double>(slice.at(16, 16, 0)), transmitted, 1e-3 * transmitted);

    ASSERT_EQ(photic(place, {"picture", "pool.toml", "pool.vdb", "--view-only", "--size", "90x60", "--samples", "1",
                             "--eye=-3,-4,3", "--shafts", "0.2"})
                  .code,
              0);
    const Image view = readExr((place / "pool_view.exr").string());
    EXPECT_EQ(view.width, 90);
    EXPECT_EQ(view.channels, 4);
    EXPECT_EQ(view.at(0, 0, 3), 0.0F);
    EXPECT_EQ(view.at(45, 30, 3), 1.0F);
    EXPECT_GT(view.at(45, 30, 2), 0.0F);

    std::filesystem::copy(place / "pool.vdb", place / "other.vdb");
    ASSERT_EQ(photic(place, {"picture", "pool.toml", "pool.vdb", "other.vdb", "--film-strip", "--receiver", "floor",
                             "--resolution", "50"})
                  .code,
              0);
    const PngSize strip = pngSize(place.read("pool_floor_strip.png"));
    EXPECT_EQ(strip.width, 2 * 50 + 3 * 6);
    EXPECT_FALSE(place.has("pool_floor.png"));
}

TEST(Picture, MistakesAreNamedBeforeAnythingIsWritten) {
    const Workplace place;
    bakeFlatPool(place);
    const Strings before = place.names();
    const auto expect = [&](int code, const Strings& options, const std::string& word) {
        Strings arguments{"picture", "pool.toml", "pool.vdb"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        const Outcome outcome = photic(place, arguments);
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
        EXPECT_EQ(place.names(), before);
    };
    expect(3, {"--receiver", "flor"}, "floor");
    expect(3, {"--receiver", "flor", "-o", "new/folder"}, "floor");
    expect(2, {"--slice", "w=1"}, "w=1");
    expect(2, {"--slice", "z=55"}, "z = 55");
    expect(2, {"--xray", "q"}, "q");
    expect(2, {"--view", "--eye=1,2"}, "--eye");
    expect(2, {"--view", "--size", "0x5"}, "0x5");
    expect(4, {"-o", "pool.toml/pictures"}, "pool.toml");
}

TEST(Picture, AVolumeOfAnotherSceneIsWarnedOf) {
    const Workplace place;
    bakeFlatPool(place);
    const Strings command{"picture", "pool.toml", "pool.vdb", "-o", "pictures", "--resolution", "16"};
    EXPECT_EQ(photic(place, command).err.find("another scene"), std::string::npos);

    const std::string scene = place.read("pool.toml");
    const auto change = [&](const std::string& from, const std::string& to) {
        std::string text = scene;
        const auto at = text.find(from);
        EXPECT_NE(at, std::string::npos) << text;
        if (at != std::string::npos) text.replace(at, from.size(), to);
        place.write("pool.toml", text);
        const Outcome outcome = photic(place, command);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return outcome.err;
    };
    EXPECT_NE(change("irradiance = 1000", "irradiance = 500").find("its light has 1000 W/m2"), std::string::npos);
    EXPECT_NE(change("min = [-1.0, -1.0, -1.2]\nmax = [ 1.0,", "min = [4.0, -1.0, -1.2]\nmax = [ 6.0,")
                  .find("wholly outside"),
              std::string::npos);
    // Whatever shows the two together says so.
    for (const Strings& shown :
         {Strings{"export", "pool.vdb", "--scene", "pool.toml", "--web", "page"},
          Strings{"export", "pool.vdb", "--scene", "pool.toml", "-o", "a.nvdb", "--budget", "9"}}) {
        const Outcome outcome = photic(place, shown);
        EXPECT_NE(outcome.err.find("another scene"), std::string::npos) << outcome.err;
    }
}

TEST(Picture, PointsThatAreNotFiniteAreRefused) {
    const Workplace place;
    bakeFlatPool(place);
    const Outcome outcome =
        photic(place, {"picture", "pool.toml", "pool.vdb", "-o", "pictures", "--view", "--eye", "nan,0,0"});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.err.find("not finite"), std::string::npos) << outcome.err;
}

TEST(Picture, ExportWritesAtlasAndSidecar) {
    const Workplace place;
    bakeFlatPool(place);
    ASSERT_EQ(photic(place, {"export", "pool.vdb", "-o", "atlas.exr"}).code, 0);
    EXPECT_TRUE(place.has("atlas.exr"));
    EXPECT_TRUE(nlohmann::json::parse(place.read("atlas.exr.json")).is_object());
}

TEST(Picture, ExportLaysFramesOutAlike) {
    const Workplace place;
    place.write("bump.toml", R"(photic = 1
[domain]
min = [-0.5, -0.5, -0.6]
max = [0.5, 0.5, 0.1]
resolution = 16
[[light]]
type = "sun"
direction = [0, 0, -1]
angular_diameter = 0
[[surface]]
name = "water"
size = [1, 1]
outside = "none"
bump = { height = 0.05, radius = 0.1 }
)");
    ASSERT_EQ(photic(place, {"bake", "bump.toml", "--frames", "1-2"}).code, 0);
    ASSERT_EQ(photic(place, {"export", "bump.0001.vdb", "bump.0002.vdb", "-o", "light.####.exr"}).code, 0);
    const auto first = nlohmann::json::parse(place.read("light.0001.exr.json"));
    const auto second = nlohmann::json::parse(place.read("light.0002.exr.json"));
    for (const char* key : {"width", "height", "columns", "slices", "index_min", "world_from_index", "scale"})
        EXPECT_EQ(first[key], second[key]) << key;
    EXPECT_EQ(first["metadata"]["frame"], "1");
    EXPECT_EQ(second["image"], "light.0002.exr");

    ASSERT_EQ(photic(place, {"bake", "bump.toml", "--resolution", "20", "--frames", "3-3"}).code, 0);
    const Outcome other = photic(place, {"export", "bump.0001.vdb", "bump.0003.vdb", "-o", "light.exr"});
    EXPECT_EQ(other.code, 3);
    EXPECT_NE(other.err.find("share a grid"), std::string::npos) << other.err;
    EXPECT_EQ(photic(place, {"export", "bump.0001.vdb", "bump.0001.vdb", "-o", "light.exr"}).code, 3);
}

}  // namespace
}  // namespace photic::test
