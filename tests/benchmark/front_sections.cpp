// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bake/field/scene_grid.h"
#include "bake/graded/ray_integrator.h"
#include "bake/graded/spline_index.h"
#include "bake/methods/photons.h"
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

/// Light through the lenses in photons.
FrontRun bakeLensPhotons(const Scene& scene, std::int64_t count) {
    Monitor monitor;
    const auto needed = std::make_shared<const NeededVoxels>(NeededVoxels::everything(sceneFrame(scene)));
    PhotonOptions options;
    options.count = count;
    const double before = test::processorSeconds();
    const Stopwatch watch;
    BakeResult result = bakePhotons(scene, needed, options, monitor);
    return {std::move(result), test::processorSeconds() - before, watch.seconds()};
}

/// What photons say that they are off by: mean standard error over mean light.
double ownError(const LightField& field, const LightField& standard_error) {
    double error = 0, sum = 0;
    const GridFrame& frame = field.frame();
    for (int k = frame.min.z; k <= frame.max.z; ++k)
        for (int j = frame.min.y; j <= frame.max.y; ++j)
            for (int i = frame.min.x; i <= frame.max.x; ++i)
                error += standard_error.irradiance({i, j, k}), sum += field.irradiance({i, j, k});
    return error / sum;
}

/// The step of the tracer of MitsubaER [Pediredla et al. 2020, mitsubaER's heterogeneous refractive medium]: kick,
/// drift, kick in length; n is that of the step's start, and the slope is looked at twice.
void stepInLength(const GradedIndex& index, double length, GradedRay& ray) {
    const IndexSample start = index.at(ray.position);
    const double n = std::sqrt(2 * start.half_square);
    ray.momentum += (0.5 * length / n) * start.gradient;  // grad n = grad(n^2 / 2) / n
    ray.position += (length / n) * ray.momentum;
    const IndexSample end = index.at(ray.position);
    ray.momentum += (0.5 * length / std::sqrt(2 * end.half_square)) * end.gradient;
}

/// How far rays are from where they should be after the lenses, and what a step takes.
Table stepTable(bool quick) {
    Table table{"Steps of single rays through the five lenses",
                "The same spline of 64^3 samples for all; 400 rays along z. Mean miss on the far side from Runge-Kutta "
                "steps of 1/64 voxel. Euler in equal time is the paper's step, kick - drift - kick in length that of "
                "MitsubaER's tracer (its formula, written anew here).",
                {"step", "voxels a step", "looks at the index a step", "mean miss [voxels]", "ns a voxel"},
                {}};
    const int n = quick ? 32 : 64;
    const double voxel = 2.0 / n;
    const FiveLenses lenses;
    SplineIndex::Nodes nodes;
    nodes.first_world = glm::dvec3(-1 - 3 * voxel), nodes.spacing = glm::dvec3(voxel), nodes.count = glm::ivec3(n + 7);
    const SplineIndex spline(
        nodes, [&](const glm::dvec3& p) { return lenses.at(p).half_square; }, SplineFit::Through);
    const SplineGradedIndex index(spline);
    constexpr int kSide = 20;
    const auto startOf = [&](int i) {
        const glm::dvec3 place(0.09 * (i % kSide - 0.5 * (kSide - 1)), 0.09 * (i / kSide - 0.5 * (kSide - 1)), -1);
        return startRay(index, place, {0, 0, 1});
    };
    // On to z = 1 exactly: straight from the last step before it.
    const auto finish = [](GradedRay& ray) { ray.position += (1 - ray.position.z) / ray.momentum.z * ray.momentum; };
    std::vector<glm::dvec3> truth;
    for (int i = 0; i < kSide * kSide; ++i) {
        GradedRay ray = startOf(i);
        while (ray.position.z < 1) stepRungeKutta(index, voxel / 64, ray);
        finish(ray);
        truth.push_back(ray.position);
    }
    struct Kind {
        const char* name;
        int looks;
        std::function<void(const IndexSample&, double, GradedRay&)> step;  // over so many metres
    };
    const Kind kinds[] = {{"drift - kick - drift between planes (fronts)", 1,
                           [&](const IndexSample&, double h, GradedRay& ray) { stepBetweenPlanes(index, 2, h, ray); }},
                          {"kick - drift - kick in length (MitsubaER)", 2,
                           [&](const IndexSample&, double h, GradedRay& ray) { stepInLength(index, h, ray); }},
                          {"Euler in equal time (the paper)", 1,
                           [&](const IndexSample&, double h, GradedRay& ray) { stepEqualTime(index, h, ray); }},
                          {"Yoshida's (photons)", 3,
                           [&](const IndexSample& here, double h, GradedRay& ray) {
                               stepYoshida(index, h / std::sqrt(2 * here.half_square), ray);
                           }},
                          {"Runge-Kutta", 4, [&](const IndexSample& here, double h, GradedRay& ray) {
                               stepRungeKutta(index, h / std::sqrt(2 * here.half_square), ray);
                           }}};
    for (const Kind& kind : kinds)
        for (const double voxels : {1.0, 0.5, 0.25}) {
            const double before = test::processorSeconds();
            double miss = 0;
            for (int i = 0; i < kSide * kSide; ++i) {
                GradedRay ray = startOf(i);
                // Steps in length or time are as long in air; where n is 1 the last one ends on the far side.
                IndexSample here{0.5 * glm::dot(ray.momentum, ray.momentum), glm::dvec3(0)};
                while (ray.position.z < 1 - 0.5 * voxels * voxel) {
                    kind.step(here, voxels * voxel, ray);
                    here.half_square = 0.5 * glm::dot(ray.momentum, ray.momentum);
                }
                finish(ray);
                miss += glm::distance(ray.position, truth[static_cast<std::size_t>(i)]) / (voxel * kSide * kSide);
            }
            const double seconds = test::processorSeconds() - before;
            table.add({kind.name, fmt::format("{}", voxels), fmt::format("{}", kind.looks), fmt::format("{:.4f}", miss),
                       fmt::format("{:.0f}", 1e9 * seconds / (kSide * kSide * n))});
        }
    return table;
}

}  // namespace

