// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bake/scene/gaussian_bump.h"
#include "bake/scene/load_parts.h"
#include "bake/scene/wave_field.h"
#include "bake/scene/wind_sea.h"

namespace photic {
namespace {

constexpr double kGravity = 9.81;  // [m/s2]
constexpr int kLeastResolution = 16, kMostResolution = 2048;

double timeOf(const HeightFieldPlace& place, const LoadContext& context) { return context.frame / place.frame_rate; }

/// Cells of a patch with `resolution` of them along its longest side, nearly square.
glm::ivec2 cellsOf(glm::dvec2 size, std::int64_t resolution) {
    const double cell = std::max(size.x, size.y) / static_cast<double>(resolution);
    return {std::max(4, static_cast<int>(std::lround(size.x / cell))),
            std::max(4, static_cast<int>(std::lround(size.y / cell)))};
}

}  // namespace

std::shared_ptr<const HeightField> loadWaves(const TableReader& surface, HeightFieldPlace& place,
                                             LoadContext& context) {
    const ConfigValue& list = *surface.find("waves");
    if (list.kind != ConfigValue::Kind::Array || list.items.empty())
        surface.fail("waves", "'waves' must be an array of at least one { amplitude, wavelength, direction, phase }");
    const bool deep_water = surface.choice("animate", {"none", "deep_water"}).value_or(0) == 1;
    const double time = timeOf(place, context);
    std::vector<Wave> waves;
    for (const ConfigValue& item : list.items) {
        const TableReader table(item, "a wave", {"amplitude", "wavelength", "direction", "phase", "speed"});
        const auto amplitude = table.number("amplitude", anyNumber("m"));
        if (!amplitude) table.missing("amplitude", "0.02 [m]");
        const auto wavelength = table.number("wavelength", between(1e-6, 1e9, "m"));
        if (!wavelength) table.missing("wavelength", "0.5 [m]");
        Wave wave{*amplitude, *wavelength, table.heading("direction").value_or(glm::dvec2(1, 0)),
                  table.number("phase", withinReach("rad")).value_or(0)};
        const double k = 2 * std::numbers::pi / wave.wavelength;
        const auto speed = table.number("speed", withinReach("m/s"));
        if (speed || deep_water) {
            context.animate(0);
            wave.phase -= (speed ? k * *speed : std::sqrt(kGravity * k)) * time;
        }
        waves.push_back(wave);
    }
    // Waves know no edge: without a size they go on.
    if (place.size.x == 0) {
        if (place.outside_given && place.outside != Outside::Periodic)
            surface.missing("size", "[4, 4], where 'outside' begins");
        place.outside = Outside::Periodic;
    }
    const Patch patch = place.outside == Outside::Periodic
                            ? Patch::unbounded()
                            : Patch::around(glm::dvec2(place.center), place.size, place.center.z);
    return makeWaveField(std::move(waves), place.center, patch);
}

std::shared_ptr<const HeightField> loadBump(const TableReader& surface, const HeightFieldPlace& place,
                                            LoadContext& context) {
    const TableReader table(*surface.find("bump"), "'bump'",
                            {"height", "radius", "center", "speed", "depth", "damping", "resolution"});
    if (place.outside == Outside::Periodic)
        surface.fail("outside",
                     "a bump is let go between walls, which do not repeat; use outside = \"flat\" or \"none\"");
    table.exclusive({"speed", "depth"});

    GaussianBump bump;
    const auto height = table.number("height", anyNumber("m"));
    if (!height) table.missing("height", "0.1 [m]");
    const auto radius = table.number("radius", positive("m"));
    if (!radius) table.missing("radius", "0.15 [m], the standard deviation");
    bump.height = *height, bump.radius = *radius;
    bump.center = table.vector2("center", anyNumber("m")).value_or(glm::dvec2(0));
    for (int a = 0; a < 2; ++a)
        if (std::fabs(bump.center[a]) > 0.5 * place.size[a])
            table.fail("center", fmt::format("center.{} is {}; the pool reaches to +-{} m from its own centre", "xy"[a],
                                             bump.center[a], 0.5 * place.size[a]));
    bump.speed = table.number("speed", notNegative("m/s")).value_or(1);
    if (const auto depth = table.number("depth", positive("m"))) bump.speed = std::sqrt(kGravity * *depth);
    bump.damping = table.number("damping", notNegative("1/s")).value_or(0);

    const double longest = std::max(place.size.x, place.size.y);
    if (bumpModes(bump, longest) > kMostBumpModes)
        table.fail("radius", fmt::format("radius {} m is too small for a pool of {} m; use {:.3g} or more", bump.radius,
                                         longest, bump.radius * bumpModes(bump, longest) / kMostBumpModes));
    const auto fitting = static_cast<std::int64_t>(std::clamp(16 * longest / bump.radius, 256.0, 2048.0));
    const glm::ivec2 cells =
        cellsOf(place.size, table.integer("resolution", kLeastResolution, kMostResolution).value_or(fitting));
    context.animate(0);

    SplineFieldShape shape;
    shape.size = place.size, shape.center = place.center, shape.boundary = GridBoundary::Mirror,
    shape.interpolation = loadInterpolation(surface);
    return makeSplineField(shape, bumpHeights(bump, place.size, cells.x, cells.y, timeOf(place, context)));
}

std::shared_ptr<const HeightField> loadSea(const TableReader& surface, const HeightFieldPlace& place,
                                           LoadContext& context) {
    const TableReader table(*surface.find("sea"), "'sea'",
                            {"wind_speed", "fetch", "direction", "seed", "peak_enhancement", "spreading", "choppiness",
                             "shortest_wavelength", "period", "resolution"});
    WindSea sea;
    const auto wind = table.number("wind_speed", {0, 100, true, "m/s"});
    if (!wind) table.missing("wind_speed", "5 [m/s]");
    const auto fetch = table.number("fetch", positive("m"));
    if (!fetch) table.missing("fetch", "2000 [m]");
    sea.wind_speed = *wind, sea.fetch = *fetch, sea.gravity = kGravity;
    sea.direction = table.heading("direction").value_or(glm::dvec2(1, 0));
    sea.seed =
        static_cast<std::uint64_t>(table.integer("seed", 0, std::numeric_limits<std::int64_t>::max()).value_or(1));
    sea.peak_enhancement = table.number("peak_enhancement", between(1, 20)).value_or(sea.peak_enhancement);
    sea.spreading = table.number("spreading", between(0, 1000)).value_or(sea.spreading);
    sea.choppiness = table.number("choppiness", between(0, 4)).value_or(0);
    sea.period = table.number("period", positive("s")).value_or(0);

    const glm::ivec2 cells =
        cellsOf(place.size, table.integer("resolution", kLeastResolution, kMostResolution).value_or(256));
    const double cell = std::max(place.size.x / cells.x, place.size.y / cells.y);
    sea.shortest_wavelength = table.number("shortest_wavelength", positive("m")).value_or(4 * cell);
    if (sea.shortest_wavelength < 2 * cell)
        table.fail("shortest_wavelength",
                   fmt::format("shortest_wavelength {} m needs samples every {} m or less, they are {:.4g} m apart; "
                               "use a resolution of {:.0f} or more",
                               sea.shortest_wavelength, sea.shortest_wavelength / 2, cell,
                               std::ceil(2 * std::max(place.size.x, place.size.y) / sea.shortest_wavelength)));
    if (sea.shortest_wavelength > std::min(place.size.x, place.size.y))
        table.fail("shortest_wavelength", fmt::format("shortest_wavelength {} m does not fit the patch of {} m",
                                                      sea.shortest_wavelength, std::min(place.size.x, place.size.y)));

    // A sea that repeats after a whole number of frames is the very same then.
    const double loop = sea.period * place.frame_rate;
    const bool loops = loop >= 1 && loop < 1e6 && std::fabs(loop - std::round(loop)) < 1e-9 * loop;
    context.animate(loops ? std::llround(loop) : 0);
    const int frame = loops ? context.frame % static_cast<int>(std::llround(loop)) : context.frame;
    const SeaSamples samples = seaSamples(sea, place.size, cells.x, cells.y, frame / place.frame_rate);
    const double peak = peakFrequency(sea), peak_wavelength = 2 * std::numbers::pi * kGravity / (peak * peak);
    WindSea whole = sea;
    whole.shortest_wavelength = peak_wavelength / 400;
    const double share = samples.variance / std::pow(significantHeight(whole) / 4, 2);
    if (share < 0.5)
        context.monitor.warn(fmt::format(
            "{}: the patch of {} x {} m with {} x {} samples holds {:.0f} % of this sea's energy; its dominant wave is "
            "{:.3g} m long. For all of "
            "it use a larger 'size' or a finer 'resolution'; for small waves on a small patch a shorter 'fetch'",
            surface.where("sea"), place.size.x, place.size.y, cells.x, cells.y, 100 * share, peak_wavelength));

    SplineFieldShape shape;
    shape.size = place.size, shape.center = place.center, shape.boundary = GridBoundary::Periodic,
    shape.interpolation = loadInterpolation(surface);
    shape.bounded = place.outside != Outside::Periodic;
    if (samples.displacement.empty()) return makeSplineField(shape, samples.heights);
    auto field = makeSplineField(shape, samples.heights, std::array{samples.displacement[0], samples.displacement[1]});
    warnOfFolds(table, "choppiness", *field, shape, cells.x, cells.y, context.monitor);
    return field;
}

}  // namespace photic
