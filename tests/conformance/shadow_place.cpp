// SPDX-License-Identifier: Apache-2.0
#include "tests/conformance/shadow_place.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <numbers>

#include "tests/support/closed_forms.h"

namespace photic {
namespace {

constexpr double kIor = 1.333;
constexpr std::array kAcross{8, 4, 32, 12, 40, 16, 24};
constexpr double kMostVoxels = 6e6;

/// Overshoot of two voxels, and what rounding to layers takes.
constexpr int kLayersBelow = 4;
constexpr int kMargin = 3, kWideMargin = 60;  // voxels about the shadow

truth::SineWater drawWater(ShadowPlace::Water kind, truth::Dice& dice) {
    truth::SineWater water;
    const auto harmonic = [&](double amplitude, double wavelength) {
        water.harmonics.push_back({amplitude, wavelength, dice.between(0, 360), dice.between(0, 6.28)});
    };
    if (kind == ShadowPlace::Water::Ripples) harmonic(0.002, dice.between(0.2, 0.5)), harmonic(0.0005, 0.17);
    if (kind == ShadowPlace::Water::Swell) harmonic(dice.between(0.05, 0.2), 6);
    return water;
}

truth::Solid drawSolid(ShadowPlace& place, double width, double top, truth::Dice& dice) {
    const glm::dvec2 at(dice.between(-1, 1), dice.between(-1, 1));
    const double half = width / 2;
    switch (place.shape) {
        case ShadowPlace::Shape::Pole:
            return truth::Box{{at - half, top - dice.between(3, 6) * width}, {at + half, top}};
        case ShadowPlace::Shape::Box:
            return truth::Box{{at - half, top - dice.between(0.3, 1) * width},
                              {at + half * glm::dvec2(1, dice.between(1, 1.5)), top}};
        case ShadowPlace::Shape::Ball:
            return truth::Ball{{at, top - half}, half};
        case ShadowPlace::Shape::Mesh:
            break;
    }
    return truth::rock({at, top - half}, width, 2, place.seed);
}

double bottomOf(const truth::Solid& solid) {
    if (const auto* box = std::get_if<truth::Box>(&solid)) return box->min.z;
    const truth::Ball ball = truth::hull(solid);
    return ball.center.z - ball.radius;
}
double topOf(const truth::Solid& solid) {
    if (const auto* box = std::get_if<truth::Box>(&solid)) return box->max.z;
    const truth::Ball ball = truth::hull(solid);
    return ball.center.z + ball.radius;
}

std::string writeMesh(const truth::Triangles& mesh, std::uint64_t seed) {
    const std::string path = fmt::format("{}photic_rock_{}_{}.obj", ::testing::TempDir(), ::getpid(), seed);
    std::ofstream out(path);
    for (const glm::dvec3& p : mesh.positions) out << fmt::format("v {:.17g} {:.17g} {:.17g}\n", p.x, p.y, p.z);
    for (const auto& t : mesh.triangles) out << fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    return path;
}

// The box that is baked holds the whole shadow on the plane.
struct Bounds {
    glm::dvec3 low, high;
};
Bounds boundsOf(const ShadowPlace& place) {
    const double margin = (place.extent == ShadowPlace::Extent::Wide ? kWideMargin : kMargin) * place.voxel;
    Bounds b{{place.blocked.low - margin, place.plane_z - 1.5 * place.voxel},
             {place.blocked.high + margin, place.plane_z + 1.5 * place.voxel}};
    if (place.extent == ShadowPlace::Extent::Plane || place.extent == ShadowPlace::Extent::Wide) return b;
    b.high.z = place.extent == ShadowPlace::Extent::Water ? 2 * place.voxel : topOf(place.solid) + place.voxel;
    for (const auto& h : place.water.harmonics)
        if (place.extent == ShadowPlace::Extent::Water) b.high.z += h.amplitude;
    const truth::Ball hull = truth::hull(place.solid);
    b.low.x = std::min(b.low.x, hull.center.x - hull.radius), b.low.y = std::min(b.low.y, hull.center.y - hull.radius);
    b.high.x = std::max(b.high.x, hull.center.x + hull.radius);
    b.high.y = std::max(b.high.y, hull.center.y + hull.radius);
    return b;
}

std::string surfaceToml(const ShadowPlace& place) {
    if (place.water.harmonics.empty()) return "flat = true\nsize = [12, 12]\n";
    std::string waves;
    for (const auto& h : place.water.harmonics)
        waves += fmt::format("{{ amplitude = {:.17g}, wavelength = {:.17g}, direction = {:.17g}, phase = {:.17g} }}, ",
                             h.amplitude, h.wavelength, h.direction_deg, h.phase);
    return fmt::format("size = [24, 24]\nwaves = [{}]\n", waves);
}

std::string objectToml(const ShadowPlace& place) {
    std::string shape;
    if (const auto* box = std::get_if<truth::Box>(&place.solid))
        shape = fmt::format("box = {{ min = [{:.17g}, {:.17g}, {:.17g}], max = [{:.17g}, {:.17g}, {:.17g}] }}",
                            box->min.x, box->min.y, box->min.z, box->max.x, box->max.y, box->max.z);
    else if (const auto* ball = std::get_if<truth::Ball>(&place.solid))
        shape = fmt::format("sphere = {{ center = [{:.17g}, {:.17g}, {:.17g}], radius = {:.17g} }}", ball->center.x,
                            ball->center.y, ball->center.z, ball->radius);
    else
        shape = fmt::format("file = \"{}\"", place.mesh_file);
    return fmt::format("[[object]]\nname = \"thing\"\nrole = \"{}\"\n{}\n", place.role, shape);
}

}  // namespace

double ShadowPlace::expected() const {
    if (kind != Water::Flat || shape == Shape::Mesh) return blocked.power;
    const truth::PlaneWater plane{1, -sun.z, 1, kIor};
    const glm::dvec3 down = truth::refractDown(sun, {0, 0}, kIor)->direction;
    const double area = shape == Shape::Ball ? truth::shadowArea(std::get<truth::Ball>(solid), down)
                                             : truth::shadowArea(std::get<truth::Box>(solid), down);
    return area * plane.horizontal(0);
}

std::string ShadowPlace::toml(bool with_object) const {
    const Bounds b = boundsOf(*this);
    return fmt::format(R"(photic = 1
[domain]
min = [{:.17g}, {:.17g}, {:.17g}]
max = [{:.17g}, {:.17g}, {:.17g}]
voxel_size = {:.17g}
[[light]]
type = "sun"
direction = [{:.17g}, {:.17g}, {:.17g}]
irradiance = 1.0
angular_diameter = 0
[[surface]]
name = "water"
{}{})",
                       b.low.x, b.low.y, b.low.z, b.high.x, b.high.y, b.high.z, voxel, sun.x, sun.y, sun.z,
                       surfaceToml(*this), with_object ? objectToml(*this) : "");
}

