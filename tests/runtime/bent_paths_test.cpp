// SPDX-License-Identifier: Apache-2.0
// Curved eye rays against closed forms: where rays leave Luneburg's lens, the fish-eye and a ball, and their pictures.
#include "tests/runtime/bent_fixture.h"

namespace photic::test {
namespace {

/// Root mean square angle between what left the lens and what should have, and the pictures' difference.
struct Misses {
    double rms_degrees = 0, image_rmse = 0;
    int rays = 0;
};
template <class Truth>
Misses missesOf(const std::vector<float>& pixels, const Eye& eye, const Truth& truth) {
    Misses out;
    double squares = 0, error = 0, size = 0;
    for (int y = 0; y < eye.height; ++y)
        for (int x = 0; x < eye.width; ++x) {
            const float* pixel = &pixels[4 * std::size_t(y * eye.width + x)];
            const auto wanted = truth(eye.direction(x, y));
            if (!wanted) continue;
            EXPECT_GE(pixel[0], 0) << x << " " << y;
            const double angle = std::acos(std::clamp(glm::dot(*wanted, directionOf(pixel)), -1.0, 1.0)) / kDegree;
            squares += angle * angle, ++out.rays;
            for (int c = 0; c < 3; ++c) {
                const double t = 0.5 * (*wanted)[c] + 0.5, d = double(pixel[c]) - t;
                error += d * d, size += t * t;
            }
        }
    out.rms_degrees = std::sqrt(squares / out.rays), out.image_rmse = std::sqrt(error / size);
    return out;
}

/// Distance of a ray from the origin.
double passesAt(const glm::dvec3& from, const glm::dvec3& d) { return glm::length(from - glm::dot(from, d) * d); }

/// Follows a ray through n^2 / 2 in double, by steps far shorter than needed. @return its direction outside
template <class Index>
glm::dvec3 followed(const Index& index, glm::dvec3 place, const glm::dvec3& direction, double step, double radius) {
    glm::dvec3 p = direction;
    for (int i = 0; i < 200000; ++i) {
        place += 0.5 * step * p;
        p += step * index(place);
        place += 0.5 * step * p;
        if (glm::length(place) > radius && glm::dot(place, p) > 0) break;
    }
    return glm::normalize(p);
}

// n^2 = 2 - r^2 / R^2: within, x = x0 cos(s / R) + R p0 sin(s / R).
std::optional<glm::dvec3> throughLuneburg(double radius, const glm::dvec3& eye, const glm::dvec3& d, double rim) {
    if (passesAt(eye, d) > rim * radius) return {};
    const double b = glm::dot(eye, d);
    const glm::dvec3 x0 = eye + (-b - std::sqrt(b * b - glm::dot(eye, eye) + radius * radius)) * d;
    // |x|^2 = R^2 (1 + 2 (x0 . p0 / R) sin cos): it leaves at s = pi R / 2, where p = -x0 / R.
    return glm::normalize(-x0 / radius);
}

TEST_F(BentRays, LuneburgsLensSendsRaysWhereItsFormulaSays) {
    const double radius = 0.8;
    const Eye eye = eyeAt({2.0, 0.3, 0.2}, 40);
    const DirectionMap directions(gl_);
    const auto lens = exported(objectOf(makeLuneburgLens({0, 0, 0}, radius)), radius / 48);
    const auto pixels = seen({lens}, eye, around(directions));
    const Misses m =
        missesOf(pixels, eye, [&](const glm::dvec3& d) { return throughLuneburg(radius, eye.position, d, 0.97); });
    EXPECT_GT(m.rays, 1500);
    EXPECT_LT(m.rms_degrees, 0.1);
    EXPECT_LT(m.image_rmse, 0.01);
    std::printf("Luneburg: %.4f degrees rms, image %.5f\n", m.rms_degrees, m.image_rmse);
}

TEST_F(BentRays, TheFishEyesRaysAreCircles) {
    // n = 2 / (1 + r^2 / a^2), cut where n is 1: no face. Rays are circles: the exit is where the formula has it.
    const double a = 0.7;
    const Eye eye = eyeAt({1.9, -0.4, 0.1}, 40);
    const DirectionMap directions(gl_);
    const auto lens = exported(objectOf(makeFishEye({0, 0, 0}, 2, a, a)), a / 48);
    const auto pixels = seen({lens}, eye, around(directions));
    const auto truth = [&](const glm::dvec3& d) -> std::optional<glm::dvec3> {
        if (passesAt(eye.position, d) > 0.96 * a) return {};
        const double b = glm::dot(eye.position, d);
        const glm::dvec3 x = eye.position + (-b - std::sqrt(b * b - glm::dot(eye.position, eye.position) + a * a)) * d;
        // Every ray from x goes through -a^2 x / |x|^2 = -x, which lies on the rim too; the circle through both has the
        // tangent d at x, and at its other end the one mirrored by the chord.
        const glm::dvec3 chord = glm::normalize(-2.0 * x);
        return glm::normalize(2.0 * glm::dot(d, chord) * chord - d);
    };
    const Misses m = missesOf(pixels, eye, truth);
    EXPECT_GT(m.rays, 1500);
    EXPECT_LT(m.rms_degrees, 0.1);
    EXPECT_LT(m.image_rmse, 0.01);
    std::printf("fish-eye: %.4f degrees rms, image %.5f\n", m.rms_degrees, m.image_rmse);
}

TEST_F(BentRays, ABallLensBendsByTwiceTheDifferenceOfItsAngles) {
    // Without faces: what is reflected would mix into the colours.
    const double n = 1.5, radius = 0.6;
    const Eye eye = eyeAt({1.7, 0.2, -0.3}, 42, 40);
    const DirectionMap directions(gl_);
    const auto truth = [&](const glm::dvec3& d) -> std::optional<glm::dvec3> {
        const double b = passesAt(eye.position, d);
        if (b > 0.8 * radius) return {};
        const double bend = 2 * (std::asin(b / radius) - std::asin(b / radius / n));
        const glm::dvec3 across = glm::normalize(-(eye.position - glm::dot(eye.position, d) * d));
        return std::cos(bend) * d + std::sin(bend) * across;
    };
    // A face of some nodes bends at other places than a sharp one; that goes with its width over the radius.
    double last = 1e9;
    for (const int nodes : {16, 32, 64}) {
        auto lens = ball(n, radius, radius / nodes, 1.5);
        lens.faces.clear();
        const Misses m = missesOf(seen({lens}, eye, around(directions)), eye, truth);
        EXPECT_GT(m.rays, 400);
        EXPECT_LT(m.rms_degrees, 0.7 * last) << nodes;
        if (nodes == 64) {
            EXPECT_LT(m.image_rmse, 0.01);
        }
        std::printf("ball of %d nodes: %.4f degrees rms, image %.5f\n", nodes, m.rms_degrees, m.image_rmse);
        last = m.rms_degrees;
    }
    // Against rays through the very same smooth index the angle is right, with steps as short as such a steep face
    // wants.
    const int nodes = 48;
    auto lens = ball(n, radius, radius / nodes, 1.5);
    lens.faces.clear();
    const runtime::IndexVolume same = readBack({lens}).front();
    const auto gradient = [&](const glm::dvec3& p) {
        const Vec3 g = same.at({p.x, p.y, p.z}).gradient;
        return glm::dvec3(g.x, g.y, g.z);
    };
    BentRayOptions options;
    options.turn = 0.05F;
    Eye small = eye;
    small.width = small.height = 24;
    const auto follow = [&](const glm::dvec3& d) -> std::optional<glm::dvec3> {
        if (passesAt(eye.position, d) > 0.8 * radius) return {};
        const double b = glm::dot(eye.position, d), outer = 1.2 * radius;
        const glm::dvec3 x =
            eye.position + (-b - std::sqrt(b * b - glm::dot(eye.position, eye.position) + outer * outer)) * d;
        return followed(gradient, x, d, radius / nodes / 16, outer);
    };
    const Misses m = missesOf(seen({lens}, small, around(directions), options), small, follow);
    EXPECT_LT(m.rms_degrees, 0.1);
    EXPECT_LT(m.image_rmse, 0.01);
    std::printf("ball, same index: %.4f degrees rms, image %.5f\n", m.rms_degrees, m.image_rmse);
}

/// What a sharp ball of glass shows of a DirectionMap: the reflection off it, and what has been through it with 0, 1, 2
/// ... reflections inside; and where the light that goes straight through comes from.
struct BallColour {
    glm::dvec3 straight{0}, direction{0};
    glm::dvec3 others{0};
    double share = 0;  ///< of what goes straight through
};
BallColour throughBall(double n, double radius, const glm::dvec3& eye, const glm::dvec3& d) {
    const double b = passesAt(eye, d), in = std::asin(b / radius), out = std::asin(b / radius / n);
    const glm::dvec3 across = glm::normalize(-(eye - glm::dot(eye, d) * d));
    const auto turned = [&](double angle) { return std::cos(angle) * d + std::sin(angle) * across; };
    const double r = fresnel(std::cos(in), 1, n);
    BallColour colour;
    colour.direction = turned(2 * (in - out)), colour.share = (1 - r) * (1 - r);
    colour.others = r * (0.5 * turned(2 * in - M_PI) + 0.5);
    double share = colour.share;
    for (int k = 1; k < 12; ++k)
        share *= r, colour.others += share * (0.5 * turned(2 * (in - out) + k * (M_PI - 2 * out)) + 0.5);
    return colour;
}

TEST_F(BentRays, ABallWithFacesIsSeenAsASharpOne) {
    const double n = 1.5, radius = 0.6;
    const Eye eye = eyeAt({1.7, 0.2, -0.3}, 42, 40);
    const DirectionMap directions(gl_);
    BentRayOptions options;
    options.faintest = 1e-3F;
    // As the tests make a ball, and as photic export does; to the rim, but for what its pixels cannot tell.
    for (const bool as_exported : {false, true}) {
        double last = 1e9;
        for (const int nodes : {16, 32, 64}) {
            const double voxel = radius / nodes;
            const auto lens = as_exported ? exported(objectOf(makeFishEye({0, 0, 0}, n, 1e4, radius)), voxel)
                                          : ball(n, radius, voxel, 1.5);
            const auto pixels = seen({lens}, eye, around(directions), options);
            double squares = 0, error = 0, size = 0, worst = 0;
            int rays = 0, directed = 0;
            for (int y = 0; y < eye.height; ++y)
                for (int x = 0; x < eye.width; ++x) {
                    const glm::dvec3 d = eye.direction(x, y);
                    if (passesAt(eye.position, d) > 0.97 * radius) continue;
                    const BallColour truth = throughBall(n, radius, eye.position, d);
                    const float* pixel = &pixels[4 * std::size_t(y * eye.width + x)];
                    const glm::dvec3 got(pixel[0], pixel[1], pixel[2]);
                    const glm::dvec3 want = truth.share * (0.5 * truth.direction + 0.5) + truth.others;
                    error += glm::dot(got - want, got - want), size += glm::dot(want, want), ++rays;
                    const glm::dvec3 left = glm::normalize(2.0 * (got - truth.others) / truth.share - 1.0);
                    const double angle = std::acos(std::clamp(glm::dot(left, truth.direction), -1.0, 1.0)) / kDegree;
                    if (passesAt(eye.position, d) < 0.9 * radius)
                        squares += angle * angle, ++directed, worst = std::max(worst, angle);
                }
            const double rms = std::sqrt(squares / directed), image = std::sqrt(error / size);
            std::printf("ball with faces, %s, %d nodes: %.4f degrees rms, %.3f at most, image %.5f, %d rays\n",
                        as_exported ? "exported" : "made", nodes, rms, worst, image, rays);
            EXPECT_LT(rms, 0.1) << nodes;
            EXPECT_LT(image, 0.003) << nodes;
            last = rms;
        }
        EXPECT_LT(last, as_exported ? 0.06 : 0.05);
    }
}

// Behind a face the index may go on changing, along it: n^2 = 2 + 0.8 z in a plate, where rays are parabolas.
TEST_F(BentRays, WhatChangesBehindAFaceBendsUpToIt) {
    IndexVolumeObject plate = slab(std::sqrt(2.0), false);
    for (std::size_t i = 0; i < plate.spline[0].size(); ++i) {
        const double z = plate.origin_world.z + 0.1 * static_cast<double>(i / (41 * 40));
        if (plate.spline[0][i] > 0) plate.spline[0][i] = static_cast<float>(0.5 + 0.4 * z);
    }
    constexpr double kHalf = 0.21;  // of its thickness: faces are between nodes
    const Eye eye = eyeAt({1.5, 0.3, 0.2}, 36, 40);
    const DirectionMap directions(gl_);
    BentRayOptions options;
    options.branches = 0;
    const auto pixels = seen({plate}, eye, around(directions), options);
    const auto square = [](double z) { return 2 + 0.8 * z; };
    const auto colour = [](const glm::dvec3& v) { return 0.5 * glm::normalize(v) + 0.5; };
    double squares = 0, worst = 0;
    int rays = 0;
    for (int y = 0; y < eye.height; ++y)
        for (int x = 0; x < eye.width; ++x) {
            const glm::dvec3 d = eye.direction(x, y);
            const double to = (eye.position.x - kHalf) / -d.x, z0 = eye.position.z + to * d.z;
            const double inside = std::sqrt(square(z0) - d.y * d.y - d.z * d.z), s = 2 * kHalf / inside;
            const double z1 = z0 + d.z * s + 0.2 * s * s, up = d.z + 0.4 * s;
            const glm::dvec3 out(-std::sqrt(1 - d.y * d.y - up * up), d.y, up);
            const double first = fresnel(-d.x, 1, std::sqrt(square(z0)));
            const double second = fresnel(inside / std::sqrt(square(z1)), std::sqrt(square(z1)), 1);
            const glm::dvec3 mirrored =
                first * colour({-d.x, d.y, d.z}) + (1 - first) * second * colour({inside, d.y, up});
            const float* pixel = &pixels[4 * std::size_t(y * eye.width + x)];
            const glm::dvec3 got = (glm::dvec3(pixel[0], pixel[1], pixel[2]) - mirrored) / ((1 - first) * (1 - second));
            const double angle =
                std::acos(std::clamp(glm::dot(glm::normalize(2.0 * got - 1.0), out), -1.0, 1.0)) / kDegree;
            squares += angle * angle, worst = std::max(worst, angle), ++rays;
        }
    const double rms = std::sqrt(squares / rays);
    std::printf("plate whose index changes along it: %.4f degrees rms, %.3f at most\n", rms, worst);
    EXPECT_LT(rms, 0.1);
}

TEST_F(BentRays, ThePapersStepsAreFirstOrder) {
    const double radius = 0.8;
    const Eye eye = eyeAt({2.0, 0.3, 0.2}, 36, 32);
    const DirectionMap directions(gl_);
    const auto lens = exported(objectOf(makeLuneburgLens({0, 0, 0}, radius)), radius / 48);
    const auto errorOf = [&](BentIntegrator integrator, float step) {
        BentRayOptions options;
        options.integrator = integrator, options.step = step, options.turn = 1, options.steps = 60000;
        return missesOf(seen({lens}, eye, around(directions), options), eye,
                        [&](const glm::dvec3& d) { return throughLuneburg(radius, eye.position, d, 0.9); })
            .rms_degrees;
    };
    const double long_steps = errorOf(BentIntegrator::Euler, 1), short_steps = errorOf(BentIntegrator::Euler, 0.5F),
                 ours = errorOf(BentIntegrator::DriftKickDrift, 1);
    EXPECT_NEAR(long_steps / short_steps, 2, 0.35);
    EXPECT_LT(ours, 0.2 * long_steps);
    std::printf("Luneburg, one node a step: Euler %.4f degrees, drift-kick-drift %.4f\n", long_steps, ours);
}

}  // namespace
}  // namespace photic::test
