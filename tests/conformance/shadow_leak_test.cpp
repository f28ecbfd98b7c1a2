// SPDX-License-Identifier: Apache-2.0
// Where shadows begin and what look-ups see of them: walls thinner than a voxel, things on a floor, sand.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

#include "bake/picture/receiver_picture.h"
#include "bake/picture/volume_lookup.h"
#include "bake/scene/load_toml.h"
#include "tests/conformance/bake_scene.h"
#include "tests/support/blocked_light.h"

namespace photic {
namespace {

LightVolume volumeOf(Baked&& baked) { return LightVolume{std::move(baked.result.volume.field)}; }

/// Mean irradiance over the texels of a floor [m2 of full light], missing against `lit`.
double missingArea(const LightVolume& volume, const PictureFrame& frame, double lit) {
    const Image image = receiverPicture(volume, frame);
    double missing = 0;
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x) missing += 1 - image.at(x, y, 0) / lit;
    return missing / frame.width / frame.height * glm::length(frame.across) * glm::length(frame.up);
}

std::string wallUnderFlatWater(double voxel, double thickness, const char* role) {
    return fmt::format(R"(photic = 1
[domain]
min = [-0.5, -0.5, -1.1]
max = [0.5, 0.5, 0.05]
voxel_size = {}
[[light]]
type = "sun"
direction = [0.35, 0.0, -1.0]
irradiance = 1.0
angular_diameter = 0.0
[[surface]]
name = "water"
size = [4.0, 4.0]
flat = true
[[object]]
name = "floor"
plane = {{ point = [0, 0, -1] }}
[[object]]
name = "wall"
role = "{}"
box = {{ min = [{}, -0.3, -1.0], max = [0.0, 0.3, -0.4] }}
)",
                       voxel, role, -thickness);
}

/// The light in the darkest part of a wall's shadow that stands further than two voxels behind its lit side, over
/// unshadowed light: the largest in any voxel that lies wholly in the shadow.
double brightestBehindWall(double voxel, double thickness, const char* role) {
    const Baked baked = bakeText(wallUnderFlatWater(voxel, thickness, role), "beams");
    const glm::dvec3 w = truth::refractDown(glm::normalize(glm::dvec3(0.35, 0, -1)), {0, 0}, 1.333)->direction;
    const truth::Box wall{{-thickness, -0.3, -1.0}, {0, 0.3, -0.4}};
    const GridFrame& f = baked.field().frame();
    double brightest = 0, lit = 0;
    int in_shadow = 0;
    for (int k = f.min.z; k <= f.max.z; ++k) {
        for (int j = f.min.y; j <= f.max.y; ++j) {
            for (int i = f.min.x; i <= f.max.x; ++i) {
                const glm::dvec3 low = glm::dvec3(i, j, k) * voxel, high = low + voxel;
                lit = std::max(lit, baked.irradiance(i, j, k));
                if (low.x < std::max(0.0, 2 * voxel - thickness) || low.z < -1.0) continue;
                bool shaded = true;
                for (int c = 0; c < 8; ++c) {
                    const glm::dvec3 corner(c & 1 ? high.x : low.x, c & 2 ? high.y : low.y, c & 4 ? high.z : low.z);
                    shaded = shaded && truth::meets(wall, corner, -w);
                }
                if (!shaded) continue;
                ++in_shadow, brightest = std::max(brightest, baked.irradiance(i, j, k));
            }
        }
    }
    EXPECT_GT(in_shadow, 50);
    return brightest / lit;
}

TEST(ShadowLeak, AThinWallIsDarkBehind) {
    for (const double voxel : {0.0125, 0.025})
        for (const double thickness : {0.01, 0.002})
            for (const char* const role : {"receiver", "blocker"})
                EXPECT_LT(brightestBehindWall(voxel, thickness, role), 1e-3)
                    << 1e3 * thickness << " mm, voxels of " << 1e3 * voxel << " mm, " << role;
}

TEST(ShadowLeak, AThinWallsShadowOnTheFloorIsWhole) {
    // A blocker: nobody looks up light on it, so none need go on behind it.
    PictureFrame frame;
    frame.origin = {-0.1, -0.4, -1}, frame.across = {0.5, 0, 0}, frame.up = {0, 0.8, 0};
    frame.width = 500, frame.height = 800;
    const glm::dvec3 w = truth::refractDown(glm::normalize(glm::dvec3(0.35, 0, -1)), {0, 0}, 1.333)->direction;
    const double area = truth::shadowArea(truth::Box{{-0.001, -0.3, -1.0}, {0, 0.3, -0.4}}, w);
    for (const double voxel : {0.02, 0.04}) {
        const LightVolume dark = volumeOf(bakeText(wallUnderFlatWater(voxel, 0.001, "blocker"), "beams")),
                          open = volumeOf(bakeText(wallUnderFlatWater(voxel, 0.001, "movable"), "beams"));
        const double lit = VolumeLookup(open).receiverIrradiance({0.2, 0.1, -1}, {0, 0, 1}).x;
        EXPECT_NEAR(missingArea(dark, frame, lit) / area, 1, 0.05) << "voxels of " << 1e3 * voxel << " mm";
    }
}

