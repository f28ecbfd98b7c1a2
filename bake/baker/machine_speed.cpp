// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/machine_speed.h"

#include <algorithm>
#include <ctime>
#include <limits>

#include "bake/field/scene_grid.h"
#include "bake/methods/catalogue.h"
#include "bake/report/monitor.h"
#include "bake/scene/load_toml.h"

namespace photic {
namespace {

// Of the small bake, on the core that estimates are made for.
constexpr double kReferenceSeconds = 0.026;

// Tracing, shadows and sums in about the shares that they have of a larger bake.
constexpr const char* kScene = R"(photic = 1
[domain]
min = [-0.5, -0.5, -0.75]
max = [0.5, 0.5, 0.125]
voxel_size = 0.05
[[light]]
type = "sun"
direction = [0.2, 0.1, -0.9]
irradiance = 1000.0
[[surface]]
name = "water"
size = [2.0, 2.0]
waves = [
    { amplitude = 0.01, wavelength = 0.5, direction = 20.0 },
    { amplitude = 0.006, wavelength = 0.3, direction = 110.0 },
]
[[object]]
name = "step"
box = { min = [-0.2, -0.3, -0.8], max = [0.3, 0.2, -0.5] }
)";

double processorSeconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double measuredSlowness() {
    constexpr int kTimes = 2;  // the first is that of a cold machine
    Monitor quiet;
    const Scene scene = parseScene(kScene, "the machine's speed", ".", 0, quiet);
    const Method& method = chooseMethod(scene.bake.method, scene);
    const auto needed = std::make_shared<const NeededVoxels>(NeededVoxels::everything(sceneFrame(scene)));
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kTimes; ++i) {
        const double start = processorSeconds();
        method.bake(scene, needed, {}, quiet);
        least = std::min(least, processorSeconds() - start);
    }
    return least / kReferenceSeconds;
}

}  // namespace

double machineSlowness() {
    static const double slowness = measuredSlowness();
    return slowness;
}

}  // namespace photic
