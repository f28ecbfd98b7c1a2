// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "bake/scene/scene.h"

namespace photic {
namespace {

TEST(RefractiveIndices, EachFormGivesWhatItsMakerStates) {
    // Schott's constants of N-BK7: n_d = 1.5168, n_F = 1.52238, n_C = 1.51432, Abbe number 64.17.
    const auto bk7 =
        RefractiveIndex::sellmeier({1.03961212, 0.231792344, 1.01046945}, {0.00600069867, 0.0200179144, 103.560653});
    EXPECT_NEAR(bk7.at(RefractiveIndex::kD_nm), 1.51680, 5e-6);
    EXPECT_NEAR(bk7.at(RefractiveIndex::kF_nm), 1.52238, 5e-6);
    EXPECT_NEAR(bk7.at(RefractiveIndex::kC_nm), 1.51432, 5e-6);

    // Two terms through the same index and Abbe number stay within 2e-4 of the glass over the visible.
    const auto abbe = RefractiveIndex::abbe(1.5168, 64.17);
    EXPECT_NEAR(abbe.at(RefractiveIndex::kD_nm), 1.5168, 1e-12);
    EXPECT_NEAR((1.5168 - 1) / (abbe.at(RefractiveIndex::kF_nm) - abbe.at(RefractiveIndex::kC_nm)), 64.17, 1e-9);
    for (double nm = 440; nm <= 680; nm += 20) EXPECT_NEAR(abbe.at(nm), bk7.at(nm), 2e-4) << nm;
    EXPECT_FALSE(std::fabs(abbe.at(400) - bk7.at(400)) < 1e-6);

    const auto cauchy = RefractiveIndex::cauchy({1.5, 0.004, 0.0001});
    EXPECT_NEAR(cauchy.at(500), 1.5 + 0.004 / 0.25 + 0.0001 / 0.0625, 1e-12);
    EXPECT_EQ(RefractiveIndex(1.333).at(400), 1.333);
    EXPECT_FALSE(RefractiveIndex(1.333).disperses());
    EXPECT_TRUE(cauchy.disperses());
}

TEST(RefractiveIndices, ChannelsAreMetExactlyAndNeverOvershot) {
    const auto n = RefractiveIndex::channels({1.30, 1.34, 1.50});
    EXPECT_EQ(n.atChannels(), glm::dvec3(1.30, 1.34, 1.50));
    EXPECT_NEAR(n.mean(), 1.38, 1e-12);
    double before = 1.30;
    for (double nm = 780; nm >= 380; nm -= 5) {
        EXPECT_GE(n.at(nm), before);
        before = n.at(nm);
    }
    EXPECT_EQ(before, 1.50);
    EXPECT_FALSE(RefractiveIndex::channels({1.4, 1.4, 1.4}).disperses());
}

TEST(Lights, ASpotFadesOverItsBlend) {
    Light spot;
    EXPECT_EQ(spot.spotFalloff(-1), 1);  // a sun knows no cone
    spot.type = LightType::Spot, spot.cone_angle_deg = 90;
    const double rim = std::cos(M_PI / 4);
    EXPECT_EQ(spot.spotFalloff(rim - 1e-6), 0);
    EXPECT_EQ(spot.spotFalloff(rim + 1e-6), 1);
    spot.blend = 1;
    EXPECT_NEAR(spot.spotFalloff(1), 1, 1e-12);
    EXPECT_NEAR(spot.spotFalloff(0.5 * (1 + rim)), 0.5, 1e-12);
    spot.blend = 0.5;
    EXPECT_EQ(spot.spotFalloff(0.5 * (1 + rim)), 1);
    EXPECT_NEAR(spot.spotFalloff(rim + 0.125 * (1 - rim)), 3 / 16.0 - 2 / 64.0, 1e-12);
}

TEST(Media, ASideIsWhatIsNamedOrWhatTheIndicesSay) {
    Scene scene;
    scene.medium.absorption = glm::dvec3(1, 2, 3);
    Surface water;
    EXPECT_EQ(sideOf(scene, water, Side::Above).ior.at(550), 1.0);
    EXPECT_FALSE(sideOf(scene, water, Side::Above).present());
    EXPECT_EQ(sideOf(scene, water, Side::Below).ior.at(550), 1.333);
    EXPECT_EQ(sideOf(scene, water, Side::Below).absorption, glm::dvec3(1, 2, 3));
    water.event = SurfaceEvent::Mirror;
    EXPECT_FALSE(sideOf(scene, water, Side::Below).present());

    Medium wine;
    wine.name = "wine", wine.ior = RefractiveIndex::abbe(1.345, 55), wine.scattering = glm::dvec3(0.5),
    wine.priority = 2;
    scene.media.push_back(wine);
    water.medium_above = 0;
    const Medium above = sideOf(scene, water, Side::Above);
    EXPECT_EQ(above.name, "wine");
    EXPECT_EQ(above.scattering, glm::dvec3(0.5));
    EXPECT_EQ(above.priority, 2);
}

TEST(Media, ColourComesFromDispersionAndFromMirrorsToo) {
    Scene scene;
    EXPECT_FALSE(scene.coloured());
    scene.media.emplace_back();
    scene.surfaces.emplace_back();
    scene.surfaces[0].colour = {0.9, 0.6, 0.2};
    EXPECT_FALSE(scene.coloured());  // only a mirror has a colour
    scene.surfaces[0].event = SurfaceEvent::Mirror;
    EXPECT_TRUE(scene.coloured());
    scene.surfaces[0].colour = glm::dvec3(0.5);
    EXPECT_FALSE(scene.coloured());
    scene.media[0].ior = RefractiveIndex::abbe(1.5, 60);
    EXPECT_TRUE(scene.coloured());
}

}  // namespace
}  // namespace photic
