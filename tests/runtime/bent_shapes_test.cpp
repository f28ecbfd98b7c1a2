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
    options.faintest = 1e-3F;
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

/// A body of sharp faces with samples of its inside: (n^2 - 1) / 2 by place, on nodes of `voxel` m.
template <class Excess>
IndexVolumeObject filled(IndexVolumeObject body, double voxel, double half_width, const Excess& excess) {
    IndexVolumeObject object;
    object.name = "filled";
    const int half = static_cast<int>(std::ceil(half_width / voxel)) + 4;
    object.count = glm::ivec3(2 * half + 1);
    object.world_from_node = glm::dmat3(voxel);
    object.origin_world = glm::dvec3(-voxel * half);
    object.box_low = glm::vec3(1), object.box_high = glm::vec3(2 * half - 1);
    std::vector<float>& spline = object.spline.emplace_back();
    for (int z = -half; z <= half; ++z)
        for (int y = -half; y <= half; ++y)
            for (int x = -half; x <= half; ++x)
                spline.push_back(static_cast<float>(excess(voxel * glm::dvec3(x, y, z))));
    object.shape = body.shape;
    const double scale = 0.01 / voxel;
    for (glm::vec3& p : object.shape->positions) p = glm::vec3(scale * glm::dvec3(p) + double(half));
    const glm::dvec4 ball(object.shape->ball);
    object.shape->ball = glm::vec4(glm::vec3(glm::dvec3(ball) * scale + double(half)), ball.w * scale);
    return object;
}

/// Follows a ray through a ball of n^2 / 2 with a sharp face, in double, by steps far shorter than needed.
template <class Index>
glm::dvec3 throughFilledBall(const Index& half_square, double radius, const glm::dvec3& eye, const glm::dvec3& d) {
    const double b = glm::dot(eye, d);
    glm::dvec3 place = eye + (-b - std::sqrt(b * b - glm::dot(eye, eye) + radius * radius)) * d;
    const auto refracted = [&](const glm::dvec3& p, const glm::dvec3& normal, double square) {
        const glm::dvec3 along = p - glm::dot(p, normal) * normal;
        return along + std::sqrt(square - glm::dot(along, along)) * normal;
    };
    glm::dvec3 p = refracted(d, -place / radius, 2 * half_square(place));
    const double step = 5e-4;
    while (true) {
        const glm::dvec3 middle = place + 0.5 * step * p;
        glm::dvec3 force;
        for (int a = 0; a < 3; ++a) {
            glm::dvec3 aside(0);
            aside[a] = 1e-4;
            force[a] = (half_square(middle + aside) - half_square(middle - aside)) / 2e-4;
        }
        const glm::dvec3 next = p + step * force, to = middle + 0.5 * step * next;
        if (glm::length(to) > radius) break;
        place = to, p = next;
    }
    return glm::normalize(refracted(p, place / glm::length(place), 1));
}

TEST_F(BentRays, WhatFillsASharpBallBendsBetweenItsFaces) {
    // A fish-eye that ends where n is 1.22: faces, and a bend between them, off the middle of the ball.
    const double radius = 0.5;
    const glm::dvec3 middle(0.1, -0.05, 0.08);
    const auto half_square = [&](const glm::dvec3& p) {
        const double n = 1.6 / (1 + glm::dot(p - middle, p - middle) / 0.8);
        return 0.5 * n * n;
    };
    IndexVolumeObject ball = sharpBall(1, radius);
    ball.shape->faces = SharpShape::Faces::Clear;
    const Eye eye = eyeAt({1.7, 0.2, -0.3}, 34, 40);
    const DirectionMap directions(gl_);
    const auto missed = [&](const IndexVolumeObject& object) {
        const auto pixels = seen({object}, eye, around(directions));
        double squares = 0;
        int rays = 0;
        for (int i = 0; i < eye.width * eye.height; ++i) {
            const glm::dvec3 d = eye.direction(i % eye.width, i / eye.width);
            if (glm::length(eye.position - glm::dot(eye.position, d) * d) > 0.9 * radius) continue;
            const glm::dvec3 wanted = throughFilledBall(half_square, radius, eye.position, d);
            const float* pixel = &pixels[4 * static_cast<std::size_t>(i)];
            const double angle = std::acos(std::clamp(glm::dot(wanted, directionOf(pixel)), -1.0, 1.0)) / kDegree;
            squares += angle * angle, ++rays;
        }
        EXPECT_GT(rays, 500);
        return std::sqrt(squares / rays);
    };
    const auto excess = [&](const glm::dvec3& p) { return half_square(p) - 0.5; };
    const double exact = missed(filled(ball, radius / 24, radius, excess));
    IndexVolumeObject facets = sharpMesh(sphereMesh({0, 0, 0}, radius, 64), 1);
    facets.shape->faces = SharpShape::Faces::Clear;
    const double of_mesh = missed(filled(facets, radius / 24, radius, excess));
    std::printf("fish-eye in a sharp ball: %.4f degrees rms, of triangles %.4f\n", exact, of_mesh);
    EXPECT_LT(exact, 0.1);
    EXPECT_LT(of_mesh, 0.15);
}

