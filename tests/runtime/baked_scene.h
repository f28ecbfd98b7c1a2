// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bake/file/nvdb.h"
#include "bake/scene/scene.h"
#include "photic/runtime.h"

namespace photic::test {

/// A pool of a cubic metre, with a floor and an east wall, and a sun with a disc.
/// @param sun     TOML: irradiance, a number or three
/// @param medium  TOML: more tables
/// @param voxel   [m]
std::string poolText(const std::string& sun, const std::string& medium, double voxel = 0.03125);

struct BakedScene {
    Scene scene;
    LightVolume volume;
};

BakedScene bake(const std::string& text);

/// The bake as a game gets it: written as .nvdb and loaded.
/// @throws std::runtime_error when it does not load
runtime::Volume asGameVolume(const LightVolume& volume, NvdbPrecision precision);
/// A pool under a sun and another one from the north, where some of the first one's light goes: two lobes.
runtime::Volume opposedSuns();
/// Written as .vdb and loaded.
runtime::Volume throughVdb(const LightVolume& volume);

}  // namespace photic::test
