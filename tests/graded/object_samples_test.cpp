// SPDX-License-Identifier: Apache-2.0
// What games get of a graded object: its index, where its faces are, and what it does to light.
#include "bake/graded/object_samples.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "bake/graded/spline_index.h"
#include "bake/report/error.h"
#include "bake/scene/graded_index.h"

namespace photic {
namespace {

GradedObject objectOf(std::shared_ptr<const GradedIndex> index) {
    GradedObject object;
    object.name = "object";
    object.index = {std::move(index)};
    return object;
}

ObjectSamples sampled(const GradedObject& object, double voxel = 1.0 / 32) {
    Monitor monitor;
    return sampleObject({object}, 0, {voxel, {glm::dvec3(-1), glm::dvec3(1)}}, monitor);
}

/// The spline that was written, at a place in the world.
double excessAt(const ObjectSamples& s, const glm::dvec3& world) {
    const glm::dvec3 node = glm::inverse(s.world_from_node) * (world - s.origin_world);
    const glm::ivec3 cell(glm::floor(node));
    const CubicWeights w[3] = {cubicBSpline(node.x - cell.x), cubicBSpline(node.y - cell.y),
                               cubicBSpline(node.z - cell.z)};
    double sum = 0;
    for (int i = 0; i < 64; ++i) {
        const glm::ivec3 d(i & 3, i >> 2 & 3, i >> 4), p = cell - 1 + d;
        sum +=
            w[0].value[d.x] * w[1].value[d.y] * w[2].value[d.z] *
            double(s.spline[0][(std::size_t(p.z) * std::size_t(s.count.y) + std::size_t(p.y)) * std::size_t(s.count.x) +
                               std::size_t(p.x)]);
    }
    return sum;
}

int facesAt(const ObjectSamples& s, const glm::dvec3& world) {
    if (s.faces.empty()) return 0;
    const glm::ivec3 p(glm::round(glm::inverse(s.world_from_node) * (world - s.origin_world)));
    return s.faces[(std::size_t(p.z) * std::size_t(s.count.y) + std::size_t(p.y)) * std::size_t(s.count.x) +
                   std::size_t(p.x)];
}

TEST(ObjectSamples, ALensWithoutFacesHasNone) {
    const auto lens = makeLuneburgLens({0.1, 0, 0}, 0.8);
    const ObjectSamples s = sampled(objectOf(lens));
    EXPECT_EQ(s.fit, SplineFit::Through);
    EXPECT_TRUE(s.faces.empty());
    EXPECT_FALSE(s.sharp_sides);
    EXPECT_TRUE(s.attenuation.empty() && s.glow.empty());
    for (const glm::dvec3 p : {glm::dvec3(0.1, 0, 0), {0.3, 0.2, -0.1}, {0.1, 0.5, 0.2}, {-0.2, 0.1, 0.4}})
        EXPECT_NEAR(excessAt(s, p), lens->at(p).half_square - 0.5, 2e-6);
    EXPECT_EQ(excessAt(s, {0.83, 0.73, 0.73}), 0) << "far from the lens there is nothing, to the last bit";
    EXPECT_NEAR(excessAt(s, {0.1, 0.87, 0}), 0, 2e-4) << "beside its rim a little, since that is a kink";
}

TEST(ObjectSamples, WhatIsPaintedOnABodyIsOnItsFace) {
    // Half of a ball is painted; samples outside of it hold none.
    GradedObject ball = objectOf(makeFishEye({0, 0, 0}, 1.5, 8, 0.75));
    EXPECT_TRUE(sampled(ball).coat.empty());
    MediumVolume::Samples paint;
    paint.world_from_index = glm::dmat3(1.0 / 32), paint.origin_world = glm::dvec3(-1), paint.size = glm::ivec3(65);
    for (int z = 0; z < 65; ++z)
        for (int y = 0; y < 65; ++y)
            for (int x = 0; x < 65; ++x) {
                const glm::dvec3 p = glm::dvec3(x, y, z) / 32.0 - 1.0;
                paint.values.push_back(glm::length(p) < 0.75 && p.x > 0 ? glm::vec3(0.25f, 0.5f, 1) : glm::vec3(0));
            }
    ball.face.albedo_volume = std::make_shared<const MediumVolume>(paint);
    const ObjectSamples s = sampled(ball);
    ASSERT_EQ(s.coat.size(), s.faces.size());
    const auto at = [&](const glm::dvec3& world) {
        const glm::ivec3 p(glm::round(glm::inverse(s.world_from_node) * (world - s.origin_world)));
        return s.coat[(std::size_t(p.z) * std::size_t(s.count.y) + std::size_t(p.y)) * std::size_t(s.count.x) +
                      std::size_t(p.x)];
    };
    for (int i = 0; i < 50; ++i) {
        const double phi = 0.7 * i, z = -0.98 + 0.04 * i;
        const glm::dvec3 n(std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z);
        if (std::fabs(n.x) < 0.15) continue;
        EXPECT_EQ(at(0.75 * n).y, n.x > 0 ? 0.5f : 0.0f) << i;
    }
    EXPECT_TRUE(sampled(objectOf(makeLuneburgLens({0, 0, 0}, 0.8))).coat.empty()) << "a lens without faces has no coat";
}

/// n^2 falls from 1.44 to 1 as a Gaussian's integral does.
class SoftBall final : public GradedIndex {
public:
    static constexpr double kRadius = 0.6;
    explicit SoftBall(double sigma) : sigma_(sigma) {}
    IndexSample at(const glm::dvec3& p) const override {
        const double r = glm::length(p), t = (r - kRadius) / (sigma_ * std::sqrt(2.0));
        IndexSample out;
        out.half_square = 0.5 + 0.11 * std::erfc(t);
        if (r > 0) out.gradient = (-0.22 * std::exp(-t * t) / (sigma_ * std::sqrt(2 * M_PI)) / r) * p;
        return out;
    }
    bool contains(const glm::dvec3& p) const override { return glm::length(p) < kRadius + 4 * sigma_; }
    std::optional<WorldBox> bounds() const override {
        return WorldBox{glm::dvec3(-kRadius - 4 * sigma_), glm::dvec3(kRadius + 4 * sigma_)};
    }

private:
    double sigma_;
};

// What of a wide face lay outside of its nodes would bend rays a second time: a ghost around the body.
TEST(ObjectSamples, AWideFaceIsKnownInAllOfItsWidth) {
    constexpr double kNode = 1.0 / 32;
    const ObjectSamples wide = sampled(objectOf(std::make_shared<SoftBall>(1.7 * kNode)), kNode);
    const ObjectSamples narrow = sampled(objectOf(std::make_shared<SoftBall>(0.8 * kNode)), kNode);
    for (int i = 0; i < 50; ++i) {
        const double phi = 0.7 * i, z = -0.98 + 0.04 * i;
        const glm::dvec3 n(std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z);
        for (const double nodes : {-3.0, 0.0, 3.0})
            EXPECT_EQ(facesAt(wide, (SoftBall::kRadius + nodes * kNode) * n), 255) << i << ", " << nodes;
        for (const double nodes : {-8.0, 8.0})
            EXPECT_EQ(facesAt(wide, (SoftBall::kRadius + nodes * kNode) * n), 0) << i << ", " << nodes;
        EXPECT_EQ(facesAt(narrow, SoftBall::kRadius * n), 255) << i;
        for (const double nodes : {-5.0, 5.0})
            EXPECT_EQ(facesAt(narrow, (SoftBall::kRadius + nodes * kNode) * n), 0) << i << ", " << nodes;
    }
}

TEST(ObjectSamples, ABallOfGlassHasAFaceAllAround) {
    // n falls by a percent to the rim, and there to 1.
    GradedObject ball = objectOf(makeFishEye({0, 0, 0}, 1.5, 8, 0.75));
    ball.absorption = {1, 2, 3}, ball.scattering = glm::dvec3(0.5), ball.anisotropy = 0.25, ball.emission = {4, 0, 0};
    const ObjectSamples s = sampled(ball);
    for (int i = 0; i < 50; ++i) {
        const double phi = 0.7 * i, z = -0.98 + 0.04 * i;
        const glm::dvec3 n(std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z);
        EXPECT_EQ(facesAt(s, 0.75 * n), 255) << i;
        EXPECT_EQ(facesAt(s, 0.5 * n), 0) << i;
        EXPECT_EQ(facesAt(s, 0.9 * n), 0) << i;
    }
    double volume = 0, absorbed = 0;
    for (const glm::vec4& v : s.attenuation) volume += double(v.w), absorbed += double(v.y);
    const double truth = 4.0 / 3 * 3.14159265 * std::pow(0.75 * 32, 3);
    EXPECT_NEAR(volume / truth, 1, 2e-3) << "a rim's nodes have a part of the object";
    EXPECT_NEAR(absorbed / truth, 2, 4e-3);
    ASSERT_EQ(s.glow.size(), s.attenuation.size());
    EXPECT_EQ(s.glow[s.glow.size() / 2], glm::vec4(4, 0, 0, 0.25));
}

TEST(ObjectSamples, WhatShinesAndHowItScattersMayVary) {
    // Both grow along x.
    const auto ramp = [](float least, float step) {
        MediumVolume::Samples samples;
        samples.size = {9, 9, 9}, samples.origin_world = glm::dvec3(-1), samples.world_from_index = glm::dmat3(0.25);
        for (int i = 0; i < 9 * 9 * 9; ++i) samples.values.emplace_back(least + step * float(i % 9));
        return std::make_shared<const MediumVolume>(std::move(samples));
    };
    GradedObject ball = objectOf(makeFishEye({0, 0, 0}, 1.5, 8, 0.75));
    ball.scattering = glm::dvec3(0.5), ball.anisotropy_volume = ramp(-0.8f, 0.2f);
    const auto glowAt = [](const ObjectSamples& s, const glm::dvec3& p) {
        const glm::ivec3 node(glm::round(glm::inverse(s.world_from_node) * (p - s.origin_world)));
        return s.glow.at((static_cast<std::size_t>(node.z) * static_cast<std::size_t>(s.count.y) +
                          static_cast<std::size_t>(node.y)) *
                             static_cast<std::size_t>(s.count.x) +
                         static_cast<std::size_t>(node.x));
    };
    const glm::vec4 dark = glowAt(sampled(ball), {0.5, 0, 0});
    EXPECT_NEAR(dark.w, 0.4, 2e-3);
    EXPECT_EQ(dark.x, 0);
    ball.emission_volume = ramp(0, 1);
    const glm::vec4 bright = glowAt(sampled(ball), {-0.5, 0, 0});
    EXPECT_NEAR(bright.y, 2, 0.02);
    EXPECT_NEAR(bright.w, -0.4, 4e-3);
}

TEST(ObjectSamples, ABlockKeepsItsSharpSides) {
    const WorldBox box{{-0.5, -0.4, -0.3}, {0.45, 0.4, 0.31}};
    const auto block = makeLinearSquare({0, 0, 0}, 1.5, {0, 0, -0.7}, box);
    const ObjectSamples s = sampled(objectOf(block));
    EXPECT_TRUE(s.sharp_sides);
    EXPECT_TRUE(s.faces.empty());
    for (int corner = 0; corner < 2; ++corner) {
        const glm::dvec3 node(corner ? s.box_high : s.box_low);
        const glm::dvec3 p = s.origin_world + s.world_from_node * node, wanted = corner ? box.max : box.min;
        EXPECT_LT(glm::distance(p, wanted), 1e-6);
    }
    // Up to the very sides.
    for (const glm::dvec3 p : {glm::dvec3(0, 0, 0.309), {0.44, 0.39, -0.299}, {-0.499, 0, 0}})
        EXPECT_NEAR(excessAt(s, p), block->at(p).half_square - 0.5, 1e-6);
}

TEST(ObjectSamples, FaintAirKeepsItsDigits) {
    const auto air = makeHotAir({0, 0.1, 1.000277, 2e-5}, {});
    const ObjectSamples s = sampled(objectOf(air), 1.0 / 64);
    for (const double z : {0.15, 0.2, 0.33, 0.6}) {
        const glm::dvec3 p(0.1, 0.2, z);
        // The whole difference is 2e-5; single precision around 1/2 would leave 3e-8.
        EXPECT_NEAR(excessAt(s, p), air->at(p).half_square - 0.5, 2e-9 + 2e-5 * 4e-3 * std::exp(-z / 0.1)) << z;
    }
}

TEST(ObjectSamples, AnEarlierObjectIsThereInstead) {
    Monitor monitor;
    const std::vector<GradedObject> both{objectOf(makeFishEye({0.3, 0, 0}, 1.4, 8, 0.3)),
                                         objectOf(makeFishEye({0, 0, 0}, 1.6, 8, 0.5))};
    const ObjectSamples s = sampleObject(both, 1, {1.0 / 32, {}}, monitor);
    EXPECT_NEAR(excessAt(s, {0.35, 0, 0}), 0, 1e-6);
    EXPECT_NEAR(excessAt(s, {-0.25, 0, 0}), (1.6 * 1.6 - 1) / 2, 0.01);
}

TEST(ObjectSamples, RefusesTooManyNodes) {
    Monitor monitor;
    try {
        sampleObject({objectOf(makeLuneburgLens({0, 0, 0}, 1))}, 0, {1e-4, {}}, monitor);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("larger voxels"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace photic
