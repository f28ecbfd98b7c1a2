// SPDX-License-Identifier: Apache-2.0
// The passes draw what the CPU computes of the same volume: receivers by the look-up, media by brute force.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bake/optics/phase_function.h"
#include "tests/runtime/baked_scene.h"
#include "tests/runtime/gpu_fixture.h"
#include "tests/runtime/scene_view.h"

namespace photic::runtime {
namespace {

using test::DrawnView;
using test::Eye;
using test::NvdbSpec;

/// Smooth light in a box of 2 x 2 x 1.5 m below z = 0: sheets that sway, dark between, coloured or white.
NvdbSpec sheets(bool coloured) {
    NvdbSpec spec;
    spec.min = {0, 0, 0};
    spec.max = {63, 63, 47};
    const double voxel = 2.0 / 64;
    spec.world_from_index = {voxel, 0, 0, 0, voxel, 0, 0, 0, voxel};
    spec.origin_world = {-1 + voxel / 2, -1 + voxel / 2, -1.5 + voxel / 2};
    spec.coloured = coloured;
    spec.json = R"({"reference_irradiance": 500})";
    spec.values = [](int i, int j, int k) -> test::LightValues {
        const double x = i / 64.0, y = j / 64.0, z = k / 48.0;
        const double sheet = std::sin(9 * x + 3 * z) * std::cos(7 * y - 2 * z);
        const double e = std::max(0.0, sheet - 0.1) * 4;
        const glm::dvec3 w = 0.95 * glm::normalize(glm::dvec3(0.3 * std::sin(5 * y), 0.2, -1)) * e;
        return {float(w.x), float(w.y), float(w.z), float(e), float(0.6 * e), float(1.1 * e), float(1.3 * e)};
    };
    return spec;
}

/// Like sheets(), but only in two corners, so that most pages are dark.
NvdbSpec corners() {
    NvdbSpec spec = sheets(false);
    spec.active = [](int i, int j, int k) { return (i < 18 && j < 20) || (i > 50 && j > 40 && k < 20); };
    return spec;
}

Eye poolEye() {
    Eye eye;
    eye.position = {-1.6, -2.2, 1.2};
    eye.target = {0, 0, -0.9};
    eye.width = 72;
    eye.height = 48;
    return eye;
}

test::Trace pool() { return test::planes({{{0, 0, -1.45}, {0, 0, 1}}, {{0.93, 0, 0}, {-1, 0, 0}}}); }

double relativeRmse(const std::vector<float>& image, const std::vector<glm::dvec3>& truth) {
    double error = 0, size = 0;
    for (std::size_t n = 0; n < truth.size(); ++n) {
        for (std::size_t c = 0; c < 3; ++c) {
            const double t = truth[n][static_cast<int>(c)], d = static_cast<double>(image[4 * n + c]) - t;
            error += d * d;
            size += t * t;
        }
    }
    return std::sqrt(error / size);
}

template <class Body>
std::vector<glm::dvec3> eachPixel(const Eye& eye, const Body& body) {
    std::vector<glm::dvec3> out;
    for (int y = 0; y < eye.height; ++y) {
        for (int x = 0; x < eye.width; ++x) out.push_back(body(eye.direction(x, y)));
    }
    return out;
}

glm::dvec3 glmOf(const Vec3& v) { return {v.x, v.y, v.z}; }
Vec3 vecOf(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

using Passes = test::WithGpu;

TEST_F(Passes, ReceiversGetTheLookedUpLight) {
    for (const bool coloured : {false, true}) {
        for (const bool reversed : {false, true}) {
            const Volume volume = test::makeVolume(sheets(coloured));
            GpuVolume gpu = upload(volume, {});
            Eye eye = poolEye();
            eye.reversed_depth = reversed;
            const DrawnView view(gl_, eye, pool());
            auto pass = ReceiverPass::create(*gpu_);
            ASSERT_TRUE(pass.ok()) << pass.error().message;
            ReceiverOptions options;
            options.output = ReceiverOutput::Irradiance;
            const Status drawn = pass->draw(view.surfaces, view.target, {{&gpu}}, options);
            ASSERT_TRUE(drawn.ok()) << drawn.error().message;
            const auto truth = eachPixel(eye, [&](const glm::dvec3& direction) {
                const auto hit = pool()(eye.position, direction);
                if (!hit) return glm::dvec3(0);
                return glmOf(volume.irradiance(vecOf(eye.position + hit->distance * direction), vecOf(hit->normal)));
            });
            EXPECT_LT(relativeRmse(view.pixels(), truth), 0.003);
        }
    }
}

TEST_F(Passes, LightsAddUpAndAlbedoScales) {
    const Volume volume = test::makeVolume(sheets(false));
    GpuVolume gpu = upload(volume, {});
    const Eye eye = poolEye();
    const DrawnView one(gl_, eye, pool()), two(gl_, eye, [](const glm::dvec3&o, const glm::dvec3&d) {
        auto hit = pool()(o, d);
        if (hit) hit->albedo = {0.5, 0.25, 1};
        return hit;
    });
    auto pass = ReceiverPass::create(*gpu_);
    ASSERT_TRUE(pass.ok());
    two.fill(1, 2, 3);
    ASSERT_TRUE(pass->draw(one.surfaces, one.target, {{&gpu}}).ok());
    ASSERT_TRUE(pass->draw(two.surfaces, two.target, {{&gpu, 0.75F}, {&gpu, 0.5F}}).ok());
    const auto a = one.pixels(), b = two.pixels();
    for (std::size_t n = 0; n < a.size(); n += 4) {
        ASSERT_NEAR(b[n], 1 + 0.5F * 1.25F * a[n], 1e-4F * (1 + a[n]));
        ASSERT_NEAR(b[n + 2], 3 + 1.25F * a[n + 2], 1e-4F * (1 + a[n]));
    }
}

TEST_F(Passes, LightThatOpposesItselfHasTwoLobes) {
    const Volume volume = test::opposedSuns();
    ASSERT_TRUE(volume.hasSecondLobe());
    GpuVolume gpu = upload(volume, {});
    ASSERT_NE(gpu.secondLobe(), nullptr);
    EXPECT_GT(gpu.secondLobe()->info().bytes, 0u);
    // A north wall, lit by the first sun, and a south wall, lit by the second.
    const test::Trace walls = test::planes({{{0, 0.45, 0}, {0, -1, 0}}, {{0, -0.45, 0}, {0, 1, 0}}});
    for (const double y : {-0.2, 0.2}) {
        Eye eye = poolEye();
        eye.position = {-0.1, y, -0.4}, eye.target = {0, 4 * y, -0.5};
        const DrawnView view(gl_, eye, walls);
        auto pass = ReceiverPass::create(*gpu_);
        ASSERT_TRUE(pass.ok()) << pass.error().message;
        ReceiverOptions options;
        options.output = ReceiverOutput::Irradiance;
        ASSERT_TRUE(pass->draw(view.surfaces, view.target, {{&gpu}}, options).ok());
        double brightest = 0;
        const auto truth = eachPixel(eye, [&](const glm::dvec3& direction) {
            const auto hit = walls(eye.position, direction);
            if (!hit) return glm::dvec3(0);
            const glm::dvec3 e =
                glmOf(volume.irradiance(vecOf(eye.position + hit->distance * direction), vecOf(hit->normal)));
            brightest = std::max(brightest, e.x);
            return e;
        });
        EXPECT_GT(brightest, 50);
        EXPECT_LT(relativeRmse(view.pixels(), truth), 0.003 + filterError()) << y;
    }
}

MediumOptions water() {
    MediumOptions options;
    const float scattering[3] = {0.2F, 0.25F, 0.3F}, absorption[3] = {0.35F, 0.07F, 0.02F};
    std::copy_n(scattering, 3, options.scattering);
    std::copy_n(absorption, 3, options.absorption);
    options.anisotropy = 0.7F;
    options.surface[2] = 1;
    options.surface[3] = 0;  // below z = 0
    return options;
}

/// Single scattering by definition, in many small steps: the sum over the ray below z = 0.
glm::dvec3 bruteForce(const Volume& volume, const MediumOptions& medium, const glm::dvec3& eye,
                      const glm::dvec3& direction, double surface_distance) {
    const double enter = eye.z > 0 ? -eye.z / direction.z : 0;
    const double begin = direction.z < 0 || eye.z <= 0 ? std::max(0.0, enter) : 1e9;
    const double leave = eye.z <= 0 && direction.z > 0 ? -eye.z / direction.z : 1e9;
    const double end = std::min({surface_distance, begin + 8, leave});
    constexpr int kSteps = 1500;
    glm::dvec3 sum{0};
    for (int i = 0; i < kSteps && end > begin; ++i) {
        const double ds = (end - begin) / kSteps, s = (i + 0.5) * ds;
        const Light light = volume.sample(vecOf(eye + (begin + s) * direction));
        const glm::dvec3 flux = glmOf(light.flux), e = glmOf(light.irradiance);
        const double mean = (e.x + e.y + e.z) / 3, size = glm::length(flux);
        if (mean <= 0) continue;
        const double phase =
            henyeyGreenstein(-glm::dot(flux, direction) / size, double(medium.anisotropy) * size / mean);
        for (int c = 0; c < 3; ++c) {
            const double extinction = double(medium.scattering[c]) + double(medium.absorption[c]);
            sum[c] += std::exp(-extinction * s) * double(medium.scattering[c]) * e[c] * phase * ds;
        }
    }
    return sum;
}

TEST_F(Passes, MediaAreTheBruteForceIntegral) {
    for (const bool coloured : {false, true}) {
        for (const double height : {1.2, -0.4}) {  // from the air, and from within
            const Volume volume = test::makeVolume(sheets(coloured));
            GpuVolume gpu = upload(volume, {});
            Eye eye = poolEye();
            eye.position.z = height;
            const DrawnView view(gl_, eye, pool());
            auto pass = MediumPass::create(*gpu_);
            ASSERT_TRUE(pass.ok()) << pass.error().message;
            MediumOptions options = water();
            options.steps = 256;
            options.extinction = Extinction::Left;
            const Status drawn = pass->draw(view.surfaces, view.target, {{&gpu}}, options);
            ASSERT_TRUE(drawn.ok()) << drawn.error().message;
            const auto truth = eachPixel(eye, [&](const glm::dvec3& direction) {
                const auto hit = pool()(eye.position, direction);
                return bruteForce(volume, options, eye.position, direction, hit ? hit->distance : 1e9);
            });
            EXPECT_LT(relativeRmse(view.pixels(), truth), 0.005) << height;
            options.steps = 32;
            view.fill(0, 0, 0);
            ASSERT_TRUE(pass->draw(view.surfaces, view.target, {{&gpu}}, options).ok());
            EXPECT_LT(relativeRmse(view.pixels(), truth), 0.05) << height;
        }
    }
}

TEST_F(Passes, SkippingChangesNoBit) {
    for (const Layout layout : {Layout::Atlas, Layout::Dense, Layout::Buffer}) {
        UploadOptions upload_options;
        upload_options.layout = layout;
        GpuVolume gpu = upload(test::makeVolume(corners()), upload_options);
        const DrawnView with(gl_, poolEye(), pool()), without(gl_, poolEye(), pool());
        auto pass = MediumPass::create(*gpu_);
        ASSERT_TRUE(pass.ok());
        MediumOptions options = water();
        for (const int steps : {32, 117, 500}) {
            options.steps = steps;
            options.jitter = steps == 117 ? StepJitter::PerPixel : StepJitter::Middle;
            options.skipping = Skipping::DarkPages;
            with.fill(0, 0, 0), without.fill(0, 0, 0);
            ASSERT_TRUE(pass->draw(with.surfaces, with.target, {{&gpu}}, options).ok());
            options.skipping = Skipping::Nothing;
            ASSERT_TRUE(pass->draw(without.surfaces, without.target, {{&gpu}}, options).ok());
            const auto a = with.pixels(), b = without.pixels();
            EXPECT_EQ(a, b) << steps;
            float largest = 0;
            for (std::size_t n = 0; n < a.size(); n += 4) largest = std::max(largest, a[n]);
            EXPECT_GT(largest, 0.1F);
        }
    }
}

TEST_F(Passes, WhatIsBehindIsDimmed) {
    GpuVolume dark = upload(Volume(), {});
    const Eye eye = poolEye();
    const DrawnView view(gl_, eye, pool());
    view.fill(10, 10, 10);
    auto pass = MediumPass::create(*gpu_);
    ASSERT_TRUE(pass.ok());
    const MediumOptions options = water();
    ASSERT_TRUE(pass->draw(view.surfaces, view.target, {{&dark}}, options).ok());
    const auto truth = eachPixel(eye, [&](const glm::dvec3& direction) {
        const auto hit = pool()(eye.position, direction);
        const double below = direction.z < 0 ? (hit ? hit->distance : 1e9) + eye.position.z / direction.z : 0;
        glm::dvec3 left;
        for (int c = 0; c < 3; ++c) {
            left[c] = 10 * std::exp(-std::max(0.0, below) * double(options.scattering[c] + options.absorption[c]));
        }
        return left;
    });
    EXPECT_LT(relativeRmse(view.pixels(), truth), 1e-3);
    EXPECT_EQ(view.pixels()[3], 0.25F);  // alpha is left alone
}

TEST_F(Passes, HalfResolutionKeepsEdges) {
    const Volume volume = test::makeVolume(sheets(false));
    GpuVolume gpu = upload(volume, {});
    Eye eye = poolEye();
    eye.width = 191;  // odd
    eye.height = 127;
    // A post in front of the floor: light must not bleed from the far floor onto it.
    const auto post = [](const glm::dvec3& o, const glm::dvec3& d) {
        auto hit = pool()(o, d);
        const double t = (-0.4 - o.y) / d.y;
        const glm::dvec3 p = o + t * d;
        if (t > 0 && std::fabs(p.x + 0.2) < 0.12 && p.z < -0.1 && (!hit || t < hit->distance))
            hit = test::Hit{t, {0, -1, 0}};
        return hit;
    };
    const DrawnView full(gl_, eye, post), half(gl_, eye, post);
    auto pass = MediumPass::create(*gpu_);
    ASSERT_TRUE(pass.ok());
    MediumOptions options = water();
    options.steps = 64;
    options.extinction = Extinction::Left;
    ASSERT_TRUE(pass->draw(full.surfaces, full.target, {{&gpu}}, options).ok());
    options.resolution = MediumResolution::Halved;
    ASSERT_TRUE(pass->draw(half.surfaces, half.target, {{&gpu, 0.5F}, {&gpu, 0.5F}}, options).ok());
    const auto a = full.pixels(), b = half.pixels();
    std::vector<glm::dvec3> truth;
    for (std::size_t n = 0; n < a.size(); n += 4) truth.emplace_back(a[n], a[n + 1], a[n + 2]);
    EXPECT_LT(relativeRmse(b, truth), 0.02);
    // The worst pixel too: bilinear upsampling without depth errs by the difference of post and floor.
    float worst = 0, largest = 0;
    for (std::size_t n = 0; n < a.size(); n += 4) {
        worst = std::max(worst, std::fabs(a[n] - b[n]));
        largest = std::max(largest, a[n]);
    }
    EXPECT_LT(worst / largest, 0.15F);
}

TEST_F(Passes, BadArgumentsAreNamed) {
    GpuVolume gpu = upload(Volume(), {});
    const DrawnView view(gl_, poolEye(), pool());
    auto receivers = ReceiverPass::create(*gpu_);
    auto media = MediumPass::create(*gpu_);
    ASSERT_TRUE(receivers.ok() && media.ok());
    EXPECT_EQ(receivers->draw({}, view.target, {{&gpu}}).error().code, ErrorCode::Usage);
    EXPECT_EQ(receivers->draw(view.surfaces, {}, {{&gpu}}).error().code, ErrorCode::Usage);
    EXPECT_EQ(receivers->draw(view.surfaces, view.target, {{}}).error().code, ErrorCode::Usage);
    MediumOptions options = water();
    options.anisotropy = 1;
    EXPECT_EQ(media->draw(view.surfaces, view.target, {{&gpu}}, options).error().code, ErrorCode::Usage);
    options = water();
    options.steps = 0;
    EXPECT_EQ(media->draw(view.surfaces, view.target, {{&gpu}}, options).error().code, ErrorCode::Usage);
    options = water();
    options.scattering[1] = -1;
    EXPECT_EQ(media->draw(view.surfaces, view.target, {{&gpu}}, options).error().code, ErrorCode::Usage);
}

}  // namespace
}  // namespace photic::runtime
