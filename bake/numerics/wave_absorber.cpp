// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/wave_absorber.h"

#include <cmath>

namespace photic {
namespace {

constexpr double kLayerCells = 8;

}  // namespace

PmlTable pmlTable(double spacing, double speed, double dt, double frequency) {
    // A profile d^p over L loses R of a wave at normal incidence: sigma = -(p + 1) c ln(R) / (2 L). Smaller R steepen
    // the profile until the cells no longer resolve it; this pair reflects least at 10 cells a wavelength
    // (tests/numerics).
    constexpr double kPower = 3, kReflection = 1e-4;
    const double sigma = -(kPower + 1) * speed * std::log(kReflection) / (2 * kLayerCells * spacing);
    // The shift alpha turns the layer into plain damping for what is slower than the pulse; it fades outwards.
    const double alpha_most = 0.05 * frequency;
    const auto at = [&](double depth, float& a, float& b) {
        const double s = sigma * std::pow(depth, kPower), alpha = alpha_most * (1 - depth);
        const double keep = std::exp(-(s + alpha) * dt);
        b = static_cast<float>(keep), a = static_cast<float>(s + alpha > 0 ? s / (s + alpha) * (keep - 1) : 0);
    };
    PmlTable table;
    for (std::size_t i = 0; i < 8; ++i) {
        at((static_cast<double>(i) + 0.5) / kLayerCells, table.a[i], table.b[i]);
        at((static_cast<double>(i) + 1) / kLayerCells, table.a_half[i], table.b_half[i]);
    }
    return table;
}

double spongeDamping(double depth, double width, double spacing, double speed, double dt) {
    if (depth <= 0) return 0;
    constexpr double kReflection = 1e-3;
    const double most = -3 * speed * std::log(kReflection) / (2 * width * spacing);
    const double part = depth / width;
    return 0.5 * most * part * part * dt;
}

}  // namespace photic
