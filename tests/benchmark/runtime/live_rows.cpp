// SPDX-License-Identifier: Apache-2.0
// Bakes each frame on the GPU.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "photic/live_bake.h"
#include "tests/benchmark/runtime/or_throw.h"
#include "tests/benchmark/runtime/rows.h"
#include "tests/runtime/water_model.h"

namespace photic::benchmark {

using namespace runtime;

namespace {

constexpr double kHalf = 1;  // of the water's rectangle, which repeats [m]

/// Waves of a pool at a time [m].
double waves(double x, double y, double turn) {
    return 0.02 * std::sin(3 * M_PI * x + turn) + 0.012 * std::sin(5 * M_PI * y + 1.7 + turn) +
           0.006 * std::sin(7 * M_PI * (x + y) - turn);
}

struct Case {
    int voxels, mesh;
    double disc_deg;
    bool coloured;
};

}  // namespace

Table liveBakes(const RuntimeStage& stage) {
    Table table;
    table.title = "A bake each frame";
    table.note = "ms. Asked: of the processor, until it has asked for the bake. A frame: new heights and a bake.";
    table.head = {"voxels", "mesh", "sun", "MB", "heights sent", "bake", "asked", "a frame", "receivers, then"};
    const bool quick = stage.effort.samples <= 100000;
    const int side = quick ? 16 : 128;
    ReceiverPass receivers = orThrow(ReceiverPass::create(stage.context));
    for (const Case& c :
         {Case{side / 2, side, 0, false}, Case{side, side, 0, false}, Case{side, 2 * side, 0, false},
          Case{side, 2 * side, 0.53, false}, Case{side, 2 * side, 0.53, true}, Case{side, 4 * side, 0.53, false}}) {
        LiveWater water = orThrow(LiveWater::create(stage.context));
        WaterLight light = test::pool3Light();
        if (c.coloured) light.extinction[0] = 0.35F, light.extinction[1] = 0.07F, light.extinction[2] = 0.03F;
        check(water.setLight(light));
        constexpr int kFrames = 4;
        test::SampledWater frames[kFrames];
        for (int n = 0; n < kFrames; ++n) {
            frames[n] = test::sampleWater(
                c.mesh, [&](double x, double y) { return waves(x, y, 0.3 * n); }, kHalf, WaterOutside::Periodic);
        }
        LiveBakeOptions options;
        options.min = {-float(kHalf), -float(kHalf), -1.5F};
        options.max = {float(kHalf), float(kHalf), 0.1F};
        options.voxels = {c.voxels, c.voxels, c.voxels};
        options.angular_diameter_deg = static_cast<float>(c.disc_deg);
        LiveBake bake = orThrow(LiveBake::create(stage.context, options));
        int frame = 0;
        double asked = std::numeric_limits<double>::infinity();
        check(water.setHeights(frames[0].water));
        const double sent = leastMilliseconds(stage, [&] { check(water.setHeights(frames[++frame % kFrames].water)); });
        // Setting the light anew has the water's rays traced anew.
        const double baked = leastMilliseconds(stage, [&] {
            check(water.setLight(light));
            const auto start = std::chrono::steady_clock::now();
            check(bake.update(water));
            asked = std::min(
                asked, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
        });
        const double all = leastMilliseconds(stage, [&] {
            check(water.setHeights(frames[++frame % kFrames].water));
            check(bake.update(water));
        });
        const double shaded = leastMilliseconds(
            stage, [&] { check(receivers.draw(stage.view.surfaces, stage.view.target, {{&bake.volume()}})); });
        table.add({fmt::format("{}^3", c.voxels), fmt::format("{}^2", c.mesh),
                   c.disc_deg > 0 ? fmt::format("{} degrees{}", c.disc_deg, c.coloured ? ", coloured" : "") : "a point",
                   fmt::format("{:.0f}", static_cast<double>(bake.gpuBytes()) / 1e6), fmt::format("{:.2f}", sent),
                   fmt::format("{:.2f}", baked), fmt::format("{:.3f}", asked), fmt::format("{:.2f}", all),
                   fmt::format("{:.2f}", shaded)});
    }
    return table;
}

}  // namespace photic::benchmark
