// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "tests/conformance/bake_scene.h"

namespace photic {

/// How far a bake by beams is from one by photons.
struct Compared {
    double blocks = 0;  ///< relative L1 of means over 4^3 voxels
    double total = 0;   ///< relative difference of all the light
};
/// Bakes a scene by both, with all else left as it is; prints what it finds, and expects closed ledgers and some light.
Compared againstPhotons(const std::string& toml, std::int64_t count = 2'000'000);

/// Expects no more than that.
void expectAlike(const std::string& toml, double blocks = 0.01, double all = 0.003);

double total(const LightField& field);

}  // namespace photic
