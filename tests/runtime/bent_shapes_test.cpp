// SPDX-License-Identifier: Apache-2.0
// Eye rays through shapes with sharp faces: balls that are exact and balls of triangles against closed forms, and laws
// that hold whatever the shape.
#include "bake/scene/mesh_file.h"
#include "tests/runtime/bent_fixture.h"

namespace photic::test {
namespace {

/// Where a ray leaves a ball around the origin that only bends it.
std::optional<glm::dvec3> throughBall(double n, double radius, double rim, const glm::dvec3& eye, const glm::dvec3& d) {
    const double b = glm::length(eye - glm::dot(eye, d) * d);
    if (b > rim * radius) return {};
    const double bend = 2 * (std::asin(b / radius) - std::asin(b / radius / n));
    if (b < 1e-12) return d;
    const glm::dvec3 across = glm::normalize(-(eye - glm::dot(eye, d) * d));
    return std::cos(bend) * d + std::sin(bend) * across;
}

/// Root mean square angle between what left the ball and what should have [degrees].
double missOf(const std::vector<float>& pixels, const Eye& eye, double n, double radius) {
    double squares = 0;
    int rays = 0;
    for (int y = 0; y < eye.height; ++y)
        for (int x = 0; x < eye.width; ++x) {
            const auto wanted = throughBall(n, radius, 0.95, eye.position, eye.direction(x, y));
            if (!wanted) continue;
            const float* pixel = &pixels[4 * static_cast<std::size_t>(y * eye.width + x)];
            EXPECT_GE(pixel[0], 0) << x << " " << y;
            const double angle = std::acos(std::clamp(glm::dot(*wanted, directionOf(pixel)), -1.0, 1.0)) / kDegree;
            squares += angle * angle, ++rays;
        }
    EXPECT_GT(rays, 500);
    return std::sqrt(squares / rays);
}

TEST_F(BentRays, ASharpBallBendsAsItsFormulaSays) {
    const double n = 1.5, radius = 0.6;
    const Eye eye = eyeAt({1.7, 0.2, -0.3}, 42, 40);
    const DirectionMap directions(gl_);
    IndexVolumeObject exact = sharpBall(n, radius);
    exact.shape->faces = SharpShape::Faces::Clear;
    const double of_ball = missOf(seen({exact}, eye, around(directions)), eye, n, radius);
    std::printf("ball, exact: %.4f degrees rms\n", of_ball);
    EXPECT_LT(of_ball, 0.03);
    double last = 1e9;
    for (const int segments : {16, 32, 64}) {
        IndexVolumeObject facets = sharpMesh(sphereMesh({0, 0, 0}, radius, segments), n);
        facets.shape->faces = SharpShape::Faces::Clear;
        const double miss = missOf(seen({facets}, eye, around(directions)), eye, n, radius);
        std::printf("ball of %zu triangles: %.4f degrees rms\n", facets.shape->triangles.size(), miss);
        // Chords of triangles lie off the ball by the square of their size.
        EXPECT_LT(miss, 0.45 * last);
        last = miss;
    }
    EXPECT_LT(last, 0.1);
}

TEST_F(BentRays, UniformSurroundingsStayUniformThroughSharpShapes) {
    Surroundings even;
    even.colour[0] = 1, even.colour[1] = 2, even.colour[2] = 0.5F;
    BentRayOptions options;
    options.faintest = 0;
    const Eye eye = eyeAt({1.7, 0.2, -0.3}, 42, 40);
    // A box of flint around a ball of crown, and a lens of samples in front of both.
    const TriangleMesh box = boxMesh({-0.4, -0.4, -0.4}, {0.4, 0.4, 0.4});
    IndexVolumeObject outer = sharpMesh(box, 1.62, false), inner = sharpBall(1.5, 0.25);
    inner.shape->rank = 1;
    expectUniform(seen({outer, inner, ball(1.4, 0.3, 0.02, 3, {0.8, 0.1, -0.2})}, eye, even, options));
    // The eye in the glass.
    const Eye within = eyeAt({0.32, 0.05, 0.1}, 70, 40);
    std::vector<float> pixels = seen({outer, inner}, within, even, options);
    for (float& p : pixels) p /= 1.62F * 1.62F;  // radiance there, over what it is in air
    expectUniform(pixels);
}

}  // namespace
}  // namespace photic::test
