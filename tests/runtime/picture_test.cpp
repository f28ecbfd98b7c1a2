// SPDX-License-Identifier: Apache-2.0
// Bake, load, draw: the runtime shows receivers as `photic picture` does.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bake/picture/receiver_picture.h"
#include "photic/runtime_vdb.h"
#include "tests/runtime/baked_scene.h"
#include "tests/runtime/gpu_fixture.h"
#include "tests/runtime/scene_view.h"

namespace photic {
namespace {

using test::asGameVolume;
using test::bake;
using test::BakedScene;
using test::poolText;
using test::throughVdb;

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