/// Fronts, the paper's preset and photons, each against fine fronts.
void frontPeers(const Effort& effort, Findings& findings) {
    Table table{
        "Run time against error through five Gaussian lenses: fronts, the paper, photons",
        "The scene of \"fronts\", one core, seconds of processor time with the sampling of the index; errors "
        "against fronts of four rays a voxel's side and four steps a layer. Of photons in parentheses what they "
        "say themselves that they are off by.",
        {"voxels", "method", "", "[s]", "relative L1", "relative RMSE"},
        {}};
    for (const int n : effort.quick ? std::vector<int>{32} : std::vector<int>{64, 128}) {
        const Scene scene = lensScene(n);
        setThreadCount(0);
        const BakeResult fine = bakeFronts(scene, option("spacing", 0.25) | option("steps", std::int64_t{4})).result;
        setThreadCount(1);
        const auto add = [&](const std::string& method, const std::string& how, const FrontRun& run) {
            const FieldError error = fieldError(run.result.field, fine.field);
            std::string own;
            if (run.result.standard_error)
                own = fmt::format(" ({:.0f} %)", 100 * ownError(run.result.field, *run.result.standard_error));
            table.add({fmt::format("{}^3", n), method, how, fmt::format("{:.2f}", run.processor),
                       fmt::format("{:.3f} %{}", 100 * error.l1, own), fmt::format("{:.2f} %", 100 * error.rmse)});
        };
        for (const double rays : {0.5, 1.0, 1.5, 2.0})
            add("fronts", fmt::format("{} rays a voxel's side", rays), bakeFronts(scene, option("spacing", 1 / rays)));
        for (const char* integrator : {"runge_kutta", "yoshida", "controlled"})
            add("fronts", fmt::format("1 ray, integrator = \"{}\"", integrator),
                bakeFronts(scene, option("integrator", std::string(integrator))));
        add("fronts", "1 ray, arrivals = \"strongest\"",
            bakeFronts(scene, option("arrivals", std::string("strongest"))));
        for (const char* area : {"corners", "jacobian"})
            add("the paper's preset", fmt::format("area = \"{}\"", area),
                bakeFronts(scene, option("preset", std::string("paper")) | option("area", std::string(area))));
        for (const std::int64_t count : {3000, 10000, 30000})
            add("photons", fmt::format("{} paths", count), bakeLensPhotons(scene, effort.quick ? count / 100 : count));
    }
    setThreadCount(0);
    findings.tables.push_back(table);
    findings.tables.push_back(stepTable(effort.quick));
}

void fronts(const Effort& effort, Findings& findings) {
    Table table{
        "Fronts through five Gaussian lenses, one core",
        "n^2 = 1 + five lenses of amplitudes 0.4 to 0.75 in [-1, 1]^3, light along z, one plane a layer, one "
        "step a layer. Seconds of processor time, the least of three runs, with the sampling of the index; "
        "errors against four rays a voxel's side and four steps a layer. Times less: by the clock, the least of three "
        "runs each, where there are as many cores; they mean something where those are idle.",
        {"voxels", "rays a voxel's side", "tubes are halved", "[s]", "of it the index [s]", "relative L1",
         "relative RMSE", "two threads take so many times less", "eight threads"},
        {}};
    const int runs = effort.quick ? 1 : 3;
    for (const int n : effort.quick ? std::vector<int>{32} : std::vector<int>{128, 256}) {
        Scene scene = lensScene(n);
        const double tolerance = scene.bake.tolerance;
        setThreadCount(0);
        const BakeResult fine = bakeFronts(scene, option("spacing", 0.25) | option("steps", std::int64_t{4})).result;
        for (const bool halves : {false, true})
            for (const double rays : {0.5, 1.0, 1.5, 2.0}) {
                scene.bake.tolerance = halves ? tolerance : 1e6;
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
                const auto timesLess = [&](int threads) {
                    const bool asked = halves && static_cast<int>(std::thread::hardware_concurrency()) >= threads;
                    return asked ? fmt::format("{:.2f}", one_thread / wall(threads)) : std::string();
                };
                table.add({fmt::format("{}^3", n), fmt::format("{:.1f}", rays), halves ? "as by default" : "no",
                           fmt::format("{:.3f}", least), fmt::format("{:.3f}", index),
                           fmt::format("{:.3f} %", 100 * error.l1), fmt::format("{:.2f} %", 100 * error.rmse),
                           timesLess(2), timesLess(8)});
            }
    }
    setThreadCount(0);
    findings.tables.push_back(table);
}

}  // namespace photic::benchmark
