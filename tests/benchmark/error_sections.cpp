// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "bake/threads/parallel_for.h"
#include "tests/benchmark/sections.h"

namespace photic::benchmark {
namespace {

std::string percent(double part) { return fmt::format("{:.3g} %", 100 * part); }

GivenOptions mesh(std::int64_t cells) { return option("mesh", cells); }

/// Time and error of one method at growing work (mesh cells, paths), and what it would take to reach an error: more
/// work by the slope of the last two points, each unit of it at their marginal cost, so that fixed costs do not bend
/// the line.
struct Ladder {
    std::vector<double> work, seconds, errors;
    /// d log(error) / d log(work) over the last two points.
    double slope() const {
        const std::size_t n = errors.size();
        return std::log(errors[n - 1] / errors[n - 2]) / std::log(work[n - 1] / work[n - 2]);
    }
    double secondsFor(double error) const {
        // between two points where they span the error
        for (std::size_t i = 0; i + 1 < errors.size(); ++i) {
            if (errors[i] >= error && errors[i + 1] <= error) {
                const double part = std::log(error / errors[i]) / std::log(errors[i + 1] / errors[i]);
                return seconds[i] * std::pow(seconds[i + 1] / seconds[i], part);
            }
        }
        const std::size_t n = errors.size();
        const double marginal = (seconds[n - 1] - seconds[n - 2]) / (work[n - 1] - work[n - 2]);
        const double needed = work.back() * std::pow(error / errors.back(), 1 / slope());
        return seconds.back() + marginal * (needed - work.back());
    }
    bool reaches(double error) const { return errors.back() <= error; }
};

}  // namespace

void floorErrors(const Effort& effort, Findings& findings) {
    setThreadCount(1);
    Table table{"Floor of the pool, 512 x 512, one core",
                "Against the exact map of tests/data; a point sun.",
                {"beams, mesh", "[s]", "relative L1", "relative RMSE"},
                {}};
    const auto exact = truth::pool3::exactFloor();
    for (const std::int64_t cells :
         effort.quick ? std::vector<std::int64_t>{64} : std::vector<std::int64_t>{256, 512, 1024, 2048, 4096}) {
        const Timed t = measure(poolCase(poolFloor(512), "beams", mesh(cells)), effort);
        const auto map = floorValues(t.result.volume.field);
        table.add({std::to_string(cells), fmt::format("{:.3f}", t.seconds),
                   percent(truth::relativeL1(map, exact.values)), percent(truth::relativeRmse(map, exact.values))});
    }
    setThreadCount(0);
    findings.tables.push_back(table);
}

void volumeErrors(const Effort& effort, Findings& findings) {
    const int n = effort.quick ? 16 : 128;
    setThreadCount(0);
    truth::pool3::SceneText text = poolBox(n);
    text.bake = "quadrature = 4\n";
    const Timed reference = once(poolCase(text, "beams", mesh(effort.quick ? 64 : 2048)));
    text.bake.clear();

    setThreadCount(1);
    Table table{fmt::format("Pool {}^3, time against error, one core", n),
                "Irradiance of all voxels against beams with mesh 2048 and four points a layer, which agree with the "
                "photons within their noise.",
                {"method", "[s]", "relative L1", "relative RMSE"},
                {}};
    const auto run = [&](const std::string& series, const std::string& label, const truth::pool3::SceneText& scene,
                         const std::string& method, const GivenOptions& options, double work, Ladder& ladder) {
        const Timed t = measure(poolCase(scene, method, options), effort);
        const FieldError e = fieldError(t.result.volume.field, reference.result.volume.field);
        table.add({series + ", " + label, fmt::format("{:.3f}", t.seconds), percent(e.l1), percent(e.rmse)});
        findings.points.push_back({series, series + ", " + label, t.seconds, e.rmse});
        ladder.work.push_back(work), ladder.seconds.push_back(t.seconds), ladder.errors.push_back(e.rmse);
    };
    Ladder beams, adaptive, planes, quasi, random;
    for (const std::int64_t cells :
         effort.quick ? std::vector<std::int64_t>{16, 32} : std::vector<std::int64_t>{128, 192, 256, 384, 512, 768}) {
        run("beams", fmt::format("mesh {}", cells), text, "beams", mesh(cells), static_cast<double>(cells * cells),
            beams);
    }
    run("beams", "adaptive", text, "beams", {}, 0, adaptive);
    // One plane a layer bounds the others.
    truth::pool3::SceneText fine = text;
    fine.bake = "quadrature = 4\n";
    for (const std::int64_t cells :
         effort.quick ? std::vector<std::int64_t>{16} : std::vector<std::int64_t>{128, 256, 512}) {
        run("beams, 4 planes", fmt::format("mesh {}", cells), fine, "beams", mesh(cells),
            static_cast<double>(cells * cells), planes);
    }
    const auto counts = effort.quick ? std::vector<double>{1e3, 1e4} : std::vector<double>{1e5, 1e6, 1e7};
    for (const double count : counts) {
        const auto paths = option("count", static_cast<std::int64_t>(count));
        run("photons, quasi-random", fmt::format("{:.0e} paths", count), text, "photons", paths, count, quasi);
        run("photons, random", fmt::format("{:.0e} paths", count), text, "photons",
            paths | option("sampling", std::string("random")), count, random);
    }
    findings.tables.push_back(table);

    constexpr double kError = 0.014;
    Table equal{fmt::format("Seconds to {:.1f} % relative RMSE, pool {}^3, one core", 100 * kError, n),
                "Beyond the last row above, the work follows from the slope of log error over log work (cells, paths), "
                "the time "
                "from the marginal cost of the last two rows.",
                {"method", "[s]", "slope", "reached by", "this / beams"},
                {}};
    const double fastest = beams.secondsFor(kError);
    for (const auto& [name, ladder] : {std::pair<std::string, const Ladder&>{"beams", beams},
                                       {"photons, quasi-random", quasi},
                                       {"photons, random", random}}) {
        equal.add({name, fmt::format("{:.3g}", ladder.secondsFor(kError)), fmt::format("{:.2f}", ladder.slope()),
                   ladder.reaches(kError) ? "a run" : "the slope",
                   fmt::format("{:.1f}", ladder.secondsFor(kError) / fastest)});
    }
    findings.tables.push_back(equal);
    setThreadCount(0);
}

}  // namespace photic::benchmark