std::string ShadowPlace::describe() const {
    static constexpr std::array kShapes{"pole", "box", "ball", "mesh"};
    static constexpr std::array kWaters{"flat water", "ripples", "swell"};
    static constexpr std::array kExtents{"object", "plane", "water", "wide plane"};
    return fmt::format("place {}: {} {} of {:.3f} m, {} voxels across, under {}, {} baked, sun {:.0f} deg", seed, role,
                       kShapes[static_cast<std::size_t>(shape)], width(), voxels_across,
                       kWaters[static_cast<std::size_t>(kind)], kExtents[static_cast<std::size_t>(extent)],
                       std::acos(-sun.z) * 180 / std::numbers::pi);
}

ShadowPlace shadowPlace(int index) {
    ShadowPlace place;
    place.seed = static_cast<std::uint64_t>(index);
    truth::Dice dice(place.seed + 1);
    place.shape = static_cast<ShadowPlace::Shape>(index % 4);
    place.kind = static_cast<ShadowPlace::Water>(index % 3);
    place.voxels_across = kAcross[static_cast<std::size_t>(index) % kAcross.size()];
    place.extent = static_cast<ShadowPlace::Extent>(dice.below(4));
    place.role = dice.below(2) == 0 ? "receiver" : "blocker";
    place.water = drawWater(place.kind, dice);
    const double width = dice.logBetween(0.05, 0.5), zenith = dice.between(0, 1.05), azimuth = dice.between(0, 6.2832);
    place.voxel = width / place.voxels_across;
    place.sun = {std::sin(zenith) * std::cos(azimuth), std::sin(zenith) * std::sin(azimuth), -std::cos(zenith)};
    // Below the troughs.
    place.solid =
        drawSolid(place, width, -dice.between(0.05, 0.8) - (place.kind == ShadowPlace::Water::Swell ? 0.25 : 0), dice);
    if (const auto* mesh = std::get_if<truth::Triangles>(&place.solid)) place.mesh_file = writeMesh(*mesh, place.seed);
    place.plane_z = (std::floor(bottomOf(place.solid) / place.voxel) - kLayersBelow + 0.5) * place.voxel;
    place.blocked = truth::blockedLight(place.water, place.sun, place.solid, place.plane_z);
    const auto voxels = [&] {
        const glm::dvec3 size = (boundsOf(place).high - boundsOf(place).low) / place.voxel;
        return size.x * size.y * size.z;
    };
    if (place.extent == ShadowPlace::Extent::Water && voxels() > kMostVoxels)
        place.extent = ShadowPlace::Extent::Object;
    if (voxels() > kMostVoxels) place.extent = ShadowPlace::Extent::Plane;
    return place;
}

double powerThroughLayer(const LightField& field, int layer) {
    const GridFrame& f = field.frame();
    double power = 0;
    for (int j = f.min.y; j <= f.max.y; ++j)
        for (int i = f.min.x; i <= f.max.x; ++i) power -= field.flux({i, j, layer}).z;
    return power * f.worldFromIndex()[0][0] * f.worldFromIndex()[1][1];
}

MissingLight missingLight(const ShadowPlace& place, const std::string& method, const GivenOptions& options) {
    const Baked lit = bakeText(place.toml(false), method, options), dark = bakeText(place.toml(true), method, options);
    const int layer = static_cast<int>(std::floor(place.plane_z / place.voxel));
    const auto worse = [&](const auto& of) { return std::max(of(lit.result.report), of(dark.result.report)); };
    return {powerThroughLayer(lit.field(), layer) - powerThroughLayer(dark.field(), layer),
            worse([](const BakeReport& r) { return r.power.imbalance(); }),
            worse([](const BakeReport& r) { return r.path.imbalance(); })};
}

}  // namespace photic
