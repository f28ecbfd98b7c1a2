// SPDX-License-Identifier: Apache-2.0
// Bake, load, draw: the runtime shows receivers as `photic picture` does.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>

#include "bake/field/scene_grid.h"
#include "bake/methods/catalogue.h"
#include "bake/picture/receiver_picture.h"
#include "bake/picture/volume_lookup.h"
#include "bake/scene/load_toml.h"
#include "tests/runtime/gpu_fixture.h"
#include "tests/runtime/scene_view.h"

namespace photic {
namespace {

/// The pool of examples/, smaller and coarser: two receivers, a sun with a disc.
std::string poolText(const std::string& sun, const std::string& medium) {
    return R"(photic = 1
[domain]
min = [-0.5, -0.5, -1.1]
max = [0.55, 0.5, 0.1]
voxel_size = 0.03125
[[light]]
type = "sun"
direction = [0.433, 0.25, -0.866]
angular_diameter = 0.53
irradiance = )" +
           sun +
           R"(
[[surface]]
name = "water"
kind = "height_field"
size = [3.0, 3.0]
waves = [{ amplitude = 0.02, wavelength = 0.6, direction = 20.0, phase = 0.4 },
         { amplitude = 0.012, wavelength = 0.4, direction = 100.0, phase = 1.7 }]
[[object]]
name = "floor"
plane = { point = [0, 0, -1.0], normal = [0, 0, 1] }
[[object]]
name = "east"
plane = { point = [0.48, 0, 0], normal = [-1, 0, 0] }
)" + medium;
}

struct BakedScene {
    Scene scene;
    LightVolume volume;
};

BakedScene bake(const std::string& text) {
    const auto path =
        std::filesystem::temp_directory_path() / ("photic_runtime_" + std::to_string(::getpid()) + ".toml");
    std::ofstream(path) << text;
    Monitor monitor;
    Scene scene = loadScene(path.string(), 1, monitor);
    std::filesystem::remove(path);
    const auto needed = std::make_shared<const NeededVoxels>(sceneNeededVoxels(scene, sceneFrame(scene), monitor));
    BakeResult result = chooseMethod("auto", scene).bake(scene, needed, {}, monitor);
    return {std::move(scene), LightVolume{std::move(result.field), 1000.0, true, true, {}, {}}};
}

/// The bake as a game gets it: a .nvdb.
runtime::Volume asGameVolume(const LightVolume& volume) {
    const VolumeLookup lookup(volume);
    const GridFrame& frame = volume.field.frame();
    test::NvdbSpec spec;
    for (int a = 0; a < 3; ++a) {
        const auto axis = static_cast<std::size_t>(a);
        spec.min[axis] = frame.min[a];
        spec.max[axis] = frame.max[a];
        spec.origin_world[axis] = frame.origin_world[a];
        for (int b = 0; b < 3; ++b)
            spec.world_from_index[3 * axis + static_cast<std::size_t>(b)] = frame.world_from_index[b][a];
    }
    spec.coloured = lookup.coloured();
    spec.json = R"({"version": 1, "reference_irradiance": 1000})";
    spec.active = [&](int i, int j, int k) { return lookup.voxel({i, j, k}).meanIrradiance() > 0; };
    spec.values = [&](int i, int j, int k) -> test::LightValues {
        const LightSample s = lookup.voxel({i, j, k});
        const double scale = 1.0 / volume.reference_irradiance;
        return {float(s.flux.x * scale),           float(s.flux.y * scale),       float(s.flux.z * scale),
                float(s.meanIrradiance() * scale), float(s.irradiance.x * scale), float(s.irradiance.y * scale),
                float(s.irradiance.z * scale)};
    };
    return test::makeVolume(spec);
}

/// A G-buffer that is the receiver's rectangle, pixel by pixel.
test::Drawing flatDrawing(const PictureFrame& frame) {
    test::Drawing out(frame.width, frame.height);
    std::fill(out.depth.begin(), out.depth.end(), 0.5F);
    for (std::size_t n = 0; n < out.depth.size(); ++n) {
        for (int c = 0; c < 3; ++c)
            out.normals[4 * n + static_cast<std::size_t>(c)] = static_cast<float>(frame.normal[c]);
    }
    out.world_from_clip[0] = glm::dvec4(frame.across / 2.0, 0);
    out.world_from_clip[1] = glm::dvec4(frame.up / 2.0, 0);
    out.world_from_clip[2] = glm::dvec4(frame.normal, 0);
    out.world_from_clip[3] = glm::dvec4(frame.origin + frame.across / 2.0 + frame.up / 2.0, 1);
    return out;
}

using RuntimePictures = test::WithGpu;

TEST_F(RuntimePictures, ReceiversAreThoseOfPhoticPicture) {
    const std::string clear = "\n", tinted = "[medium]\nabsorption = [0.35, 0.07, 0.02]\n";
    for (const auto& text : {poolText("1000.0", clear), poolText("[1000.0, 900.0, 700.0]", tinted)}) {
        const BakedScene baked = bake(text);
        const runtime::Volume volume = asGameVolume(baked.volume);
        runtime::GpuVolume gpu = upload(volume, {});
        auto pass = runtime::ReceiverPass::create(*gpu_);
        ASSERT_TRUE(pass.ok()) << pass.error().message;
        for (const char* name : {"floor", "east"}) {
            const PictureFrame frame = receiverFrame(baked.scene, name, 200);
            const Image picture = receiverPicture(baked.volume, frame);
            const test::DrawnView view(gl_, flatDrawing(frame));
            runtime::ReceiverOptions options;
            options.output = runtime::ReceiverOutput::Irradiance;
            const auto drawn = pass->draw(view.surfaces, view.target, {{&gpu}}, options);
            ASSERT_TRUE(drawn.ok()) << drawn.error().message;
            const auto pixels = view.pixels();
            double error = 0, size = 0;
            for (int y = 0; y < picture.height; ++y) {
                for (int x = 0; x < picture.width; ++x) {
                    for (int c = 0; c < 3; ++c) {
                        const double t = static_cast<double>(
                            picture.at(x, picture.height - 1 - y, std::min(c, picture.channels - 1)));
                        const auto at = static_cast<std::size_t>(4 * (y * picture.width + x) + c);
                        error += (static_cast<double>(pixels[at]) - t) * (static_cast<double>(pixels[at]) - t);
                        size += t * t;
                    }
                }
            }
            EXPECT_GT(size, 0);
            EXPECT_LT(std::sqrt(error / size), 0.005) << name;
            RecordProperty(std::string("relative_rmse_") + name, std::to_string(std::sqrt(error / size)));
        }
    }
}

}  // namespace
}  // namespace photic
