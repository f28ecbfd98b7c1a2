// SPDX-License-Identifier: Apache-2.0
#include "tests/benchmark/cases.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bake/scene/load_toml.h"

namespace photic::benchmark {

GivenOptions option(const std::string& name, OptionValue value) { return {{name, {std::move(value), "benchmark"}}}; }

GivenOptions operator|(GivenOptions a, const GivenOptions& b) {
    for (const auto& [name, value] : b) a[name] = value;
    return a;
}

Case poolCase(const truth::pool3::SceneText& text, const std::string& method, const GivenOptions& options) {
    Monitor monitor;
    Scene scene = parseScene(truth::pool3::sceneToml(text), "pool3.toml", ".", 0, monitor);
    if (text.layer_height > 0 && text.layer_height < 2e-4) {  // a single layer, thinner than the loader lets a box be
        scene.domain.min.z = truth::pool3::kFloor - text.layer_height / 2,
        scene.domain.max.z = truth::pool3::kFloor + text.layer_height / 2;
    }
    return {std::move(scene), method, options};
}

truth::pool3::SceneText poolBox(int n) {
    truth::pool3::SceneText text;
    text.voxel_size = 2.0 / n;
    text.z_max = 0.125, text.z_min = text.z_max - 2;
    return text;
}

truth::pool3::SceneText shearedPoolBox(int n, int layers) {
    truth::pool3::SceneText text = poolBox(n);
    text.layer_height = 2.0 / layers;
    text.shear = "light";
    // The grid leans by 0.701 m and 0.405 m over its two metres; so much less of a box makes it n x n columns.
    text.half = {1 - 0.3504, 1 - 0.2023};
    return text;
}

truth::pool3::SceneText poolFloor(int n) {
    truth::pool3::SceneText text;
    text.voxel_size = 2.0 / n;
    text.layer_height = 1.5 / 14999.5;  // near 1e-4 m, and a layer's centre lies on the floor
    text.z_min = truth::pool3::kFloor - text.voxel_size, text.z_max = truth::pool3::kFloor + text.voxel_size;
    return text;
}

Timed once(const Case& c) {
    Monitor monitor;
    Scene scene = c.scene;
    scene.bake.method = c.method, scene.bake.method_options[c.method] = c.options;
    const auto start = std::chrono::steady_clock::now();
    BakedScene result = bakeScene(scene, monitor);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return {seconds, 1, std::move(result)};
}

Timed measure(const Case& c, const Effort& effort) {
    Timed best = once(c);
    if (effort.quick || best.seconds > 10) return best;
    double spent = 0;
    int runs = 0;
    while (spent < effort.least_seconds || runs < effort.least_runs) {
        Timed again = once(c);
        spent += again.seconds, ++runs;
        again.seconds = std::min(again.seconds, best.seconds);
        best = std::move(again);
    }
    best.runs = runs;
    return best;
}

FieldError fieldError(const LightField& field, const LightField& reference) {
    const GridFrame& f = reference.frame();
    double l1 = 0, squares = 0, sum = 0;
    for (int i = f.min.x; i <= f.max.x; ++i) {
        for (int j = f.min.y; j <= f.max.y; ++j) {
            for (int k = f.min.z; k <= f.max.z; ++k) {
                const double r = reference.irradiance({i, j, k}), d = field.irradiance({i, j, k}) - r;
                l1 += std::fabs(d), squares += d * d, sum += r;
            }
        }
    }
    const auto n = static_cast<double>(f.voxelCount());
    return {l1 / sum, std::sqrt(squares / n) / (sum / n)};
}

std::vector<double> floorValues(const LightField& field) {
    std::vector<double> map;
    const GridFrame& f = field.frame();
    for (int j = f.min.y; j <= f.max.y; ++j) {
        for (int i = f.min.x; i <= f.max.x; ++i) map.push_back(-field.flux({i, j, f.min.z}).z);
    }
    return map;
}

}  // namespace photic::benchmark
