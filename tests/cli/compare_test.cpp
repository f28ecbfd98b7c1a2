// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "bake/image/image.h"
#include "tests/cli/program.h"
#include "tests/cli/schema.h"

namespace photic::test {
namespace {

using Strings = std::vector<std::string>;

TEST(Compare, MeasuresImagesExactly) {
    const Workplace place;
    Image b{4, 2, 1, {1, 2, 3, 4, 5, 6, 7, 8}}, a = b;
    a.at(2, 1, 0) += 3;     // the 7
    a.at(0, 0, 0) -= 0.5F;  // the 1
    writeExr((place / "a.exr").string(), a);
    writeExr((place / "b.exr").string(), b);
    const Outcome outcome = photic(place, {"compare", "a.exr", "b.exr", "--json", "--max-error", "0.0973"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const auto document = outcome.json();
    EXPECT_EQ(schemaBreaches(document, "compare.md", "Images"), Strings{});
    EXPECT_NEAR(document["irradiance"]["relative_l1"].get<double>(), 3.5 / 36, 1e-12);
    EXPECT_NEAR(document["irradiance"]["relative_l2"].get<double>(), std::sqrt(9.25 / 8) / 4.5, 1e-12);
    EXPECT_NEAR(document["irradiance"]["energy_ratio"].get<double>(), 38.5 / 36, 1e-12);
    EXPECT_EQ(document["irradiance"]["worst"]["pixel"], (nlohmann::json{2, 1}));
    EXPECT_EQ(document["irradiance"]["worst"]["difference"], 3.0);

    EXPECT_EQ(photic(place, {"compare", "a.exr", "b.exr", "--max-error", "0.0972"}).code, 1);
    EXPECT_EQ(photic(place, {"compare", "a.exr", "b.exr"}).code, 0);
    EXPECT_EQ(photic(place, {"compare", "b.exr", "b.exr", "--max-error", "0", "--difference", "d.png"}).code, 0);
    EXPECT_TRUE(place.has("d.png"));

    // A NaN is beyond every limit.
    a.at(3, 0, 0) = std::nanf("");
    writeExr((place / "a.exr").string(), a);
    EXPECT_EQ(photic(place, {"compare", "a.exr", "b.exr", "--max-error", "1000"}).code, 1);

    Image wide{5, 2, 1, std::vector<float>(10)};
    writeExr((place / "wide.exr").string(), wide);
    EXPECT_EQ(photic(place, {"compare", "wide.exr", "b.exr"}).code, 3);
}

TEST(Compare, VolumesAreComparedVoxelByVoxel) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "-o", "full.vdb"}).code, 0);
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "-o", "exact.vdb", "--f32"}).code, 0);
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "-o", "band.vdb", "--where", "receivers"}).code, 0);
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "-o", "coarse.vdb", "--voxel-size", "0.125"}).code, 0);

    // Half floats round to 2^-12 relative, so their mean error is about half of that.
    const Outcome half = photic(place, {"compare", "full.vdb", "exact.vdb", "--json"});
    ASSERT_EQ(half.code, 0) << half.err;
    const auto document = half.json();
    EXPECT_EQ(schemaBreaches(document, "compare.md", "Volumes"), Strings{});
    EXPECT_GT(document["error"].get<double>(), 1e-6);
    EXPECT_LT(document["error"].get<double>(), 5e-4);
    EXPECT_NEAR(document["irradiance"]["energy_ratio"].get<double>(), 1, 1e-4);

    // A band is the whole volume with most voxels missing, numbered by its own leaves: the union counts them.
    const auto band = photic(place, {"compare", "band.vdb", "full.vdb", "--json"}).json();
    EXPECT_EQ(band["count"], document["count"]);
    EXPECT_LT(band["irradiance"]["energy_ratio"].get<double>(), 0.5);
    EXPECT_EQ(photic(place, {"compare", "band.vdb", "full.vdb", "--max-error", "0.1"}).code, 1);
    const auto& worst = band["irradiance"]["worst"];
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(worst["world"][static_cast<std::size_t>(axis)].get<double>(),
                    (worst["index"][static_cast<std::size_t>(axis)].get<int>() + 0.5) / 16, 1e-6);
    }

    const Outcome coarse = photic(place, {"compare", "coarse.vdb", "full.vdb"});
    EXPECT_EQ(coarse.code, 3);
    EXPECT_NE(coarse.err.find("coincide"), std::string::npos) << coarse.err;
}

}  // namespace
}  // namespace photic::test
