// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bake/baker/bake_scene.h"
#include "tests/support/pool3.h"

namespace photic::benchmark {

/// How long and how fine to measure.
struct Effort {
    bool quick = false;
    double least_seconds = 0.5;
    int least_runs = 3;
};

/// One bake, ready to be repeated.
struct Case {
    Scene scene;
    std::string method = "beams";
    GivenOptions options;
};

Case poolCase(const truth::pool3::SceneText& text, const std::string& method, const GivenOptions& options);
GivenOptions option(const std::string& name, OptionValue value);
GivenOptions operator|(GivenOptions a, const GivenOptions& b);

/// The pool in a box of 2 m: n^3 cubic voxels, all of the water and a little air.
truth::pool3::SceneText poolBox(int n);
/// The same with `layers` over that height, leaning along the refracted sun.
truth::pool3::SceneText shearedPoolBox(int n, int layers);
/// One layer of n x n voxels at the floor.
truth::pool3::SceneText poolFloor(int n);

struct Timed {
    double seconds = 0;  ///< best run: needed voxels, set-up, trace, deposit, checks; nothing is written
    int runs = 0;
    BakedScene result;  ///< of the last run
};
/// Repeats after a warm-up until `effort` is satisfied. One run when it takes longer than ten seconds.
Timed measure(const Case& c, const Effort& effort);
/// One run, no warm-up.
Timed once(const Case& c);

/// Relative errors of the irradiance over the voxels of two fields on one frame.
struct FieldError {
    double l1 = 0, rmse = 0;
};
FieldError fieldError(const LightField& field, const LightField& reference);

/// -F_z of the single layer of a poolFloor(512), in the order of truth::FloorMap.
std::vector<double> floorValues(const LightField& field);

}  // namespace photic::benchmark
