// SPDX-License-Identifier: Apache-2.0
// Glass by beams as a user meets it, every setting left as it is, against photons.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "bake/scene/load_toml.h"
#include "tests/conformance/against_photons.h"

namespace photic {
namespace {

/// A ball of 2 n x n quads as an OBJ file, around the origin; removed at the end.
class BallMesh {
public:
    BallMesh(int n, double radius) : path_(fmt::format("{}photic_ball_{}.obj", ::testing::TempDir(), ::getpid())) {
        std::ofstream out(path_);
        out << fmt::format("v 0 0 {0}\nv 0 0 -{0}\n", radius);
        for (int j = 1; j < n; ++j)
            for (int i = 0; i < 2 * n; ++i) {
                const double t = M_PI * j / n, p = M_PI * i / n;
                out << fmt::format("v {:.9f} {:.9f} {:.9f}\n", radius * std::sin(t) * std::cos(p),
                                   radius * std::sin(t) * std::sin(p), radius * std::cos(t));
            }
        const auto vertex = [n](int i, int j) { return 3 + (j - 1) * 2 * n + i % (2 * n); };
        for (int i = 0; i < 2 * n; ++i) {
            out << fmt::format("f 1 {} {}\n", vertex(i, 1), vertex(i + 1, 1));
            out << fmt::format("f 2 {} {}\n", vertex(i + 1, n - 1), vertex(i, n - 1));
            for (int j = 1; j + 1 < n; ++j)
                out << fmt::format("f {0} {1} {3}\nf {0} {3} {2}\n", vertex(i, j), vertex(i, j + 1), vertex(i + 1, j),
                                   vertex(i + 1, j + 1));
        }
    }
    ~BallMesh() { std::filesystem::remove(path_); }
    BallMesh(const BallMesh&) = delete;
    BallMesh& operator=(const BallMesh&) = delete;
    const std::string& path() const { return path_; }

private:
    std::string path_;
};

TEST(DefaultSettings, GlassDeepUnderWaterIsThePhotons) {
    // So fine that it is launched across the light, which meets the water far above it first.
    const BallMesh ball(48, 0.1);
    for (const std::string& kind :
         {std::string("kind = \"sphere\"\nradius = 0.1"), fmt::format("kind = \"mesh\"\nfile = \"{}\"", ball.path())}) {
        const std::string toml = fmt::format(R"(photic = 1
[domain]
min = [-0.3, -0.3, -2.1]
max = [0.3, 0.3, -1.3]
voxel_size = 0.025
[[light]]
type = "sun"
direction = [0.1, 0.2, -1]
angular_diameter = 0
[[medium]]
name = "glass"
ior = 1.5
priority = 1
[[surface]]
name = "water"
size = [6, 6]
flat = true
[[surface]]
name = "ball"
{}
inside = "glass"
event = "refract"
position = [0, 0, -1.6]
)",
                                             kind);
        const Compared c = againstPhotons(toml);
        EXPECT_LT(c.blocks, 0.005);
        EXPECT_NEAR(c.total, 0, 5e-4);
    }
}

TEST(DefaultSettings, FaintLightInsideOfACubeMakesNoSpeck) {
    // Its faces are two large triangles each, by which light behind many reflections must not be looked for.
    const std::string toml = R"(photic = 1
[domain]
min = [-0.4, -0.4, -0.02]
max = [0.4, 0.4, 0.4]
resolution = 64
[[light]]
type = "spot"
position = [-0.7, 0.3, 1.0]
direction = [0.6, -0.3, -0.85]
power = 40
angle = 40
[[medium]]
name = "glass"
ior = 1.52
absorption = 1.2
[[surface]]
kind = "mesh"
file = "tests/data/cube.obj"
scale = 0.18
position = [0, 0.05, 0.16]
rotation = [20, 35, 10]
inside = "glass"
event = "both"
)";
    Monitor monitor;
    const Scene scene = parseScene(toml, "cube.toml", PHOTIC_SOURCE_DIR, 0, monitor);
    const Baked beams = whole(bakeScene(scene, "beams")),
                reference = whole(bakeScene(scene, "photons", option("count", std::int64_t{500'000})));
    const LightField &a = beams.field(), &b = reference.field();
    EXPECT_LT(blockDifference(a, b, 4), 0.01);
    const GridFrame& f = a.frame();
    double most = 0;
    for (int k = f.min.z; k <= f.max.z; ++k)
        for (int j = f.min.y; j <= f.max.y; ++j)
            for (int i = f.min.x; i <= f.max.x; ++i)
                most = std::max(most, a.irradiance({i, j, k}) - b.irradiance({i, j, k}));
    // Of what falls on the cube, as at its brightest focus; one triangle's faint light in one voxel was 4.7.
    EXPECT_LT(most, 1.5 * scene.referenceIrradiance());
}

// Where all light is reflected there is no refracted leg that would tell of what stands before the surface: the ball's
// shadow on it was lost, and its light spread over the rest.
TEST(DefaultSettings, ShadowsFallWhereAllLightIsReflected) {
    const std::string path = fmt::format("{}photic_pane_{}.obj", ::testing::TempDir(), ::getpid());
    std::ofstream(path) << "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n";
    const auto toml = [&](const char* event) {
        return fmt::format(R"(photic = 1
[domain]
min = [-0.5, -0.5, -0.3]
max = [0.5, 0.5, 0.7]
voxel_size = 0.05
[[light]]
type = "sun"
direction = [0.9, 0, -0.43]
angular_diameter = 0
[[medium]]
name = "air"
ior = 1
[[medium]]
name = "glass"
ior = 1.5
[[surface]]
name = "pane"
kind = "mesh"
file = "{}"
scale = 0.4
rotation = [180, 0, 0]
outside = "air"
inside = "glass"
event = "{}"
[[object]]
role = "blocker"
sphere = {{ center = [-0.3, 0.05, 0.2], radius = 0.1 }}
)",
                           path, event);
    };
    for (const char* event : {"both", "reflect"}) {
        const Compared c = againstPhotons(toml(event), 400'000);
        EXPECT_NEAR(c.total, 0, 0.004) << event;
        EXPECT_LT(c.blocks, 0.02) << event;
    }
    std::filesystem::remove(path);
}

// Tubes as wide as voxels see neither the facet by which light leaves a body of one or two of them nor how far it has
// gone in it: 9 and 7 % of the first two's light were missing.
TEST(DefaultSettings, GlassOfAVoxelOrTwoIsThePhotons) {
    for (const char* direction : {"[0.01, -0.01, -1]", "[0.006, -0.58, -0.81]"})
        for (const double voxel : {0.12, 0.06}) {
            const std::string toml = fmt::format(R"(photic = 1
[domain]
min = [-0.24, -0.24, -0.36]
max = [0.24, 0.24, 0.12]
voxel_size = {}
[[light]]
type = "sun"
direction = {}
angular_diameter = 0
[[medium]]
name = "glass"
ior = 1.127
[[surface]]
kind = "mesh"
file = "{}/tests/data/cube.obj"
scale = 0.06
position = [0.01, -0.02, -0.03]
rotation = [0, 0, 20]
smooth = false
inside = "glass"
event = "refract"
)",
                                                 voxel, direction, PHOTIC_SOURCE_DIR);
            const Baked beams = whole(bakeText(toml, "beams")),
                        photons = whole(bakeText(toml, "photons", option("count", std::int64_t{400'000})));
            const double off = total(beams.field()) / total(photons.field()) - 1;
            fmt::print("  along {}, voxels of {} m: {:+.4f}\n", direction, voxel, off);
            EXPECT_NEAR(off, 0, 0.006);
            // Tubes of a 64th of a voxel, summed in single precision.
            EXPECT_LT(beams.result.report.path.imbalance(), 1e-5);
        }
}

TEST(DefaultSettings, WhereTheIndexIsTheSameThereIsNoGlass) {
    const auto toml = [](bool ball) {
        return fmt::format(R"(photic = 1
[domain]
min = [-0.3, -0.3, -0.9]
max = [0.3, 0.3, -0.1]
voxel_size = 0.025
[[light]]
type = "sun"
direction = [0.1, 0.2, -1]
angular_diameter = 0
[[medium]]
name = "glass"
ior = 1.333
priority = 1
[[surface]]
name = "water"
size = [6, 6]
flat = true
{})",
                           ball ? "[[surface]]\nname = \"ball\"\nkind = \"sphere\"\nradius = 0.1\ninside = \"glass\"\n"
                                  "event = \"both\"\nposition = [0, 0, -0.5]\n"
                                : "");
    };
    const Baked with = whole(bakeText(toml(true), "beams")), without = whole(bakeText(toml(false), "beams"));
    // What its outline misplaces, of the 9 % of the light that go through it.
    EXPECT_NEAR(total(with.field()) / total(without.field()), 1, 5e-4);
    EXPECT_LT(blockDifference(with.field(), without.field(), 2), 2e-3);
}

// Light that comes from clear glass to glass that parts its colours was laid once for every wavelength, whole: twelve
// times. Here it is coloured besides, by its lamp and by the glass that it comes
// through.
TEST(DefaultSettings, ColoursPartBehindOtherGlassToo) {
    const std::string toml = R"(photic = 1
[domain]
min = [-0.6, -0.6, -1.2]
max = [0.6, 0.6, 0.8]
resolution = 32
[[light]]
type = "sun"
direction = [0.3, 0.1, -1]
irradiance = [1000, 600, 200]
angular_diameter = 0
[[medium]]
name = "tinted"
ior = 1.5
absorption = [0.2, 2, 5]
[[medium]]
name = "flint"
abbe = [1.6, 30]
[[surface]]
name = "upper"
kind = "sphere"
position = [0, 0, 0.4]
radius = 0.25
inside = "tinted"
event = "both"
[[surface]]
name = "lower"
kind = "sphere"
position = [0.05, 0, -0.4]
radius = 0.3
inside = "flint"
event = "both"
[[object]]
name = "floor"
plane = { point = [0, 0, -1], normal = [0, 0, 1] }
)";
    const Baked beams = whole(bakeText(toml, "beams")),
                photons = whole(bakeText(toml, "photons", option("count", std::int64_t{500'000})));
    EXPECT_LT(beams.result.report.power.imbalance(), 1e-6);
    EXPECT_LT(beams.result.report.path.imbalance(), 1e-5);
    EXPECT_LT(blockDifference(beams.field(), photons.field(), 4), 0.02);
    EXPECT_NEAR(total(beams.field()) / total(photons.field()), 1, 0.002);
}

}  // namespace
}  // namespace photic