TEST_F(BentRays, SamplesBesideAndWithinSharpShapesStayUniform) {
    Surroundings even;
    even.colour[0] = 1, even.colour[1] = 2, even.colour[2] = 0.5F;
    BentRayOptions options;
    options.faintest = 1e-3F;
    const Eye eye = eyeAt({1.7, 0.2, -0.3}, 42, 32);
    const auto brine = [](const glm::dvec3& p) { return 0.39 + 0.1 * p.z + 0.05 * std::sin(6 * p.x); };
    // A liquid whose index varies in a glass, which is thin and of one index; and a lens of samples in a sharp box.
    IndexVolumeObject glass = sharpMesh(sphereMesh({0, 0, 0}, 0.45, 24), 1.52);
    IndexVolumeObject liquid =
        filled(sharpMesh(boxMesh({-0.25, -0.25, -0.25}, {0.25, 0.25, 0.25}), 1, false), 0.02, 0.25, brine);
    liquid.shape->rank = 1;
    expectUniform(seen({glass, liquid}, eye, even, options));
    const IndexVolumeObject box = sharpMesh(boxMesh({-0.45, -0.45, -0.45}, {0.45, 0.45, 0.45}), 1.4, false);
    expectUniform(seen({box, exported(objectOf(makeFishEye({0, 0, 0}, 1.3, 0.3, 0.164)), 0.012)}, eye, even, options));
    // The same bits where even space is stepped through.
    const DirectionMap directions(gl_);
    BentRayOptions stepped = options;
    stepped.skipping = BentSkipping::None;
    const auto a = seen({glass, liquid}, eye, around(directions), options);
    const auto b = seen({glass, liquid}, eye, around(directions), stepped);
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, double(std::fabs(a[i] - b[i])));
    EXPECT_LT(worst, 1e-4);
}

TEST_F(BentRays, ASharpPlateTakesWhatFresnelAndBeerSay) {
    Eye eye = eyeAt({-0.6, 0, 0}, 60, 17);
    eye.target = {1, 0, 0};
    const EnvironmentMap half(gl_, 4, 1, {0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 1}, GL_NEAREST);
    Surroundings s;
    s.environment = half.texture;
    // Flat plates of 0.4 m: of glass that takes red; a pane without thickness; and samples of the first.
    IndexVolumeObject plate = sharpMesh(boxMesh({-0.2, -1.9, -1.9}, {0.2, 1.9, 1.9}), 1.6, false), pane = plate;
    plate.shape->absorption = {2, 0, 0};
    pane.shape->faces = SharpShape::Faces::Thin;
    pane.shape->positions = {{0, -190, -190}, {0, 190, -190}, {0, 190, 190}, {0, -190, 190}};
    pane.shape->triangles = {{0, 1, 2}, {0, 2, 3}};
    const auto glass = seen({plate}, eye, s), thin = seen({pane}, eye, s);
    for (int i = 0; i < eye.width * eye.height; ++i) {
        const double cosine = eye.direction(i % eye.width, i / eye.width).x, r = fresnel(cosine, 1, 1.6);
        const double inside = std::sqrt(1 - (1 - cosine * cosine) / (1.6 * 1.6)), left = std::exp(-2 * 0.4 / inside);
        const float* pixel = &glass[4 * static_cast<std::size_t>(i)];
        EXPECT_NEAR(double(pixel[0]), (1 - r) * (1 - r) * left / (1 - r * r * left * left), 2e-3);
        EXPECT_NEAR(double(pixel[1]), (1 - r) / (1 + r), 2e-3) << "the other channels are clear";
        EXPECT_NEAR(double(thin[4 * static_cast<std::size_t>(i)]), (1 - r) / (1 + r), 1e-5);
    }
}

TEST_F(BentRays, SharpMirrorsReflectAndPrismsDisperse) {
    const DirectionMap directions(gl_);
    const Eye eye = eyeAt({1.6, 0, 0}, 40, 33);
    IndexVolumeObject mirror = sharpBall(1, 0.4);
    mirror.shape->faces = SharpShape::Faces::Mirror, mirror.shape->colour = {1, 0.5, 0.25};
    const auto image = seen({mirror}, eye, around(directions));
    int rays = 0;
    for (int i = 0; i < eye.width * eye.height; ++i) {
        const glm::dvec3 d = eye.direction(i % eye.width, i / eye.width), o = eye.position;
        const double b = glm::dot(o, d), square = b * b - glm::dot(o, o) + 0.4 * 0.4;
        if (square < 0.003) continue;
        const glm::dvec3 normal = (o + (-b - std::sqrt(square)) * d) / 0.4;
        const glm::dvec3 wanted = 0.5 * glm::reflect(d, normal) + 0.5;
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(double(image[4 * static_cast<std::size_t>(i) + static_cast<std::size_t>(c)]),
                        mirror.shape->colour[c] * wanted[c], 2e-3);
        ++rays;
    }
    EXPECT_GT(rays, 200);

    IndexVolumeObject flint = sharpBall(1.5, 0.5);
    flint.shape->index = {1.5, 1.52, 1.56};
    const auto split = seen({flint}, eye, around(directions));
    for (std::size_t c = 0; c < 3; ++c) {
        const auto one = seen({sharpBall(flint.shape->index[static_cast<int>(c)], 0.5)}, eye, around(directions));
        for (std::size_t i = c; i < one.size(); i += 4) ASSERT_NEAR(split[i], one[i], 1e-5) << c;
    }
    // The paper's loop has no faces to meet.
    const auto objects = GpuIndexVolumes::upload(*gpu_, readBack({flint}));
    ASSERT_TRUE(objects.ok());
    BentRayOptions euler;
    euler.integrator = BentIntegrator::Euler;
    const float origin[3] = {0, 0, 0};
    EXPECT_EQ(pass_->bind(origin, *objects, {{0}}, euler).error().code, runtime::ErrorCode::Usage);
}

}  // namespace
}  // namespace photic::test
