// SPDX-License-Identifier: Apache-2.0
// Waves through an index that varies, against rays in closed form.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bake/methods/wave.h"
#include "bake/optics/snell.h"
#include "bake/report/error.h"
#include "bake/scene/index_volume.h"
#include "tests/methods/photon_scenes.h"

namespace photic {
namespace {

using test_scenes::boxFrame;
using test_scenes::CosineField;
using test_scenes::waterScene;

constexpr int kCells = 64;  // a metre

BakeResult bake(Scene scene, const WaveOptions& options = {}, WaveRun* run = nullptr) {
    scene.bake.grids = {true, true, false, false, false};
    Monitor monitor;
    const GridFrame frame = boxFrame({-0.5, 0, -0.9375}, {kCells, 8, kCells}, glm::dvec3(1.0 / kCells));
    return bakeWave(scene, std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame)), options, monitor,
                    run);
}

/// An index on 401 samples of a centimetre along an axis, about `middle`.
template <class Index>
std::shared_ptr<const IndexVolume> along(int axis, double middle, const Index& index) {
    IndexVolume::Samples samples;
    samples.size = glm::ivec3(1);
    samples.size[axis] = 401;
    samples.world_from_index[axis][axis] = 0.01;
    samples.origin_world[axis] = middle - 2;
    for (int i = 0; i < 401; ++i) samples.values.push_back(static_cast<float>(index(middle - 2 + 0.01 * i)));
    return std::make_shared<IndexVolume>(std::move(samples), 1.333);
}

struct Errors {
    double light = 0, signed_light = 0, angle = 0;  ///< relative L1; mean; mean [degrees]
};
/// Of voxels below two cells under flat water; truth(place, irradiance, direction).
template <class Truth>
Errors errorsOf(const BakeResult& result, const Truth& truth) {
    Errors e;
    double sum = 0;
    int count = 0;
    const GridFrame& f = result.field.frame();
    for (int x = f.min.x; x <= f.max.x; ++x)
        for (int z = f.min.z; z <= f.max.z - 6; ++z) {
            const glm::ivec3 v(x, 3, z);
            double irradiance = 0;
            glm::dvec3 direction(0);
            truth(f.worldFromIndex(glm::dvec3(v)), irradiance, direction);
            const double value = result.field.irradiance(v);
            e.light += std::fabs(value - irradiance), e.signed_light += value - irradiance, sum += irradiance;
            e.angle += std::acos(std::min(1.0, glm::dot(glm::normalize(result.field.flux(v)), direction)));
            ++count;
        }
    return {e.light / sum, e.signed_light / sum, e.angle / count * 180 / std::numbers::pi};
}

/// n^2 grows linearly downwards under a slanting sun: n sin t stays, and so does the power that a layer passes on.
TEST(WaveIndex, StratifiedWaterFollowsSnellInItsLayers) {
    constexpr double first = 1.77, growth = 1.5;
    const auto n2 = [&](double z) { return first - growth * std::min(z, 0.1); };
    Scene scene = waterScene(0.9);
    scene.lights[0].direction = {std::sin(0.9), 0, -std::cos(0.9)};
    scene.index = along(2, -1.5, [&](double z) { return std::sqrt(n2(z)); });
    const double squared = std::pow(std::sin(0.9), 2);
    const auto cosine = [&](double z) { return std::sqrt(1 - squared / n2(z)); };
    const double enters = fresnelTransmittance(std::cos(0.9), cosine(0), 1, std::sqrt(first)) * std::cos(0.9);
    for (const double extinction : {0.0, 1.0}) {
        scene.medium.absorption = glm::dvec3(extinction);
        const auto truth = [&](const glm::dvec3& p, double& irradiance, glm::dvec3& direction) {
            double path = 0;
            for (int i = 0; i < 64; ++i) path += -p.z / 64 / cosine(p.z * (i + 0.5) / 64);
            irradiance = enters / cosine(p.z) * std::exp(-extinction * path);
            direction = {std::sqrt(squared / n2(p.z)), 0, -cosine(p.z)};
        };
        WaveRun run;
        const BakeResult result = bake(scene, {}, &run);
        const Errors e = errorsOf(result, truth);
        fmt::print(
            "  stratified, extinction {}: relative L1 {:.4f}, mean {:.4f}, direction {:.2f} degrees, {:.1f} "
            "bytes a cell\n",
            extinction, e.light, e.signed_light, e.angle,
            double(run.counts.peak_bytes) / double(run.counts.peak_blocks * 512));
        EXPECT_LT(e.light, 0.015) << extinction;
        EXPECT_LT(e.angle, 0.5) << extinction;
        // The surface's own index all the way down is far off.
        Scene constant = scene;
        constant.index = nullptr, constant.surfaces[0].ior_below = std::sqrt(first);
        const Errors without = errorsOf(bake(constant), truth);
        fmt::print("    with the surface's index: {:.4f}, {:.2f} degrees\n", without.light, without.angle);
        EXPECT_GT(without.angle, 4);
        if (extinction == 0) {
            EXPECT_GT(without.light, 0.04);
        }
    }
}

