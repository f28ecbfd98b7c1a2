// SPDX-License-Identifier: Apache-2.0
// photic_runtime_benchmark [--quick]: the runtime's times on the GPU at hand, in one run. See README.md.
#include <fmt/format.h>

#include <cstdio>
#include <cstring>
#include <exception>
#include <stdexcept>

#include "tests/benchmark/runtime/rows.h"
#include "tests/runtime/baked_scene.h"
#include "tests/support/gl_context.h"

namespace {

using namespace photic;
using namespace photic::benchmark;

int run(const RuntimeEffort& effort) {
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
    test::DrawnView view(context->gl(), eye, test::planes({{{0, 0, -1}, {0, 0, 1}}, {{0.48, 0, 0}, {-1, 0, 0}}}));
    const RuntimeStage stage{*context, effort, test::asGameVolume(pool.volume, NvdbPrecision::Half), view};

    fmt::print("{} (OpenGL {}.{})\n\n", context->renderer(), context->gl().major, context->gl().minor);
    fmt::print("{}\n", markdown(sideBySide(stage)));
    fmt::print("{}\n", markdown(lookUps(stage)));
    Table passes;
    passes.title = "Passes";
    passes.note = fmt::format("ms for {} x {} pixels, least of {} runs.", effort.width, effort.height, effort.repeats);
    passes.head = {"pass", "ms"};
    addVolumePasses(stage, passes);
    addWaterPasses(stage, passes);
    fmt::print("{}\n", markdown(passes));
    fmt::print("{}", markdown(floorAccuracy(stage)));
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    RuntimeEffort effort;
    if (argc == 2 && !std::strcmp(argv[1], "--quick")) {
        effort = {1.0 / 32, 20000, 96, 54, 1};
    } else if (argc != 1) {
        std::fputs("usage: photic_runtime_benchmark [--quick]\n", stderr);
        return 2;
    }
    try {
        return run(effort);
    } catch (const std::exception& e) {
        fmt::print(stderr, "photic_runtime_benchmark: {}\n", e.what());
        return 1;
    }
}
