// SPDX-License-Identifier: Apache-2.0
#include "bake/optics/snell.h"

#include <gtest/gtest.h>

#include <numbers>

namespace photic {
namespace {

constexpr double kPi = std::numbers::pi;
const glm::dvec3 kUp{0, 0, 1};

glm::dvec3 downwards(double angle, double azimuth = 0.7) {
    return {std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth), -std::cos(angle)};
}

// Fresnel in its other textbook form, by angles alone.
double transmittanceByAngles(double angle_in, double angle_out) {
    const double s = std::sin(angle_in - angle_out) / std::sin(angle_in + angle_out);
    const double p = std::tan(angle_in - angle_out) / std::tan(angle_in + angle_out);
    return 1 - 0.5 * (s * s + p * p);
}

TEST(Snell, NormalIncidenceGoesStraightOn) {
    const Interface i = interfaceAt({0, 0, -1}, kUp, 1.0, 1.5);
    EXPECT_NEAR(i.transmittance, 0.96, 1e-15);
    EXPECT_NEAR(glm::distance(i.refracted, glm::dvec3(0, 0, -1)), 0, 1e-15);
    EXPECT_NEAR(glm::distance(i.reflected, glm::dvec3(0, 0, 1)), 0, 1e-15);
}

TEST(Snell, SweepFromTheThinSide) {
    for (int k = 1; k <= 8999; ++k) {
        const double angle = k * 0.01 * kPi / 180;
        const glm::dvec3 d = downwards(angle);
        const Interface i = interfaceAt(d, kUp, 1.0, 1.333);
        const double angle_out = std::asin(std::sin(angle) / 1.333);
        EXPECT_NEAR(glm::length(i.refracted), 1, 1e-12);
        EXPECT_NEAR(glm::length(i.reflected), 1, 1e-12);
        EXPECT_NEAR(1.333 * glm::length(glm::cross(i.refracted, kUp)), std::sin(angle), 1e-12);
        EXPECT_NEAR(glm::dot(i.refracted, glm::cross(d, kUp)), 0, 1e-12) << "leaves the plane of incidence";
        EXPECT_NEAR(i.reflected.z, -d.z, 1e-12);
        EXPECT_NEAR(i.transmittance, transmittanceByAngles(angle, angle_out), 1e-12) << k;
        EXPECT_GE(i.transmittance, 0);
        EXPECT_LE(i.transmittance, 1);
    }
}

TEST(Snell, GrazingLightIsReflectedWhole) {
    const Interface i = interfaceAt({1, 0, 0}, kUp, 1.0, 1.333);
    EXPECT_NEAR(i.transmittance, 0, 1e-12);
    EXPECT_NEAR(glm::distance(i.reflected, glm::dvec3(1, 0, 0)), 0, 1e-12);
}

TEST(Snell, SweepFromTheDenseSideReachesTotalReflection) {
    const double critical = std::asin(1 / 1.333);
    int total = 0;
    for (int k = 1; k <= 9000; ++k) {
        const double angle = k * 0.01 * kPi / 180;
        const Interface i = interfaceAt(downwards(angle), kUp, 1.333, 1.0);
        EXPECT_NEAR(i.reflected.z, std::cos(angle), 1e-12);
        if (angle > critical) {
            ++total;
            EXPECT_EQ(i.transmittance, 0);
            EXPECT_EQ(i.refracted, glm::dvec3(0));
        } else {
            const double angle_out = std::asin(1.333 * std::sin(angle));
            // Near the critical angle asin loses half of the digits of the oracle, not of the code under test.
            const double tolerance = angle > critical - 1e-3 ? 1e-7 : 1e-12;
            EXPECT_NEAR(i.transmittance, transmittanceByAngles(angle, angle_out), tolerance) << k;
        }
    }
    EXPECT_NEAR(total, 9000 - critical * 180 / kPi * 100, 1);
}

TEST(Snell, BothSidesTransmitAlike) {
    for (double angle = 0.01; angle < 1.57; angle += 0.01) {
        const Interface in = interfaceAt(downwards(angle), kUp, 1.0, 1.333);
        const Interface out = interfaceAt(in.refracted, kUp, 1.333, 1.0);
        EXPECT_NEAR(in.transmittance, out.transmittance, 1e-12);
        EXPECT_NEAR(glm::distance(out.refracted, downwards(angle)), 0, 1e-10)
            << "the path is not reversible at " << angle;
    }
}

TEST(Snell, BrewsterReflectsOnlyOnePolarisation) {
    const double n = 1.333, brewster = std::atan(n);
    const double r_s = (std::cos(brewster) - n * std::sin(brewster)) / (std::cos(brewster) + n * std::sin(brewster));
    // cos t = sin i there, and R_p is 0: half of R_s is all that is lost.
    EXPECT_NEAR(interfaceAt(downwards(brewster), kUp, 1.0, n).transmittance, 1 - 0.5 * r_s * r_s, 1e-14);
    // Only there: a degree away the p part comes back.
    const double off = brewster + kPi / 180, t = std::asin(std::sin(off) / n);
    EXPECT_GT(std::pow(std::tan(off - t) / std::tan(off + t), 2), 1e-5);
}

TEST(Snell, PowerIsConserved) {
    // R from the reflected amplitude, T from the transmitted one with the change of speed and of width: R + T = 1.
    const double n1 = 1.0, n2 = 1.333;
    for (double angle = 0; angle < 1.57; angle += 0.001) {
        const double ci = std::cos(angle), ct = std::sqrt(1 - std::pow(n1 / n2 * std::sin(angle), 2));
        const double t_s = 2 * n1 * ci / (n1 * ci + n2 * ct), t_p = 2 * n1 * ci / (n2 * ci + n1 * ct);
        const double transmitted = n2 * ct / (n1 * ci) * 0.5 * (t_s * t_s + t_p * t_p);
        EXPECT_NEAR(interfaceAt(downwards(angle), kUp, n1, n2).transmittance, transmitted, 1e-12);
    }
}

TEST(Snell, EqualIndicesChangeNothing) {
    const glm::dvec3 d = downwards(1.2);
    const Interface i = interfaceAt(d, kUp, 1.3, 1.3);
    EXPECT_NEAR(i.transmittance, 1, 1e-15);
    EXPECT_NEAR(glm::distance(i.refracted, d), 0, 1e-14);
}

}  // namespace
}  // namespace photic
