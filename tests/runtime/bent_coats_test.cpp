// SPDX-License-Identifier: Apache-2.0
// Faces that send light back: Lambert's share against closed forms, highlights against GGX's formulas and their energy,
// surroundings by harmonics, coats that differ from place to place.
#include "tests/runtime/bent_fixture.h"

namespace photic::test {
namespace {

constexpr double kWatts = 200;  // of evenLight() [W/m2]

class BentCoats : public BentRays {
protected:
    /// What an eye sees of objects in even light, and in dark surroundings.
    std::vector<float> lit(const std::vector<IndexVolumeObject>& objects, const Eye& eye, const glm::dvec3& along,
                           const BentRayOptions& options = {}) {
        GpuVolume light = upload(makeVolume(evenLight(along)), {});
        auto gpu = GpuIndexVolumes::upload(*gpu_, readBack(objects));
        if (!pass_) pass_ = std::make_unique<BentRayPass>(BentRayPass::create(*gpu_).value());
        const DrawnView view(gl_, eye, [](const glm::dvec3&, const glm::dvec3&) { return std::nullopt; });
        view.fill(-1, -1, -1);
        GBuffer surfaces = view.surfaces;
        surfaces.depth = 0;
        Surroundings dark;
        for (float& c : dark.colour) c = 0;
        std::vector<PlacedObject> placed;
        for (unsigned i = 0; i < objects.size(); ++i) placed.push_back({i});
        const auto drawn = pass_->draw(surfaces, view.target, *gpu, placed, dark, {{&light}}, options);
        EXPECT_TRUE(drawn.ok()) << drawn.error().message;
        return view.pixels();
    }
};

/// Such that nothing of its inside is seen.
IndexVolumeObject blackSlab(double n, bool sharp) {
    auto object = slab(n, sharp, 1);
    for (glm::vec4& v : object.attenuation) v = glm::vec4(glm::vec3(5000 * v.x), v.w);
    return object;
}

TEST_F(BentCoats, UniformSurroundingsStayUniform) {
    const Eye eye = eyeAt({1.6, 0.1, 0.15}, 45, 48);
    Surroundings even;
    even.colour[0] = 1, even.colour[1] = 2, even.colour[2] = 0.5;
    Monitor monitor;
    const WorldBox box{{-0.9, 0.15, -0.3}, {-0.5, 0.5, 0.3}};
    std::vector<IndexVolumeObject> objects{
        ball(1.5, 0.4, 0.02, 1.5), ball(1.3, 0.2, 0.02, 1.5, {-0.6, -0.4, 0.1}),
        exported(objectOf(makeLinearSquare({-0.7, 0.3, 0}, 1.6, {0.3, 0, 0.8}, box)), 0.02)};
    objects[0].albedo = {0.3, 0.1, 0.9}, objects[1].albedo = glm::dvec3(1), objects[2].albedo = glm::dvec3(0.5);
    objects[1].coat.assign(objects[1].faces.size(), glm::vec3(0.2f, 0.8f, 1));
    test::expectUniform(seen(objects, eye, even));
}

TEST_F(BentCoats, AMatteFaceSendsBackItsShareEvenly) {
    // Light falls on it at 40 degrees; the eye looks from 0 to 50 degrees and sees the same everywhere.
    const double tilt = 40 * kDegree;
    Eye eye = eyeAt({-0.9, 0, 0}, 70, 17);
    eye.target = {1, 0, 0};
    for (const bool sharp : {false, true}) {
        auto object = blackSlab(1.5, sharp);
        object.albedo = {0.25, 0.5, 1};
        const auto pixels = lit({object}, eye, {std::cos(tilt), std::sin(tilt), 0});
        for (std::size_t i = 0; i < pixels.size(); i += 4)
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(double(pixels[i + std::size_t(c)]), object.albedo[c] * kWatts * std::cos(tilt) / M_PI,
                            2e-4 * kWatts)
                    << sharp << i;
        // From behind it nothing of that light arrives.
        const auto behind = lit({object}, eye, {-std::cos(tilt), std::sin(tilt), 0});
        EXPECT_EQ(behind[4 * (8 * 17 + 8)], 0);
    }
}

TEST_F(BentCoats, TheFarFaceIsSeenThroughTheNearOne) {
    // Straight through a clear plate. Its near face sends a E / pi back; what comes of the far one has lost n^2, a and
    // R on its way, and is the sum over all reflections between them.
    const double n = 1.5, a = 0.4, r = fresnel(1, 1, n);
    Eye eye = eyeAt({-0.6, 0, 0}, 1, 3);
    eye.target = {1, 0, 0};
    BentRayOptions options;
    options.faintest = 1e-6F;
    for (const bool sharp : {false, true}) {
        auto object = slab(n, sharp);
        object.albedo = glm::dvec3(a);
        const auto pixels = lit({object}, eye, {1, 0, 0}, options);
        const double one = a * kWatts / M_PI, far = one / (n * n) / (1 - std::pow((1 - a) * r, 2)),
                     truth = one + (1 - a) * (1 - r) * far;
        EXPECT_NEAR(double(pixels[16]) / truth, 1, 1e-3) << sharp;
    }
}

TEST_F(BentCoats, HighlightsAreWhatGgxSays) {
    const double n = 1.5, roughness = 0.5, alpha = roughness * roughness, tilt = 35 * kDegree;
    const glm::dvec3 normal(-1, 0, 0), to_light = -glm::dvec3(std::cos(tilt), std::sin(tilt), 0);
    Eye eye = eyeAt({-0.9, 0, 0}, 90, 21);
    eye.target = {1, 0, 0};
    for (const bool sharp : {false, true}) {
        auto object = blackSlab(n, sharp);
        object.roughness = roughness;
        const auto pixels = lit({object}, eye, -to_light);
        double brightest = 0;
        for (int y = 0; y < eye.height; ++y)
            for (int x = 0; x < eye.width; ++x) {
                const glm::dvec3 to_eye = -eye.direction(x, y), half = glm::normalize(to_eye + to_light);
                const double nv = glm::dot(normal, to_eye), nl = glm::dot(normal, to_light),
                             nh = glm::dot(normal, half);
                // Walter et al. 2007, eqs. 33 and 34, with both shadowings together (Heitz 2014, eq. 99).
                const double tan2 = 1 / (nh * nh) - 1, a2 = alpha * alpha;
                const double d = a2 / (M_PI * std::pow(nh, 4) * std::pow(a2 + tan2, 2));
                const auto lambda = [&](double c) { return (std::sqrt(1 + a2 * (1 / (c * c) - 1)) - 1) / 2; };
                const double g = 1 / (1 + lambda(nv) + lambda(nl));
                const double truth =
                    fresnel(glm::dot(half, to_light), 1, n) * d * g / (4 * nv * nl) * kWatts * std::cos(tilt);
                const double got = double(pixels[4 * std::size_t(y * eye.width + x)]);
                ASSERT_NEAR(got, truth, 2e-3 * truth + 1e-3) << sharp << x << " " << y;
                brightest = std::max(brightest, got);
            }
        EXPECT_GT(brightest, 3);
    }
}

TEST_F(BentCoats, AHighlightHasTheEnergyOfFresnelsReflection) {
    // Light straight down on a rough face: summed over all directions it is R of it, less what GGX's single scattering
    // loses (some 1 % at this roughness).
    const double n = 1.5;
    auto object = blackSlab(n, true);
    object.roughness = 0.4;
    double sum = 0;
    constexpr int kAngles = 45;
    for (int i = 0; i < kAngles; ++i) {
        const double angle = (i + 0.5) * 90 / kAngles * kDegree;
        Eye eye;
        eye.position = {-0.2 - 0.5 * std::cos(angle), 0.5 * std::sin(angle), 0}, eye.target = {-0.2, 0, 0};
        eye.vertical_degrees = 0.1, eye.width = eye.height = 1;
        const double radiance = double(lit({object}, eye, {1, 0, 0})[0]);
        sum += radiance * std::cos(angle) * 2 * M_PI * std::sin(angle) * 90 / kAngles * kDegree;
    }
    EXPECT_NEAR(sum / (kWatts * fresnel(1, 1, n)), 0.985, 0.025);
    std::printf("highlight: %.4f of Fresnel's reflection\n", sum / (kWatts * fresnel(1, 1, n)));
}

TEST_F(BentCoats, SurroundingsAreThoseThatTheFaceLooksAt) {
    // Radiance (d + 1) / 2 in each channel: a matte face has 1/2 + n / 3 of it.
    constexpr int kWidth = 64, kHeight = 32;
    std::vector<float> texels;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const double up = ((y + 0.5) / kHeight - 0.5) * M_PI, turn = (0.5 - (x + 0.5) / kWidth) * 2 * M_PI;
            for (const double d : {std::cos(up) * std::cos(turn), std::cos(up) * std::sin(turn), std::sin(up)})
                texels.push_back(float(0.5 * d + 0.5));
            texels.push_back(1);
        }
    const DirectionMap directions(gl_);
    Surroundings s = around(directions);
    s.harmonics = environmentHarmonics(texels.data(), kWidth, kHeight);
    auto white = ball(1.5, 0.5, 0.02, 1.5);
    white.albedo = glm::dvec3(1);
    const Eye eye = eyeAt({2.0, 0.4, 0.3}, 34, 40);
    for (const double turn : {0.0, 0.7}) {
        s.turn = float(turn);
        const auto pixels = seen({white}, eye, s);
        int rays = 0;
        for (int y = 0; y < eye.height; ++y)
            for (int x = 0; x < eye.width; ++x) {
                const glm::dvec3 d = eye.direction(x, y);
                const double along = -glm::dot(eye.position, d), miss = glm::length(eye.position + along * d);
                if (miss > 0.45) continue;
                const glm::dvec3 hit = eye.position + (along - std::sqrt(0.25 - miss * miss)) * d, normal = 2.0 * hit;
                const glm::dvec3 turned(std::cos(turn) * normal.x + std::sin(turn) * normal.y,
                                        std::cos(turn) * normal.y - std::sin(turn) * normal.x, normal.z);
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(double(pixels[4 * std::size_t(y * eye.width + x) + std::size_t(c)]),
                                0.5 + turned[c] / 3, 0.02);
                ++rays;
            }
        EXPECT_GT(rays, 300);
    }
}

TEST_F(BentCoats, MayDifferFromPlaceToPlace) {
    Eye eye = eyeAt({-0.9, 0, 0}, 70, 16);
    eye.target = {1, 0, 0};
    auto object = blackSlab(1.5, false);
    for (std::size_t i = 0; i < object.faces.size(); ++i)
        object.coat.emplace_back(i / (41 * 40) < 20 ? glm::vec3(0.4f, 0, 0) : glm::vec3(0, 0.8f, 0));
    const auto pixels = lit({object}, eye, {1, 0, 0});
    for (int y = 0; y < eye.height; ++y)
        for (int x = 0; x < eye.width; ++x) {
            const float* pixel = &pixels[4 * std::size_t(y * eye.width + x)];
            if (y == 7 || y == 8) continue;  // the seam
            EXPECT_NEAR(double(pixel[0]), y < 8 ? 0.4 * kWatts / M_PI : 0, 0.3);
            EXPECT_NEAR(double(pixel[1]), y < 8 ? 0 : 0.8 * kWatts / M_PI, 0.3);
        }
}

TEST_F(BentCoats, WantHarmonicsOfAnEnvironment) {
    auto matte = ball(1.5, 0.2, 0.05, 1);
    matte.albedo = glm::dvec3(0.5);
    auto rough = ball(1.5, 0.2, 0.05, 1);
    rough.roughness = 0.5;
    const DrawnView view(gl_, eyeAt({1, 0, 0}, 40, 8),
                         [](const glm::dvec3&, const glm::dvec3&) { return std::nullopt; });
    auto pass = BentRayPass::create(*gpu_);
    ASSERT_TRUE(pass.ok());
    const DirectionMap directions(gl_);
    auto gpu = GpuIndexVolumes::upload(*gpu_, readBack({matte, rough}));
    ASSERT_TRUE(gpu.ok());
    const Status status = pass->draw(view.surfaces, view.target, *gpu, {{0}}, around(directions));
    ASSERT_FALSE(status.ok());
    EXPECT_NE(status.error().message.find("environmentHarmonics"), std::string::npos) << status.error().message;
    EXPECT_TRUE(pass->draw(view.surfaces, view.target, *gpu, {{1}}, around(directions)).ok());
    Surroundings wrong;
    wrong.harmonics = Harmonics{};
    (*wrong.harmonics)[2][1] = std::nanf("");
    EXPECT_FALSE(pass->draw(view.surfaces, view.target, *gpu, {{1}}, wrong).ok());
}

}  // namespace
}  // namespace photic::test
