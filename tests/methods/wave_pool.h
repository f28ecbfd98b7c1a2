// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <glm/vec3.hpp>
#include <string>

namespace photic {

/// A pool in a box; flat, or with two waves.
struct Pool {
    bool flat = true;
    std::string direction = "[0.3, -0.4, -0.8]";
    double irradiance = 800, absorption = 0;
    glm::dvec3 shift{0};
    std::string extra;
    std::string toml() const {
        return fmt::format(R"(photic = 1
[domain]
min = [{}, {}, {}]
max = [{}, {}, {}]
voxel_size = 0.03125
[[light]]
type = "sun"
direction = {}
irradiance = {}
angular_diameter = 0
[[surface]]
name = "water"
kind = "height_field"
size = [4.0, 4.0]
center = [{}, {}, {}]
outside = "flat"
{}
[medium]
absorption = {}
{}
)",
                           -0.5 + shift.x, -0.5 + shift.y, -0.75 + shift.z, 0.5 + shift.x, 0.5 + shift.y,
                           0.125 + shift.z, direction, irradiance, shift.x, shift.y, shift.z,
                           flat ? "flat = true"
                                : "waves = [{ amplitude = 0.02, wavelength = 0.8, direction = 20, phase = 0.4 },\n"
                                  "         { amplitude = 0.01, wavelength = 0.5, direction = 95, phase = 1.7 }]",
                           absorption, extra);
    }
};

}  // namespace photic
