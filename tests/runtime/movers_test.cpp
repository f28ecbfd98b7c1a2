// SPDX-License-Identifier: Apache-2.0
// Shadows of what moves: the share of a cone that shapes and maps cover, against rays.
#include "photic/movers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <optional>
#include <random>

namespace photic::runtime {
namespace {

Vec3 vec(const glm::dvec3& v) { return {v.x, v.y, v.z}; }
glm::dvec3 glmOf(const Vec3& v) { return {v.x, v.y, v.z}; }

/// Where a ray is inside of a shape.
std::optional<std::pair<double, double>> crossing(const Mover& mover, const glm::dvec3& from, const glm::dvec3& way) {
    const glm::dvec3 to = from - glmOf(mover.centre);
    if (mover.shape == MoverShape::Sphere) {
        const double a = glm::dot(way, way), b = glm::dot(to, way);
        const double inside = b * b - a * (glm::dot(to, to) - mover.radius * mover.radius);
        if (inside <= 0) return {};
        return std::pair{(-b - std::sqrt(inside)) / a, (-b + std::sqrt(inside)) / a};
    }
    const glm::dmat3 to_box =
        glm::inverse(glm::dmat3(glmOf(mover.half_axes[0]), glmOf(mover.half_axes[1]), glmOf(mover.half_axes[2])));
    const glm::dvec3 start = to_box * to, rate = to_box * way;
    double first = -1e30, last = 1e30;
    for (int a = 0; a < 3; ++a) {
        const double s = (-1 - start[a]) / rate[a], t = (1 - start[a]) / rate[a];
        first = std::max(first, std::min(s, t)), last = std::min(last, std::max(s, t));
    }
    if (first >= last) return {};
    return std::pair{first, last};
}

/// Share of a cone's rays that meet the shape between two distances.
double byRays(const Mover& mover, const glm::dvec3& from, const glm::dvec3& axis, double tangent, double near,
              double far) {
    const glm::dvec3 u =
        glm::normalize(glm::cross(axis, std::fabs(axis.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0)));
    const glm::dvec3 v = glm::cross(axis, u);
    constexpr int kRays = 20000;
    int met = 0;
    for (int i = 0; i < kRays; ++i) {
        const double r = tangent * std::sqrt((i + 0.5) / kRays), turn = 2.399963229728653 * i;
        const auto in = crossing(mover, from, axis + r * (std::cos(turn) * u + std::sin(turn) * v));
        met += in && in->second > near && in->first < far;
    }
    return static_cast<double>(met) / kRays;
}

/// Movers under light that comes as a cone of this half angle.
Movers underCone(double tangent) {
    Movers movers;
    movers.angular_diameter_deg = 2 * std::atan(tangent) * 180 / std::numbers::pi;
    movers.spread = 0;
    movers.bias = 0.01;
    return movers;
}

class Random {
public:
    double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
    glm::dvec3 place(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }

private:
    std::mt19937 engine_{14};
};

Mover anyMover(Random& random, bool is_box, const glm::dvec3& near_to) {
    const glm::dvec3 centre = near_to + random.place(0.8);
    if (!is_box) return sphere(vec(centre), random.in(0.05, 0.7));
    const glm::dvec3 x = glm::normalize(random.place(1)), y = glm::normalize(glm::cross(x, random.place(1)));
    return box(vec(centre), vec(random.in(0.05, 0.5) * x), vec(random.in(0.05, 0.5) * y),
               vec(random.in(0.05, 0.5) * glm::cross(x, y)));
}

/// Where a mover leaves its own lit side lit, rays are no judge.
bool onSkin(const Mover& mover, const glm::dvec3& at) {
    const glm::dvec3 from = at - glmOf(mover.centre);
    double out_by = glm::length(from) / std::max(mover.radius, 1e-9);
    if (mover.shape == MoverShape::Box) {
        out_by = 0;
        for (const Vec3& half : mover.half_axes)
            out_by = std::max(out_by, std::fabs(glm::dot(from, glmOf(half))) / glm::dot(glmOf(half), glmOf(half)));
    }
    return out_by > 0.9 && out_by < 1.02;
}

TEST(Movers, CoverWhatRaysFind) {
    Random random;
    int partly = 0;
    for (int n = 0; n < 900; ++n) {
        const double tangent = n % 3 == 0 ? 0.005 : random.in(0.05, 0.5);
        Movers movers = underCone(tangent);
        const glm::dvec3 axis = glm::normalize(random.place(1)), from = random.place(3);
        movers.reach = random.in(0.5, 3);
        const Mover mover = anyMover(random, n % 2 == 0, from + random.in(-0.3, 2.5) * axis);
        movers.shapes = {mover};
        if (onSkin(mover, from)) continue;
        const double passes = passesMovers(movers, vec(from), vec(-axis), 1);
        const double truth = 1 - byRays(mover, from, axis, tangent, movers.bias, movers.reach);
        // A sphere that an end of the cone cuts is taken for its widest cut.
        const double z = glm::dot(glmOf(mover.centre) - from, axis);
        const bool cut =
            mover.shape == MoverShape::Sphere && (z - mover.radius < movers.bias || z + mover.radius > movers.reach);
        // A cone sees a sphere a little wider than its middle.
        const double allowed = cut                                 ? 0.35
                               : mover.shape == MoverShape::Sphere ? 0.01 + tangent * mover.radius / z
                                                                   : 0.01;
        ASSERT_NEAR(passes, truth, allowed) << n << (mover.shape == MoverShape::Box ? " box" : " sphere");
        partly += truth > 0.02 && truth < 0.98;
    }
    EXPECT_GT(partly, 100);
}

TEST(Movers, TheirOwnLitSideStaysLit) {
    Movers movers = underCone(0.005);
    movers.bias = 1e-3;
    movers.shapes = {sphere({0, 0, 0}, 0.3)};
    const glm::dvec3 down = glm::normalize(glm::dvec3(0.3, 0.1, -1));
    for (int n = 0; n < 200; ++n) {
        const double turn = 0.1 * n, height = -0.95 + 1.9 * n / 200.0, round = std::sqrt(1 - height * height);
        const glm::dvec3 normal(round * std::cos(turn), round * std::sin(turn), height);
        const double faces = -glm::dot(normal, down);
        const double passes = passesMovers(movers, vec(0.3 * normal), vec(down), 1);
        if (faces > 0.06) {
            EXPECT_EQ(passes, 1) << faces;
        }
        if (faces < -0.06) {
            EXPECT_EQ(passes, 0) << faces;
        }
        // As drawn by triangles whose middles lie inside.
        if (faces > 0.06) {
            EXPECT_EQ(passesMovers(movers, vec(0.295 * normal), vec(down), 1), 1) << faces;
        }
    }
    movers.shapes = {box({0, 0, 0}, {0.2, 0, 0}, {0, 0.3, 0}, {0, 0, 0.1})};
    EXPECT_EQ(passesMovers(movers, {0.1, 0.1, 0.1}, vec(down), 1), 1);    // on top of it
    EXPECT_EQ(passesMovers(movers, {0.1, 0.1, 0.098}, vec(down), 1), 1);  // a little inside of that
    EXPECT_EQ(passesMovers(movers, {0.1, 0.1, -0.1}, vec(down), 1), 0);   // below
    EXPECT_EQ(passesMovers(movers, {0, 0, 0}, vec(down), 1), 0);          // inside
    EXPECT_EQ(passesMovers(movers, {0.5, 0.1, -0.1}, vec(down), 1), 1);   // beside
}

// What floats above the surface is met along the sun's own direction, not along that of the light below.
TEST(Movers, AboveTheSurfaceLightIsTheSuns) {
    Movers movers;
    movers.surface[3] = 0;
    movers.ior = 1.33;
    movers.shapes = {sphere({0, 0, 1}, 0.1)};
    const Vec3 below = {0, 0, -1};
    const glm::dvec3 sun = glm::normalize(glm::dvec3(0.5, 0, -1));
    EXPECT_EQ(passesMovers(movers, {0, 0, -1}, below, 1), 1);  // nothing is known of the light up there
    movers.sun = vec(3.0 * sun);
    EXPECT_EQ(passesMovers(movers, {0, 0, -1}, below, 1), 1);    // the shadow falls elsewhere:
    EXPECT_EQ(passesMovers(movers, {0.5, 0, -1}, below, 1), 0);  // there
    EXPECT_EQ(passesMovers(movers, {0.5, 0.2, -1}, below, 1), 1);
    // Its edge is as wide as the disc makes it: half of it is covered where the middle of the sun just is.
    const double at = 0.5 + 0.1 / std::cos(std::atan(0.5));
    EXPECT_NEAR(passesMovers(movers, {at, 0, -1}, below, 1), 0.5, 0.05);
    movers.shapes = {sphere({0, 0, -0.5}, 0.1)};
    EXPECT_EQ(passesMovers(movers, {0, 0, -1}, below, 1), 0);
}

// A map of boxes darkens as the boxes do.
TEST(Movers, AMapDarkensAsTheShapesOnIt) {
    Random random;
    Movers shapes = underCone(0.02);
    const glm::dvec3 down = glm::normalize(glm::dvec3(0.4, 0.2, -1));
    for (int n = 0; n < 4; ++n) shapes.shapes.push_back(anyMover(random, n % 2 == 0, {0, 0, 0}));
    Movers mapped = shapes;
    mapped.shapes.clear();
    const glm::dvec3 u = glm::normalize(glm::cross(down, {0, 1, 0})), v = glm::cross(down, u);
    constexpr int kSide = 400;
    constexpr double kHalf = 2;  // [m]
    MoverMap& map = mapped.map;
    map.direction = vec(down), map.across = vec(2 * kHalf * u), map.up = vec(2 * kHalf * v);
    map.corner = vec(-kHalf * u - kHalf * v), map.columns = map.rows = kSide;
    map.nearest = -kHalf, map.farthest = kHalf;
    std::vector<float> depths(2 * kSide * kSide, -1e9F);
    for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) {
            const glm::dvec3 from = kHalf * ((2 * i + 1.0) / kSide - 1) * u + kHalf * ((2 * j + 1.0) / kSide - 1) * v;
            for (const Mover& mover : shapes.shapes) {
                const auto in = crossing(mover, from, down);
                float* at = depths.data() + 2 * (static_cast<std::size_t>(j) * kSide + static_cast<std::size_t>(i));
                if (in) at[0] = std::max(at[0], float(-in->first)), at[1] = std::max(at[1], float(in->second));
            }
        }
    }
    map.depths = depths.data();
    mapped.map_steps = 48;
    double apart = 0, dark = 0;
    for (int n = 0; n < 2000; ++n) {
        const glm::dvec3 at = glm::dvec3(random.in(-1, 1), random.in(-1, 1), 0) + 1.4 * down;
        // Light that comes from elsewhere than the map was drawn.
        const glm::dvec3 flux = glm::normalize(down + 0.1 * random.place(1));
        const double a = passesMovers(shapes, vec(at), vec(flux), 1), b = passesMovers(mapped, vec(at), vec(flux), 1);
        apart += std::fabs(a - b), dark += 1 - a;
    }
    EXPECT_GT(dark, 200);
    EXPECT_LT(apart / dark, 0.05);
}

