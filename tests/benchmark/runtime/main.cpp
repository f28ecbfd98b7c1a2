// SPDX-License-Identifier: Apache-2.0
// photic_runtime_benchmark [--quick] [SECTION]: the runtime's times on the GPU at hand, in one run. See README.md.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>

#include "bake/baker/game_budget.h"
#include "bake/file/compressed_light.h"
#include "tests/benchmark/runtime/rows.h"
#include "tests/runtime/baked_scene.h"
#include "tests/support/gl_context.h"

namespace {

using namespace photic;
using namespace photic::benchmark;

/// The pool with its smoothest blocks in voxels twice as wide, in three quarters of the memory.
runtime::Volume twoLevels(const LightVolume& pool, const runtime::Volume& whole) {
    Monitor monitor;
    ExportPlan plan;
    plan.two_levels_in = static_cast<std::int64_t>(whole.bytes()) * 3 / 4;
    return test::asGameVolume(planned(pool, plan, nullptr, monitor), NvdbPrecision::Half);
}

/// The pool in blocks that GPUs decode by themselves.
runtime::Volume inBlocks(const LightVolume& pool) {
    Monitor monitor;
    ExportPlan plan;
    plan.texels = GameTexels::Bc6h;
    LightVolume blocks = planned(pool, plan, nullptr, monitor);
    compressLight(blocks, monitor);
    return test::asGameVolume(blocks, NvdbPrecision::Half);
}

/// @param only  a section's name; empty: all
int run(const RuntimeEffort& effort, const std::string& only) {
    std::string reason;
    const auto headless = test::HeadlessGl::make(reason);
    if (!headless) {
        fmt::print("no GL, nothing to measure: {}\n", reason);
        return 0;
    }
    const auto context = runtime::GpuContext::create(headless->loader());
    if (!context) throw std::runtime_error(context.error().message);
    const test::BakedScene pool = test::bake(test::poolText("1000.0", "", effort.voxel));
    test::Eye eye;
    eye.position = {-1.0, -1.4, 0.9};
    eye.target = {0, 0, -0.6};
    eye.width = effort.width;
    eye.height = effort.height;
    const test::Trace walls = test::planes({{{0, 0, -1}, {0, 0, 1}}, {{0.48, 0, 0}, {-1, 0, 0}}});
    test::DrawnView view(context->gl(), eye, walls);
    eye.width = eye.height = std::min(512, effort.height);
    test::DrawnView square(context->gl(), eye, walls);
    runtime::Volume volume = test::asGameVolume(pool.volume, NvdbPrecision::Half);
    runtime::Volume two_levels = twoLevels(pool.volume, volume);
    const RuntimeStage stage{*context, effort, std::move(volume), std::move(two_levels), inBlocks(pool.volume),
                             view,     square};

    fmt::print("{} (OpenGL {}.{})\n\n", context->renderer(), context->gl().major, context->gl().minor);
    const auto wanted = [&](const char* section) { return only.empty() || only == section; };
    if (wanted("sides")) fmt::print("{}\n", markdown(sideBySide(stage)));
    if (wanted("look-ups")) fmt::print("{}\n", markdown(lookUps(stage)));
    if (wanted("passes")) {
        Table passes;
        passes.title = "Passes";
        passes.note =
            fmt::format("ms for {} x {} pixels, least of {} runs.", effort.width, effort.height, effort.repeats);
        passes.head = {"pass", "ms"};
        addVolumePasses(stage, passes);
        addWaterPasses(stage, passes);
        fmt::print("{}\n", markdown(passes));
    }
    if (wanted("live")) fmt::print("{}\n", markdown(liveBakes(stage)));
    if (wanted("uploads")) fmt::print("{}\n", markdown(uploads(stage)));
    if (wanted("floor")) fmt::print("{}", markdown(floorAccuracy(stage)));
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    RuntimeEffort effort;
    std::string only;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--quick") {
            effort = {1.0 / 32, 20000, 96, 54, 1};
        } else if (word == "sides" || word == "look-ups" || word == "passes" || word == "live" || word == "uploads" ||
                   word == "floor") {
            only = word;
        } else {
            std::fputs("usage: photic_runtime_benchmark [--quick] [sides|look-ups|passes|live|uploads|floor]\n",
                       stderr);
            return 2;
        }
    }
    try {
        return run(effort, only);
    } catch (const std::exception& e) {
        fmt::print(stderr, "photic_runtime_benchmark: {}\n", e.what());
        return 1;
    }
}
