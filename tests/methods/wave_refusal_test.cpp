// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <memory>

#include "bake/methods/wave.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"
#include "tests/methods/wave_pool.h"

namespace photic {
namespace {

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Wave, CannotBakeWhatItCannot) {
    const auto refusal = [](const std::string& extra, const std::string& replace = {}, const std::string& with = {}) {
        std::string toml = Pool{.extra = extra}.toml();
        if (!replace.empty()) toml.replace(toml.find(replace), replace.size(), with);
        Monitor monitor;
        return std::string(waveMethod().refusal(parseScene(toml, "test.toml", ".", 0, monitor)));
    };
    EXPECT_EQ(refusal(""), "");
    EXPECT_EQ(refusal("[[object]]\nname = \"floor\"\nplane = { point = [0, 0, -0.7], normal = [0, 0, 1] }\n"), "");
    const char* const slope = "[[object]]\nname = \"slope\"\nplane = { point = [0, 0, -0.7], normal = [0, 0.3, 1] }\n";
    EXPECT_TRUE(has(refusal(slope), "role = \"movable\""));
    EXPECT_EQ(refusal(std::string(slope) + "role = \"movable\"\n"), "");
    EXPECT_TRUE(has(refusal("", "outside = \"flat\"", "outside = \"flat\"\nevent = \"reflect\""), "beams"));
    EXPECT_TRUE(has(refusal("", "voxel_size = 0.03125", "voxel_size = 0.03125\nshear = \"light\""), "shear"));
    Monitor quiet;
    const std::string times = Pool{.extra = "[bake]\ngrids = [\"arrival_time\"]\n"}.toml();
    try {
        chooseMethod("wave", parseScene(times, "test.toml", ".", 0, quiet));
        FAIL() << "a grid that the row does not name";
    } catch (const Error& error) {
        EXPECT_TRUE(has(error.what(), "arrival_time")) << error.what();
    }
    EXPECT_THROW(waveMethod().bake({}, nullptr, {{"cells", {std::int64_t{3}, "test"}}}, *std::make_unique<Monitor>()),
                 Error);
}

}  // namespace
}  // namespace photic