TEST(Movers, LightFromManySidesWashesShadowsOut) {
    Movers movers;
    movers.shapes = {sphere({0, 0, 1}, 0.1)};
    EXPECT_EQ(passesMovers(movers, {0, 0, 0}, {0, 0, -1}, 1), 0);
    const double washed = passesMovers(movers, {0, 0, 0}, {0, 0, -0.95}, 1);
    EXPECT_GT(washed, 0.5);
    // The cone of which 0.951 is the mean cosine: cos a = 0.902.
    EXPECT_NEAR(washed, 1 - 0.01 / std::pow(std::tan(std::acos(0.902)), 2), 0.01);
    movers.spread = 0;
    EXPECT_EQ(passesMovers(movers, {0, 0, 0}, {0, 0, -0.95}, 1), 0);
}

TEST(Movers, NonsenseIsRefused) {
    const auto refused = [](Movers movers, const char* word) {
        const auto packed = packMovers(movers);
        ASSERT_FALSE(packed.ok()) << word;
        EXPECT_EQ(packed.error().code, ErrorCode::Usage);
        EXPECT_NE(packed.error().message.find(word), std::string::npos) << packed.error().message;
    };
    Movers movers;
    movers.shapes.assign(33, sphere({0, 0, 0}, 1));
    refused(movers, "33 movers");
    movers.shapes = {sphere({0, 0, 0}, -1)};
    refused(movers, "mover 0");
    movers.shapes = {sphere({0, 0, std::nan("")}, 1)};
    refused(movers, "mover 0");
    movers.shapes.clear(), movers.spread = 2;
    refused(movers, "spread");
    movers.spread = 1, movers.map.columns = movers.map.rows = 4;
    refused(movers, "map");
    EXPECT_TRUE(packMovers(Movers()).ok());
    // Places that are no places are as lit as they are.
    Movers one;
    one.shapes = {sphere({0, 0, 1}, 0.1)};
    EXPECT_EQ(passesMovers(one, {0, 0, 0}, {0, 0, 0}, 0), 1);
    EXPECT_EQ(passesMovers(one, {0, 0, 0}, {std::nan(""), 0, 0}, 1), 1);
}

}  // namespace
}  // namespace photic::runtime
