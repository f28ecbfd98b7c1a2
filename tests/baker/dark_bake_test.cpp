// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/dark_bake.h"

#include <gtest/gtest.h>

#include "bake/baker/bake_scene.h"
#include "tests/baker/pool_scene.h"

namespace photic {
namespace {

using test::poolScene;
using test::Record;

/// The warning of a bake that lights nothing, or "".
std::string darkness(Scene scene, const std::string& method = "beams") {
    scene.bake.method = method;
    Record monitor;
    const double lit = bakeScene(scene, monitor).volume.field.sum(0);
    for (const std::string& warning : monitor.warnings)
        if (warning.starts_with("nothing is lit")) {
            EXPECT_EQ(lit, 0) << warning;
            return warning;
        }
    EXPECT_GT(lit, 0);
    return "";
}

// A lid keeps all light out: without a word it would be a volume like any other, and dark.
TEST(DarkBake, SaysWhereTheLightWent) {
    EXPECT_EQ(darkness(poolScene()), "");
    const std::string lid = "[[object]]\nname = \"lid\"\nbox = { min = [-99, -99, 0.5], max = [99, 99, 0.6] }\n";
    for (const char* method : {"beams"}) {
        const std::string said = darkness(poolScene(lid), method);
        EXPECT_NE(said.find("100 % of it ends on objects before it meets a surface"), std::string::npos) << said;
    }
    EXPECT_EQ(darkness(poolScene(lid + "role = \"movable\"\n")), "");
}

TEST(DarkBake, SaysThatNoLightMeetsASurface) {
    Scene lamp = poolScene();
    Light& light = lamp.lights[0];
    light.type = LightType::Spot, light.power = glm::dvec3(100), light.cone_angle_deg = 60;
    light.position = glm::dvec3(0, 0, 1), light.direction = {0, 0, 1};  // at the sky
    EXPECT_NE(darkness(lamp).find("no light meets a surface"), std::string::npos);
    light.direction = {0, 0, -1};
    EXPECT_EQ(darkness(lamp), "");
    // A lamp in the water shines up at it.
    light.position = glm::dvec3(0, 0, -0.1), light.direction = {0, 0, 1};
    EXPECT_EQ(darkness(lamp), "");
    light.direction = {0, 0, -1};
    EXPECT_NE(darkness(lamp).find("no light meets a surface"), std::string::npos);
}

TEST(DarkBake, LeavesOutWhatIsLittle) {
    PowerLedger power;
    power.emitted = 200, power.reflected = 150, power.culled = 49.5, power.escaped = 0.5;
    const std::string said = darkBakeWarning(power);
    EXPECT_NE(said.find("the 200 W of the lights: 75 % of it is reflected"), std::string::npos) << said;
    EXPECT_NE(said.find("24.8 % of it passes beside"), std::string::npos) << said;
    EXPECT_EQ(said.find("leaves the domain"), std::string::npos) << said;
}

}  // namespace
}  // namespace photic
