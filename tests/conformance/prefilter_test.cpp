// SPDX-License-Identifier: Apache-2.0
// Look-ups in a prefiltered volume against the truth and against look-ups in the plain one, wherever the floor lies in
// its voxel.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "bake/field/prefilter.h"
#include "bake/picture/receiver_picture.h"
#include "tests/conformance/bake_scene.h"
#include "tests/support/closed_forms.h"

namespace photic {
namespace {

using truth::pool3::SceneText;

/// A picture of `texels` by `texels`, row 0 at the bottom, each the mean of 2 x 2 look-ups.
std::vector<double> looked(const LightVolume& volume, PictureFrame frame, int texels) {
    constexpr int kOver = 2;
    frame.width = frame.height = texels * kOver;
    const Image image = receiverPicture(volume, frame);
    std::vector<double> map(static_cast<std::size_t>(texels) * static_cast<std::size_t>(texels));
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
            map[static_cast<std::size_t>(y / kOver * texels + x / kOver)] +=
                double(image.at(x, frame.height - 1 - y, 0)) / (kOver * kOver);
    return map;
}

struct Looks {
    std::vector<double> plain, filtered;
    double sum_change = 0;  ///< relative, of the irradiance, by the prefilter
};

Looks looks(const std::string& toml, const PictureFrame& frame, int texels, std::int64_t mesh) {
    Baked baked = bakeText(toml, "beams", option("mesh", mesh));
    LightVolume volume{std::move(baked.result.volume.field)};
    Looks out;
    out.plain = looked(volume, frame, texels);
    const double sum = volume.field.sum(0);
    prefilterForTrilinear(volume.field);
    out.sum_change = volume.field.sum(0) / sum - 1;
    out.filtered = looked(volume, frame, texels);
    return out;
}

PictureFrame floorFrame(double half) {
    PictureFrame frame;
    frame.origin = {-half, -half, truth::pool3::kFloor};
    frame.across = {2 * half, 0, 0}, frame.up = {0, 2 * half, 0};
    return frame;
}

const char* const kFloorPlane =
    "[[object]]\nname = \"floor\"\nplane = { point = [0, 0, -1.5], normal = [0, 0, 1] }\nrole = \"receiver\"\n";

/// The pool's floor `part` of a voxel above one's lower side: layers are aligned to z = 0.
SceneText pool(double cell, double part, const std::string& where) {
    SceneText text;
    text.voxel_size = cell;
    text.half = {1.0625, 1.0625};
    text.layer_height = 1.5 / (std::round(1.5 / cell) + part);
    text.z_min = truth::pool3::kFloor - 4 * cell, text.z_max = 0.08;
    text.objects = kFloorPlane, text.bake = where;
    return text;
}

const double kParts[] = {0.05, 0.25, 0.45, 0.65, 0.85};
const char* const kWhere[] = {"", "where = \"receivers\"\nband = 2\n", "where = \"receivers\"\nband = 4\n"};

/// Even light on a floor is looked up as what it is.
TEST(Prefilter, EvenLightIsLookedUpEvenWhereverTheFloorLies) {
    for (const char* where : kWhere)
        for (const double part : kParts) {
            std::string toml = truth::pool3::sceneToml(pool(2.0 / 32, part, where));
            const std::size_t from = toml.find("waves = ["), to = toml.find("]\n[[object]]");
            ASSERT_NE(to, std::string::npos);
            toml.replace(from, to + 2 - from, "flat = true\n");
            const Looks all = looks(toml, floorFrame(0.5), 16, 64);
            const glm::dvec3 sun = truth::pool3::sun();
            const double expected = truth::PlaneWater{1, -sun.z, 1, truth::pool3::kIor, 0}.horizontal(1.5);
            for (const double e : all.filtered) ASSERT_NEAR(e / expected, 1, 1e-4) << where << part;
            EXPECT_NEAR(all.sum_change, 0, 1e-6);
        }
}

/// Under the pool's waves, with and without the sun's disc: nearer to the exact map than without the prefilter.
TEST(Prefilter, IsNeverWorseThanNoneOnThePoolsFloor) {
    for (const double disc : {0.0, 0.53}) {
        const std::vector<double> exact =
            disc > 0 ? truth::pool3::exactDiscFloor().values : truth::pool3::exactFloor().values;
        for (const char* where : kWhere)
            for (const double cell : {2.0 / 64, 2.0 / 128}) {
                double plain = 0, filtered = 0, sums = 0;
                for (const double part : kParts) {
                    SceneText text = pool(cell, part, where);
                    text.angular_diameter_deg = disc;
                    const Looks all = looks(truth::pool3::sceneToml(text), floorFrame(1), 512, 512);
                    const double without = truth::relativeL1(all.plain, exact),
                                 with = truth::relativeL1(all.filtered, exact);
                    EXPECT_LE(with, without) << disc << ' ' << where << ' ' << cell << ' ' << part;
                    EXPECT_LE(truth::relativeRmse(all.filtered, exact), truth::relativeRmse(all.plain, exact));
                    EXPECT_NEAR(all.sum_change, 0, 1e-6);
                    plain = std::max(plain, without), filtered = std::max(filtered, with);
                    sums = std::max(sums, std::fabs(all.sum_change));
                }
                fmt::print(
                    "  disc {}, cells of {:.4f} m, {}: worst relative L1 {:.4f} plain, {:.4f} prefiltered; sums "
                    "{:.1e}\n",
                    disc, cell, *where ? std::string(where).substr(19, 8) : "everywhere", plain, filtered, sums);
            }
    }
}

/// A floor of two triangles that leans: light ends behind it in stairs. The truth is a bake eight times as fine.
TEST(Prefilter, IsNeverWorseThanNoneOnASlope) {
    const std::string path = testing::TempDir() + "prefilter_slope.obj";
    const double rise = std::tan(15 * std::numbers::pi / 180);
    std::ofstream(path) << fmt::format(
        "v -2 -2 {0:.12f}\nv 2 -2 {1:.12f}\nv 2 2 {1:.12f}\nv -2 2 {0:.12f}\nf 1 2 3\nf 1 3 4\n", -1 - 2 * rise,
        -1 + 2 * rise);
    PictureFrame frame;
    frame.origin = {-0.7, -0.7, -1 - 0.7 * rise}, frame.across = {1.4, 0, 1.4 * rise}, frame.up = {0, 1.4, 0};
    frame.normal = glm::normalize(glm::cross(frame.across, frame.up));
    const auto text = [&](double cell, double part) {
        SceneText scene = pool(cell, part, "where = \"receivers\"\n");
        scene.half = {0.8, 0.8}, scene.z_min = -1.4;
        scene.objects = "[[object]]\nname = \"slope\"\nrole = \"receiver\"\nsmooth = false\nfile = \"" + path + "\"\n";
        return truth::pool3::sceneToml(scene);
    };
    const std::vector<double> fine = looks(text(1.0 / 256, 0), frame, 128, 2048).plain;
    for (const double cell : {1.0 / 20, 1.0 / 40})
        for (const double part : kParts) {
            const Looks all = looks(text(cell, part), frame, 128, 512);
            const double without = truth::relativeL1(all.plain, fine), with = truth::relativeL1(all.filtered, fine);
            fmt::print("  slope, cells of {:.4f} m: relative L1 {:.4f} plain, {:.4f} prefiltered, sums {:.1e}\n", cell,
                       without, with, all.sum_change);
            EXPECT_LE(with, without) << cell << ' ' << part;
            EXPECT_NEAR(all.sum_change, 0, 1e-6);
        }
}

}  // namespace
}  // namespace photic
