// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "bake/field/scene_grid.h"
#include "bake/methods/wavefront.h"
#include "bake/report/stopwatch.h"
#include "bake/scene/graded_index.h"
#include "bake/scene/index_volume.h"
#include "bake/threads/parallel_for.h"
#include "tests/benchmark/sections.h"
#include "tests/numerics/bump_front.h"

namespace photic::benchmark {

namespace {

/// n^2 = 1 + five Gaussian lenses in [-1, 1]^3: strong caustics, of a hundred times the light that comes in.
class FiveLenses final : public GradedIndex {
public:
    IndexSample at(const glm::dvec3& p) const override {
        struct Lens {
            glm::dvec3 center;
            double amplitude, radius;
        };
        static constexpr std::array<Lens, 5> kLenses{{{{0, 0, -0.45}, 0.75, 0.28},
                                                      {{0.35, 0.3, -0.1}, 0.5, 0.2},
                                                      {{-0.4, 0.25, -0.3}, 0.45, 0.22},
                                                      {{-0.2, -0.45, 0.05}, 0.55, 0.18},
                                                      {{0.45, -0.35, -0.5}, 0.4, 0.25}}};
        IndexSample out;
        for (const Lens& lens : kLenses) {
            const glm::dvec3 d = p - lens.center;
            const double per_square = 1 / (lens.radius * lens.radius);
            const double value = 0.5 * lens.amplitude * std::exp(-0.5 * per_square * glm::dot(d, d));
            out.half_square += value, out.gradient -= value * per_square * d;
        }
        return out;
    }
    bool contains(const glm::dvec3&) const override { return true; }
    std::optional<WorldBox> bounds() const override { return {}; }
};

Scene lensScene(int n) {
    Scene scene;
    scene.file = "benchmark";
    scene.domain.min = glm::dvec3(-1), scene.domain.max = glm::dvec3(1), scene.domain.voxel_size = 2.0 / n;
    Light sun;
    sun.name = "sun", sun.direction = {0, 0, 1}, sun.irradiance = glm::dvec3(1);
    scene.lights = {sun};
    GradedObject lenses;
    lenses.name = "lenses", lenses.index = {std::make_shared<FiveLenses>()};
    scene.index = std::make_shared<IndexVolume>(std::vector<GradedObject>{lenses});
    scene.bake.quadrature = 1;
    return scene;
}

struct FrontRun {
    BakeResult result;
    double processor = 0, wall = 0;
};

FrontRun bakeFronts(const Scene& scene, const GivenOptions& options) {
    Monitor monitor;
    const auto needed = std::make_shared<const NeededVoxels>(NeededVoxels::everything(sceneFrame(scene)));
    const double before = test::processorSeconds();
    const Stopwatch watch;
    BakeResult result = wavefrontMethod().bake(scene, needed, options, monitor);
    return {std::move(result), test::processorSeconds() - before, watch.seconds()};
}

}  // namespace

void fronts(const Effort& effort, Findings& findings) {
    Table table{
        "Fronts through five Gaussian lenses, one core",
        "n^2 = 1 + five lenses of amplitudes 0.4 to 0.75 in [-1, 1]^3, light along z, one plane a layer, one "
        "step a layer. Seconds of processor time, the least of three runs, with the sampling of the index; "
        "errors against four rays a voxel's side and four steps a layer. Times less: by the clock, the least of three "
        "runs each; they mean something where as many cores are idle.",
        {"voxels", "rays a voxel's side", "[s]", "of it the index [s]", "relative L1", "relative RMSE",
         "two threads take so many times less", "eight threads"},
        {}};
    const int runs = effort.quick ? 1 : 3;
    for (const int n : effort.quick ? std::vector<int>{32} : std::vector<int>{128, 256}) {
        const Scene scene = lensScene(n);
        setThreadCount(0);
        const BakeResult fine = bakeFronts(scene, option("spacing", 0.25) | option("steps", std::int64_t{4})).result;
        for (const double rays : {0.5, 1.0, 1.5, 2.0}) {
            const auto wall = [&](int threads) {
                setThreadCount(threads);
                double least = 1e300;
                for (int run = 0; run < runs; ++run)
                    least = std::min(least, bakeFronts(scene, option("spacing", 1 / rays)).wall);
                return least;
            };
            setThreadCount(1);
            double least = 1e300, index = 0, one_thread = 1e300;
            FieldError error;
            for (int run = 0; run < runs; ++run) {
                const FrontRun at = bakeFronts(scene, option("spacing", 1 / rays));
                one_thread = std::min(one_thread, at.wall);
                if (at.processor > least) continue;
                least = at.processor;
                for (const auto& [stage, seconds] : at.result.report.seconds)
                    if (stage == "index") index = seconds * at.processor / at.wall;
                error = fieldError(at.result.field, fine.field);
            }
            table.add({fmt::format("{}^3", n), fmt::format("{:.1f}", rays), fmt::format("{:.3f}", least),
                       fmt::format("{:.3f}", index), fmt::format("{:.3f} %", 100 * error.l1),
                       fmt::format("{:.2f} %", 100 * error.rmse), fmt::format("{:.2f}", one_thread / wall(2)),
                       fmt::format("{:.2f}", one_thread / wall(8))});
        }
    }
    setThreadCount(0);
    findings.tables.push_back(table);
}

}  // namespace photic::benchmark
