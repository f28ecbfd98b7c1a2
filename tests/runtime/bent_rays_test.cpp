// SPDX-License-Identifier: Apache-2.0
// What Fresnel's faces, absorption and emission take and give, and what must not change: uniform surroundings, skipped
// space.
#include "tests/runtime/bent_fixture.h"

namespace photic::test {
namespace {

/// Three objects that take and add no light: a ball with a face, another behind it, and a slab with sharp sides.
std::vector<IndexVolumeObject> clearObjects() {
    Monitor monitor;
    const WorldBox box{{-0.9, 0.15, -0.3}, {-0.5, 0.5, 0.3}};
    return {ball(1.5, 0.4, 0.02, 1.5), ball(1.3, 0.2, 0.02, 1.5, {-0.6, -0.4, 0.1}),
            exported(objectOf(makeLinearSquare({-0.7, 0.3, 0}, 1.6, {0.3, 0, 0.8}, box)), 0.02)};
}

TEST_F(BentRays, UniformSurroundingsStayUniformThroughAnyLosslessIndex) {
    const Eye eye = eyeAt({1.6, 0.1, 0.15}, 45, 48);
    Surroundings even;
    even.colour[0] = 1, even.colour[1] = 2, even.colour[2] = 0.5;
    for (const int branches : {0, 4})
        for (const IndexLookup lookup : {IndexLookup::Spline, IndexLookup::Gradients}) {
            BentRayOptions options;
            options.branches = branches, options.lookup = lookup;
            test::expectUniform(seen(clearObjects(), eye, even, options));
        }
}

TEST_F(BentRays, UniformSurroundingsStayUniformForAnEyeInGlassToo) {
    // n_eye^2 of the radiance in the air; the paper's form leaves it out.
    const Eye eye = eyeAt({0.15, 0.05, 0.1}, 70, 24);
    Surroundings even;
    const auto pixels = seen({ball(1.5, 0.4, 0.02, 1.5)}, eye, even);
    BentRayOptions paper;
    paper.radiance = BentRadiance::Paper;
    const auto without = seen({ball(1.5, 0.4, 0.02, 1.5)}, eye, even, paper);
    for (std::size_t i = 0; i < pixels.size(); i += 4) {
        EXPECT_NEAR(pixels[i], 2.25, 1e-3);
        EXPECT_NEAR(without[i], 1, 1e-4);
    }
}

TEST_F(BentRays, ASlabReflectsWhatFresnelsEquationsSay) {
    // Looking along +x and up to 55 degrees off it: what a plate lets through is (1 - R) / (1 + R), all bounces in it
    // together; four branches follow those that count.
    // Dark on the side that the slab is looked at from, 1 behind it: the middle of the map is along +x.
    const EnvironmentMap half(gl_, 4, 1, {0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 1}, GL_NEAREST);
    Eye eye = eyeAt({-0.6, 0, 0}, 80, 33);
    eye.target = {1, 0, 0};
    for (const bool sharp : {false, true}) {
        Surroundings s;
        s.environment = half.texture;
        BentRayOptions options;
        options.faintest = 1e-4F;
        const auto pixels = seen({slab(1.6, sharp)}, eye, s, options);
        double worst = 0;
        for (int y = 0; y < eye.height; ++y)
            for (int x = 0; x < eye.width; ++x) {
                const double cosine = eye.direction(x, y).x, r = fresnel(cosine, 1, 1.6);
                const double truth = (1 - r) / (1 + r), got = double(pixels[4 * std::size_t(y * eye.width + x)]);
                worst = std::max(worst, std::fabs(got - truth));
            }
        EXPECT_LT(worst, sharp ? 1e-3 : 4e-3) << (sharp ? "sharp" : "smooth");
        std::printf("slab, %s: transmittance off by %.5f at most\n", sharp ? "sharp" : "smooth", worst);
    }
}

TEST_F(BentRays, ASlabTakesWhatBeerAndLambertSay) {
    Eye eye = eyeAt({-0.6, 0, 0}, 60, 17);
    eye.target = {1, 0, 0};
    // Dark on the side that the slab is looked at from, 1 behind it: the middle of the map is along +x.
    const EnvironmentMap half(gl_, 4, 1, {0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 1}, GL_NEAREST);
    Surroundings s;
    s.environment = half.texture;
    const auto pixels = seen({slab(1.6, true, 2)}, eye, s);
    for (int y = 0; y < eye.height; ++y)
        for (int x = 0; x < eye.width; ++x) {
            const double cosine = eye.direction(x, y).x, r = fresnel(cosine, 1, 1.6);
            const double inside = std::sqrt(1 - (1 - cosine * cosine) / (1.6 * 1.6)),
                         left = std::exp(-2 * 0.4 / inside);
            const double truth = (1 - r) * (1 - r) * left / (1 - r * r * left * left);
            const float* pixel = &pixels[4 * std::size_t(y * eye.width + x)];
            EXPECT_NEAR(double(pixel[0]), truth, 2e-3);
            EXPECT_NEAR(double(pixel[1]), (1 - r) / (1 + r), 2e-3) << "the other channels are clear";
        }
}

TEST_F(BentRays, PassingOverEvenSpaceChangesNoBit) {
    const Eye eye = eyeAt({1.6, 0.1, 0.15}, 45, 48);
    const DirectionMap directions(gl_);
    auto objects = clearObjects();
    // One absorbs and shines: in its even inside stretches of many steps are one.
    for (auto& object : {&objects[0]})
        for (const float e : object->spline[0])
            object->attenuation.emplace_back(4 * e, e, 0, e > 0 ? 1 : 0), object->glow.emplace_back(e, 0, 2 * e, 0);
    for (const IndexLookup lookup : {IndexLookup::Spline, IndexLookup::Gradients}) {
        BentRayOptions options;
        options.lookup = lookup;
        const auto with = seen(objects, eye, around(directions), options);
        options.skipping = BentSkipping::None;
        const auto without = seen(objects, eye, around(directions), options);
        std::size_t different = 0, touched = 0;
        for (std::size_t i = 0; i < with.size(); ++i) different += with[i] != without[i], touched += with[i] >= 0;
        EXPECT_EQ(different, 0U);
        EXPECT_GT(touched, 1000U);
    }
}

TEST_F(BentRays, AnObjectShinesAndDisperses) {
    const Eye eye = eyeAt({1.6, 0, 0}, 45, 33);
    auto shining = slab(1, true, 0);  // no index, only light: 3 W/(m3 sr) over 0.4 m
    for (int i = 0; i < 41 * 40 * 40; ++i) shining.glow.emplace_back(3, 0, 0, 0);
    Surroundings dark;
    for (float& c : dark.colour) c = 0;
    const auto pixels = seen({shining}, eye, dark);
    const std::size_t middle = 4 * (16 * 33 + 16);
    EXPECT_NEAR(pixels[middle], 1.2, 1e-3);
    EXPECT_EQ(pixels[middle + 1], 0);

    const DirectionMap directions(gl_);
    auto prism = ball(1.5, 0.5, 0.02, 1.5);
    prism.faces.clear();
    auto alone = prism;
    prism.spline.push_back(ball(1.52, 0.5, 0.02, 1.5).spline[0]);
    prism.spline.push_back(ball(1.56, 0.5, 0.02, 1.5).spline[0]);
    const auto split = seen({prism}, eye, around(directions));
    for (std::size_t c = 0; c < 3; ++c) {
        alone.spline[0] = prism.spline[c];
        const auto one = seen({alone}, eye, around(directions));
        for (std::size_t i = c; i < one.size(); i += 4) ASSERT_EQ(split[i], one[i]) << c;
    }
    BentRayOptions options;
    options.disperses = false;
    EXPECT_NE(seen({prism}, eye, around(directions), options), split);
}

TEST_F(BentRays, PlacesAreAffineAndObjectsAreSeenThroughObjects) {
    const DirectionMap directions(gl_);
    const Eye eye = eyeAt({1.6, 0, 0}, 45, 33);
    // The same ball, put where the other one has been exported to.
    PlacedObject moved;
    moved.world_from_object = {1.25F, 0, 0, 0, 0, 1.25F, 0, 0, 0, 0, 1.25F, 0, -0.1F, 0.2F, 0.05F, 1};
    const auto a = seen({ball(1.5, 0.4, 0.02, 1.5)}, eye, around(directions), {}, {moved});
    const auto b = seen({ball(1.5, 0.5, 0.025, 1.5, {-0.1, 0.2, 0.05})}, eye, around(directions));
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, double(std::fabs(a[i] - b[i])));
    EXPECT_LT(worst, 0.02);
    // Two balls one behind the other are those of both formulas together: the second has no face to lose light at.
    const auto front = ball(1.5, 0.3, 0.02, 1.5, {0.6, 0, 0});
    const auto one = seen({front}, eye, around(directions));
    const auto two = seen({front, ball(1.4, 0.4, 0.02, 1.5, {-0.5, 0, 0})}, eye, around(directions));
    EXPECT_GT(std::fabs(one[4 * (16 * 33 + 21) + 1] - two[4 * (16 * 33 + 21) + 1]), 0.01);
}

TEST_F(BentRays, RefusesWhatMakesNoSense) {
    const auto volumes = readBack({ball(1.5, 0.2, 0.05, 1)});
    auto gpu = GpuIndexVolumes::upload(*gpu_, volumes);
    auto pass = BentRayPass::create(*gpu_);
    ASSERT_TRUE(gpu.ok() && pass.ok());
    const DrawnView view(gl_, eyeAt({1, 0, 0}, 40, 8),
                         [](const glm::dvec3&, const glm::dvec3&) { return std::nullopt; });
    const auto refused = [&](const std::vector<PlacedObject>& placed, const BentRayOptions& options, const char* word) {
        const Status status = pass->draw(view.surfaces, view.target, *gpu, placed, {}, {}, options);
        ASSERT_FALSE(status.ok());
        EXPECT_EQ(status.error().code, runtime::ErrorCode::Usage);
        EXPECT_NE(status.error().message.find(word), std::string::npos) << status.error().message;
    };
    refused({}, {}, "1 to 16");
    refused({{1, {}}}, {}, "no index volume 1");
    PlacedObject flat;
    flat.world_from_object[0] = 0;
    refused({flat}, {}, "no inverse");
    BentRayOptions options;
    options.step = 0;
    refused({{}}, options, "step");
    EXPECT_EQ(GpuIndexVolumes::upload(*gpu_, {}).error().code, runtime::ErrorCode::Usage);
}

}  // namespace
}  // namespace photic::test
