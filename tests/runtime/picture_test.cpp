// SPDX-License-Identifier: Apache-2.0
// Bake, load, draw: the runtime shows receivers as `photic picture` does.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>

#include "bake/field/scene_grid.h"
#include "bake/file/nvdb.h"
#include "bake/methods/catalogue.h"
#include "bake/picture/receiver_picture.h"
#include "bake/scene/load_toml.h"
#include "photic/runtime_vdb.h"
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

/// A temporary file's name, and no file of that name afterwards.
class TemporaryFile {
public:
    explicit TemporaryFile(const std::string& ending)
        : path_((std::filesystem::temp_directory_path() / ("photic_runtime_" + std::to_string(::getpid()) + ending))
                    .string()) {}
    ~TemporaryFile() { std::filesystem::remove(path_); }
    const std::string& path() const { return path_; }

private:
    std::string path_;
};

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

runtime::Volume loaded(runtime::Result<runtime::Volume> volume) {
    if (!volume) {
        ADD_FAILURE() << volume.error().message;
        return {};
    }
    return *volume;
}

/// The bake as a game gets it.
runtime::Volume asGameVolume(const LightVolume& volume, NvdbPrecision precision) {
    const TemporaryFile file(".nvdb");
    NvdbOptions options;
    options.precision = precision;
    writeNvdb(file.path(), volume, options);
    return loaded(runtime::loadVolume(file.path()));
}

runtime::Volume throughVdb(const LightVolume& volume) {
    const TemporaryFile file(".vdb");
    writeVdb(file.path(), volume, {});
    return loaded(runtime::loadVdb(file.path()));
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
        runtime::GpuVolume gpu = upload(asGameVolume(baked.volume, NvdbPrecision::Half), {});
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

TEST_F(RuntimePictures, NvdbAndVdbHoldTheSameLight) {
    const BakedScene baked = bake(poolText("[1000.0, 900.0, 700.0]", "[medium]\nabsorption = [0.35, 0.07, 0.02]\n"));
    const runtime::Volume exact = asGameVolume(baked.volume, NvdbPrecision::Float),
                          half = asGameVolume(baked.volume, NvdbPrecision::Half), vdb = throughVdb(baked.volume);
    ASSERT_TRUE(exact.coloured() && half.coloured() && vdb.coloured());
    EXPECT_EQ(vdb.metadata().reference_irradiance, exact.metadata().reference_irradiance);
    double worst_half = 0, worst_vdb = 0, largest = 0;
    for (const auto& p : test::randomPositions(exact, 20000, 20)) {
        const runtime::Vec3 world = {double(p[0]), double(p[1]), double(p[2])};
        const runtime::Light a = exact.sample(world), b = half.sample(world), c = vdb.sample(world);
        worst_half = std::max({worst_half, std::fabs(a.irradiance.y - b.irradiance.y), std::fabs(a.flux.z - b.flux.z)});
        worst_vdb = std::max({worst_vdb, std::fabs(a.irradiance.y - c.irradiance.y), std::fabs(a.flux.z - c.flux.z)});
        largest = std::max(largest, a.irradiance.y);
    }
    EXPECT_LT(worst_half, 1e-3 * largest);
    EXPECT_LT(worst_vdb, 1e-3 * largest);
    EXPECT_FALSE(runtime::loadVdb("no_such.vdb").ok());
}

}  // namespace
}  // namespace photic
