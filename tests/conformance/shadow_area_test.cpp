// SPDX-License-Identifier: Apache-2.0
// A shadow is a number: the light that is missing on a plane behind a thing, with every setting left as it is, against
// closed forms and counted rays. PHOTIC_SHADOW_PLACES=200 tries as many places; 21 by default.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/conformance/shadow_place.h"

namespace photic {
namespace {

int placeCount() {
    const char* const given = std::getenv("PHOTIC_SHADOW_PLACES");
    return given ? std::atoi(given) : 21;
}

/// Relative error that a shadow may have: 5 % at 8 voxels across and 1 % at 32, a straight line between them on
/// logarithmic scales; below 8 none may be lost, and above 32 it is 1 %.
double allowance(int voxels_across) {
    if (voxels_across < 8) return 0.2;
    return 0.05 * std::pow(8.0 / std::min(voxels_across, 32), std::log(5.0) / std::log(4.0));
}

struct Tally {
    int places = 0, lost = 0, off = 0;
    double worst = 0;
};

void tryPlace(const ShadowPlace& place, Tally& tally) {
    const MissingLight missing = missingLight(place, "beams");
    const double share = missing.power / place.expected(), allowed = allowance(place.voxels_across);
    if (!place.mesh_file.empty()) std::filesystem::remove(place.mesh_file);
    ++tally.places, tally.lost += share < 0.5, tally.off += !(std::fabs(share - 1) <= allowed);
    tally.worst = std::max(tally.worst, std::fabs(share - 1));
    if (std::fabs(share - 1) > allowed) fmt::print("  {}: {:.4f} of its shadow\n", place.describe(), share);
    EXPECT_NEAR(share, 1, allowed) << place.describe();
    EXPECT_LT(missing.power_imbalance, 1e-6) << place.describe();
    EXPECT_LT(missing.path_imbalance, 1e-6) << place.describe();
}

void tryAll(ShadowPlace::Water kind) {
    Tally tally;
    for (int i = static_cast<int>(kind); i < placeCount(); i += 3) tryPlace(shadowPlace(i), tally);
    fmt::print("  {} places: {} shadows lost (less than half there), {} beyond their allowance, worst {:.3f}\n",
               tally.places, tally.lost, tally.off, tally.worst);
}

TEST(ShadowArea, UnderFlatWater) { tryAll(ShadowPlace::Water::Flat); }
TEST(ShadowArea, UnderRipplesOfTwoMillimetres) { tryAll(ShadowPlace::Water::Ripples); }
TEST(ShadowArea, UnderASwellOfSixMetres) { tryAll(ShadowPlace::Water::Swell); }

TEST(ShadowArea, PhotonsMissAsMuch) {
    // The reference method and the counted rays share no code: either would show the other's mistake.
    const int count = std::max(3, placeCount() / 10);
    for (int n = 0; n < count; ++n) {
        const ShadowPlace place = shadowPlace(5 * n + 2);
        const MissingLight missing = missingLight(place, "photons", option("count", std::int64_t{1'000'000}));
        if (!place.mesh_file.empty()) std::filesystem::remove(place.mesh_file);
        EXPECT_NEAR(missing.power / place.expected(), 1, 0.01) << place.describe();
    }
}

}  // namespace
}  // namespace photic
