// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/cli/program.h"

namespace photic::test {
namespace {

TEST(Post, StepsAtTheBakeAndAfterItAreTheSame) {
    const Workplace place;
    PoolText pool;
    pool.bake = "method = \"eikonal\"\ngrids = [\"irradiance\", \"direction\", \"caustic\"]";
    place.write("pool.toml", pool.text());
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "-o", "a.vdb", "--f32"}).code, 0);
    EXPECT_EQ(photic(place, {"post", "a.vdb", "-o", "b.vdb", "--f32", "--step", "sharpen=0.5,1.5", "--as-light"}).code,
              0);
    EXPECT_EQ(photic(place, {"bake", "pool.toml", "-o", "c.vdb", "--f32", "--post", "sharpen=0.5,1.5"}).code, 0);
    EXPECT_EQ(photic(place, {"post", "c.vdb", "-o", "d.vdb", "--f32", "--as-light"}).code, 0);
    EXPECT_EQ(photic(place, {"compare", "b.vdb", "d.vdb", "--max-error", "1e-6"}).code, 0);
    EXPECT_EQ(photic(place, {"compare", "a.vdb", "d.vdb", "--max-error", "0.1"}).code, 1);

    const Outcome no_step = photic(place, {"post", "a.vdb", "-o", "e.vdb", "--step", "sharpen=2"});
    EXPECT_EQ(no_step.code, 2);
    EXPECT_NE(no_step.err.find("sharpen=A,B"), std::string::npos);
    EXPECT_EQ(photic(place, {"post", "a.vdb", "-o", "e.vdb", "--step", "dissipate=-0.5,0.9"}).code, 2);
    EXPECT_FALSE(place.has("e.vdb"));
}

}  // namespace
}  // namespace photic::test