std::string ballOnFloor(double voxel, const char* role) {
    return fmt::format(R"(photic = 1
[domain]
min = [-0.5, -0.5, -1.6]
max = [0.5, 0.5, 0.1]
voxel_size = {}
[[light]]
type = "sun"
direction = [0, 0, -1]
irradiance = 1.0
angular_diameter = 0
[[surface]]
name = "water"
size = [4, 4]
waves = [{{ amplitude = 0.0001, wavelength = 0.4, direction = 20 }}]
[[object]]
name = "floor"
plane = {{ point = [0, 0, -1.5] }}
[[object]]
name = "rock"
role = "{}"
sphere = {{ center = [0, 0, -1.35], radius = 0.15 }}
)",
                       voxel, role);
}

TEST(ShadowLeak, ABallOnTheFloorHasAWholeShadow) {
    PictureFrame frame;
    frame.origin = {-0.25, -0.25, -1.5}, frame.across = {0.5, 0, 0}, frame.up = {0, 0.5, 0};
    for (const double voxel : {0.02, 0.01})
        for (const char* const role : {"receiver", "blocker"}) {
            const LightVolume lit = volumeOf(bakeText(ballOnFloor(voxel, "movable"), "beams")),
                              dark = volumeOf(bakeText(ballOnFloor(voxel, role), "beams"));
            const double full = 1 - missingArea(lit, frame, 1) / 0.25;
            const double area = (missingArea(dark, frame, 1) - missingArea(lit, frame, 1)) / full;
            EXPECT_NEAR(area / (std::numbers::pi * 0.15 * 0.15), 1, 0.05)
                << "voxels of " << 1e3 * voxel << " mm, " << role;
        }
}

/// The example's sand with and without the objects that are buried in it.
struct Sand {
    LightVolume with, without;
    PictureFrame frame;
};

Sand bakeSand(double voxel) {
    Monitor monitor;
    Scene scene = loadScene(PHOTIC_SOURCE_DIR "/examples/buried_in_sand/buried_in_sand.toml", 0, monitor);
    scene.domain.voxel_size = voxel;
    scene.bake.where = Where::Receivers;
    scene.lights[0].angular_diameter_deg = 0;  // a disc of its size takes as much light away, elsewhere
    Scene bare = scene;
    bare.objects.resize(1);
    return {volumeOf(bakeScene(scene, "beams")), volumeOf(bakeScene(bare, "beams")),
            receiverFrame(scene, "sand", 1000)};
}

// The light that the example's objects take from the sand around them, per W/m2 of the mean on bare sand [m2].
double missingFromSand(double voxel) {
    const Sand sand = bakeSand(voxel);
    const PictureFrame& frame = sand.frame;
    const VolumeLookup shaded(sand.with), open(sand.without);
    double missing = 0, lit = 0;
    for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
            const glm::dvec3 p =
                frame.origin + (x + 0.5) / frame.width * frame.across + (y + 0.5) / frame.height * frame.up;
            // Nobody sees the sand inside of things.
            const bool inside = glm::distance(p, glm::dvec3(0.35, 0.35, -0.75)) < 0.26 ||
                                glm::distance(p, glm::dvec3(-0.55, 0.25, -1.25)) < 0.22 ||
                                (p.x > -0.15 && p.x < 0.25 && p.y > -0.65 && p.y < -0.25 && p.z < -0.72);
            if (inside) continue;
            const double e = open.receiverIrradiance(p, frame.normal).x;
            lit += e, missing += e - shaded.receiverIrradiance(p, frame.normal).x;
        }
    }
    return missing / lit * glm::length(frame.across) * glm::length(frame.up);
}

// Half a voxel of 12 mm is more than these shadows' edges can spare: 4 % less is missing there. It seemed to be 1 %, as
// sand in the sun beside the objects was too dark by as much.
TEST(ShadowLeak, SandIsShadedAlikeAtTwiceTheResolution) {
    const double coarse = missingFromSand(0.006), fine = missingFromSand(0.003);
    fmt::print("  missing from the sand: {:.5f} m2 at 6 mm, {:.5f} m2 at 3 mm\n", coarse, fine);
    EXPECT_NEAR(coarse / fine, 1, 0.02);
    EXPECT_GT(fine, 0.02);
}

// On the sun's side of the crate nothing stands between sun and sand, right up to it. Half a voxel from it the sand was
// a sixth too dark: light ended where it met the second of two bodies that are stuck into one another.
TEST(ShadowLeak, SandIsLitUpToWhatIsBuriedInIt) {
    constexpr double kVoxel = 0.012;
    const Sand sand = bakeSand(kVoxel);
    const VolumeLookup beside(sand.with), open(sand.without);
    double light = 0, off = 0;
    constexpr int kPoints = 200;
    for (int i = 0; i < kPoints; ++i)
        for (const double away : {0.1, 0.3, 0.5, 0.8, 1.2}) {
            const double x = -0.1 + 0.3 * (i + 0.5) / kPoints, y = -0.65 - away * kVoxel;
            const glm::dvec3 p(x, y, -1 + 0.5 * x);
            const double e = open.receiverIrradiance(p, sand.frame.normal).x;
            light += e, off += std::fabs(beside.receiverIrradiance(p, sand.frame.normal).x - e);
        }
    EXPECT_LT(off / light, 0.02);
}

}  // namespace
}  // namespace photic