/// SELFOC glass, n^2 = n0^2 (1 - g^2 x^2), under light that falls straight in: rays swing to the axis.
TEST(WaveIndex, AcrossTheLightItFocusesAsSelfocDoes) {
    constexpr double n0 = 1.5, g = 0.6;
    const auto index = [&](double x) { return n0 * std::sqrt(std::max(0.6, 1 - g * g * x * x)); };
    Scene scene = waterScene(0);
    scene.lights[0].direction = {0, 0, -1};
    scene.index = along(0, 0, index);
    const auto place = [&](double x0, double z) { return x0 * std::cos(n0 * g * -z / index(x0)); };
    const auto truth = [&](const glm::dvec3& p, double& irradiance, glm::dvec3& direction) {
        double x0 = p.x;
        for (int i = 0; i < 60; ++i) x0 += p.x - place(x0, p.z);
        const double step = 1e-5, spread = (place(x0 + step, p.z) - place(x0 - step, p.z)) / (2 * step),
                     run = (place(x0, p.z + step) - place(x0, p.z - step)) / (2 * step);
        direction = glm::normalize(glm::dvec3(-run, 0, -1));
        irradiance = fresnelTransmittance(1, 1, 1, index(x0)) / (spread * -direction.z);
    };
    const Errors e = errorsOf(bake(scene), truth);
    fmt::print("  SELFOC: relative L1 {:.4f}, mean {:.4f}, direction {:.2f} degrees\n", e.light, e.signed_light,
               e.angle);
    EXPECT_LT(e.light, 0.015);
    EXPECT_LT(e.angle, 0.5);
    scene.index = nullptr, scene.surfaces[0].ior_below = n0;
    const Errors without = errorsOf(bake(scene), truth);
    fmt::print("    with the axis' index: {:.4f}, {:.2f} degrees\n", without.light, without.angle);
    EXPECT_GT(without.light, 0.05);
    EXPECT_GT(without.angle, 2);
}

/// An index that is constant after all gives what the waves give without a volume, waves in the surface included.
TEST(WaveIndex, AConstantVolumeChangesNothing) {
    Scene scene = waterScene(0.4, std::make_shared<CosineField>(0.03, 6));
    scene.medium.absorption = glm::dvec3(0.5);
    const BakeResult without = bake(scene);
    scene.surfaces[0].ior_below = 1.2;  // the volume has the word
    scene.index = std::make_shared<IndexVolume>(layeredIndex({{0, 1.333}}));
    const BakeResult with = bake(scene);
    double off = 0, sum = 0;
    const GridFrame& f = with.field.frame();
    for (int x = f.min.x; x <= f.max.x; ++x)
        for (int z = f.min.z; z <= f.max.z; ++z) {
            const glm::ivec3 v(x, 3, z);
            off += std::fabs(with.field.irradiance(v) - without.field.irradiance(v)),
                sum += without.field.irradiance(v);
        }
    EXPECT_LT(off / sum, 1e-4);
}

TEST(WaveIndex, SaysWhatDoesNotGoTogether) {
    Scene scene = waterScene(0.3);
    scene.index = std::make_shared<IndexVolume>(layeredIndex({{0, 1.333}, {-1, 1.4}}));
    EXPECT_EQ(waveMethod().refusal(scene), "");
    WaveOptions options;
    options.preset = WavePreset::Mercier;
    EXPECT_THROW(bake(scene, options), Error);
    options = {}, options.absorber = WaveAbsorber::Sponge;
    EXPECT_THROW(bake(scene, options), Error);
    scene.index = std::make_shared<IndexVolume>(layeredIndex({{0, 1.2}, {-1, 0.9}}));
    EXPECT_NE(waveMethod().refusal(scene).find("0.9"), std::string::npos);
}

}  // namespace
}  // namespace photic
