// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/bake_cost.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "bake/baker/machine_speed.h"
#include "bake/methods/lobe_axis.h"
#include "bake/methods/plane_light.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {

namespace {

// The program itself, its libraries and threads [bytes].
constexpr double kProgramBytes = 6e7;
// What any bake takes for its scene, its threads and its files, and to measure the least that is measured [s].
constexpr double kSceneSeconds = 0.1, kTwoStripsSeconds = 0.1;
// On one thread, measured on a 2.6 GHz server core.
constexpr double kSecondsAPrefilteredVoxel = 2.1e-8, kSecondsADensityVoxel = 4e-8, kSecondsAWrittenValue = 1.4e-8;

/// Whole bytes of an estimate, which may exceed what an integer holds.
std::int64_t wholeBytes(double bytes) { return static_cast<std::int64_t>(std::min(bytes, 8e18)); }

/// Leaves of a box, at most.
double tableOf(const GridFrame& frame) {
    const glm::dvec3 leaves = (glm::dvec3(frame.size()) + 7.0) / 8.0 + 1.0;
    return leaves.x * leaves.y * leaves.z;
}

/// [bytes]: peak of the method, the field, its table, and the grids while they are written.
std::int64_t memoryOf(const Scene& scene, double table, double leaves, double method_bytes) {
    const GridSet& grids = scene.bake.grids;
    const int channels = (scene.coloured() ? 3 : 1) + (grids.direction ? 3 : 0);
    const int scalars = int(grids.caustic) + int(grids.density) + int(grids.arrival_time);
    // A leaf's place in the tables of the field and of the file takes about 250 bytes.
    const bool two_lobes = scene.bake.lobes > 1 && grids.direction && lightCanOppose(scene);
    const double field = leaves * 512 * 4 * (channels * (two_lobes ? 2 : 1) + scalars);
    // Lights whose blurs differ are baked beside one another, and a blur keeps a copy of a layer of leaves.
    const double beside = (scene.lights.size() > 1 ? 1 : 0.25) * field;
    return wholeBytes(kProgramBytes + field + table * 4 + leaves * 250 + std::max(method_bytes, beside));
}

}  // namespace

double BakeCost::seconds() const {
    double sum = 0;
    for (const Stage& stage : stages) sum += stage.seconds;
    return sum;
}

BakeCost bakeCost(const Scene& scene, const Method& method, const GridFrame& frame, const NeededVoxels* needed,
                  const BakeChoices& choices) {
    if (needed)
        return bakeCost(scene, method, frame,
                        NeededCount{static_cast<double>(needed->count()), static_cast<double>(needed->leafCount())},
                        choices);
    return bakeCost(scene, method, frame, NeededCount{static_cast<double>(frame.voxelCount()), tableOf(frame)},
                    choices);
}

BakeCost bakeCost(const Scene& scene, const Method& method, const GridFrame& frame, const NeededCount& needed,
                  const BakeChoices& choices) {
    const double table = tableOf(frame), voxels = needed.voxels, leaves = needed.leaves;
    const GridSet& grids = scene.bake.grids;
    const int channels = (scene.coloured() ? 3 : 1) + (grids.direction ? 3 : 0);
    const int scalars = int(grids.caustic) + int(grids.density) + int(grids.arrival_time);
    const double values = voxels * (channels + scalars);
    MethodCost own = method.cost({scene, frame, voxels, givenOptions(scene, method)});

    BakeCost cost;
    cost.needed_voxels = static_cast<std::int64_t>(voxels), cost.leaves = wholeBytes(leaves);
    cost.file_bytes = wholeBytes(values * (choices.file.half ? 2 : 4));
    cost.memory_bytes = memoryOf(scene, table, leaves, own.bytes);
    cost.dearest = std::move(own.dearest);

    const double threads = threadCount();
    cost.stages = {{"scene", kSceneSeconds}, {"needed", voxels * 1e-9}};
    for (const Stage& stage : own.stages) {
        cost.bake_seconds += stage.seconds;
        cost.stages.push_back({stage.name, stage.seconds / threads});
    }
    if (scene.bake.prefilter)
        cost.stages.push_back({"prefilter", voxels * channels / 4 * kSecondsAPrefilteredVoxel / threads});
    if (grids.density) cost.stages.push_back({"density", voxels * kSecondsADensityVoxel / threads});
    if (choices.measure != Measure::Nothing) {
        double all = 0;
        for (const Stage& stage : cost.stages) all += stage.seconds;
        const bool measures = grids.irradiance && grids.direction && planeLightRefusal(scene).empty();
        cost.stages.push_back({"measure", measures ? kTwoStripsSeconds + 0.2 * all : 0});
    }
    // The grids are built and packed on one thread.
    cost.stages.push_back({"write", values * kSecondsAWrittenValue});
    for (Stage& stage : cost.stages) stage.seconds *= machineSlowness();
    return cost;
}

std::int64_t mostMemory(const Scene& scene, const Method& method, const GridFrame& frame) {
    const double leaves = tableOf(frame);
    const MethodCost own = method.cost(
        {scene, frame, static_cast<double>(frame.voxelCount()), givenOptions(scene, method), CostAsked::MostBytes});
    return memoryOf(scene, leaves, leaves, own.bytes);
}

std::string wordsOf(const BakeCost& cost, double slower) {
    const auto number = [](double v) { return v < 10 ? fmt::format("{:.2g}", v) : fmt::format("{:.0f}", v); };
    return fmt::format("about {} MB and {} s", number(static_cast<double>(cost.file_bytes) * 1e-6),
                       number(slower * cost.seconds()));
}

std::int64_t machineMemory() {
    std::int64_t bytes = static_cast<std::int64_t>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGE_SIZE);
    std::int64_t limit = 0;
    std::ifstream container("/sys/fs/cgroup/memory.max");  // "max" when there is no limit
    if (container >> limit && limit > 0) bytes = std::min(bytes, limit);
    return bytes;
}

std::int64_t memoryLimit(const BakeChoices& choices) {
    return choices.max_memory_bytes > 0 ? choices.max_memory_bytes : machineMemory();
}

void checkMemory(const BakeCost& cost, const BakeChoices& choices) {
    const std::int64_t limit = memoryLimit(choices);
    if (cost.memory_bytes <= limit) return;
    throw Error(
        ErrorCode::Failed,
        fmt::format(
            "the bake would take about {:.3g} GB for {:.4g} voxels, more than the {} of {:.3g} GB; use a larger "
            "voxel_size, where = \"receivers\" or fewer grids",
            static_cast<double>(cost.memory_bytes) * 1e-9, static_cast<double>(cost.needed_voxels),
            choices.max_memory_bytes > 0 ? "--max-memory" : "machine's memory", static_cast<double>(limit) * 1e-9));
}

}  // namespace photic
