// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "bake/methods/catalogue.h"
#include "bake/report/monitor.h"
#include "bake/scene/load_toml.h"

namespace photic::test {

/// Keeps what it is told.
class Record final : public Monitor {
public:
    void progress(std::string_view stage, double fraction) override { steps.push_back({std::string(stage), fraction}); }
    void warn(const std::string& message) override { warnings.push_back(message); }

    struct Step {
        std::string stage;
        double fraction;
    };
    std::vector<Step> steps;
    std::vector<std::string> warnings;
};

/// A small pool with a floor, waves of half a metre, and a sun without a disc.
/// @param more  further tables
inline Scene poolScene(const std::string& more = {}, double voxel = 1.0 / 16) {
    Monitor monitor;
    return parseScene(R"(photic = 1
[domain]
min = [-0.5, -0.5, -0.75]
max = [0.5, 0.5, 0.125]
voxel_size = )" + std::to_string(voxel) +
                          R"(
[[light]]
type = "sun"
direction = [0.2, 0.1, -0.9]
irradiance = 1000.0
angular_diameter = 0
[[surface]]
name = "water"
kind = "height_field"
size = [2.0, 2.0]
waves = [{ amplitude = 0.01, wavelength = 0.5, direction = 20, phase = 0.4 }]
[[object]]
name = "floor"
plane = { point = [0, 0, -0.5], normal = [0, 0, 1] }
)" + more,
                      "pool.toml", ".", 0, monitor);
}

/// A lens without faces under the same sun.
inline Scene lensScene(double voxel = 1.0 / 16) {
    Monitor monitor;
    return parseScene(R"(photic = 1
[domain]
min = [-0.5, -0.5, -0.75]
max = [0.5, 0.5, 0.125]
voxel_size = )" + std::to_string(voxel) +
                          R"(
[[light]]
type = "sun"
direction = [0.2, 0.1, -0.9]
irradiance = 1000.0
angular_diameter = 0
[[medium]]
name = "lens"
index = { kind = "luneburg", center = [0, 0, -0.3], radius = 0.25 }
)",
                      "lens.toml", ".", 0, monitor);
}

/// A scene that a method can bake: the pool, or the lens.
inline Scene sceneFor(const Method& method, const std::string& more = {}, double voxel = 1.0 / 16) {
    Scene scene = poolScene(more, voxel);
    return method.refusal(scene).empty() ? scene : lensScene(voxel);
}

}  // namespace photic::test
