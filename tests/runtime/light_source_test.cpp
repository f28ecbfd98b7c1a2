// SPDX-License-Identifier: Apache-2.0
// The switch by which a game falls back where nothing was baked: one receiver pass, whatever the light's source.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "photic/movers.h"
#include "tests/runtime/drawn_scene.h"
#include "tests/runtime/water_fixture.h"
#include "tests/support/pool3.h"

namespace photic::runtime {
namespace {

namespace pool3 = truth::pool3;

class LightSources : public test::WithWater {
protected:
    void SetUp() override {
        test::WithWater::SetUp();
        if (!context_) return;
        const auto gpu = GpuContext::create(context_->loader());
        ASSERT_TRUE(gpu.ok());
        auto made = ReceiverPass::create(*gpu);
        ASSERT_TRUE(made.ok()) << made.error().message;
        pass_.emplace(std::move(made).value());
    }
    void TearDown() override {
        pass_.reset();
        test::WithWater::TearDown();
    }
    std::optional<ReceiverPass> pass_;
};

/// A tilted plate in the pool, seen from above.
struct Plate {
    glm::dvec3 normal = glm::normalize(glm::dvec3(0.2, -0.3, 1));
    test::DrawnView view{glm::perspective(0.6f, 1.0f, 0.1f, 10.0f) *
                             glm::lookAt(glm::vec3(0.1f, 0.2f, 2), glm::vec3(0, 0, -1), glm::vec3(0, 1, 0)),
                         {0.1f, 0.2f, 2}};
    test::DrawnPoint operator()(const glm::dvec3& near, const glm::dvec3& far) const {
        const double t = glm::dot(glm::dvec3(0, 0, -1) - near, normal) / glm::dot(far - near, normal);
        test::DrawnPoint p;
        p.position = glm::vec3(near + t * (far - near));
        p.normal = glm::vec3(normal);
        p.albedo = {0.5f, 0.25f, 1};
        p.drawn = p.position.x < 0.3f;
        return p;
    }
};

TEST_F(LightSources, ReceiversAreLitByWhatTheSwitchSays) {
    fill(test::pool3Water(128));
    WaterLight light = test::pool3Light();
    light.irradiance[2] = 3;
    ASSERT_TRUE(water_->setLight(light).ok());
    CausticMapOptions map;
    map.bottom = -1.5f, map.resolution = 256, map.full_precision = true;
    const Plate plate;
    const test::DrawnScene scene(gl_, plate.view, 32, 32, plate);

    std::vector<float> radiance[2];
    for (const bool mapped : {false, true}) {
        if (mapped) {
            ASSERT_TRUE(water_->updateCausticMap(map).ok());
        }
        const LightSource source = mapped ? LightSource::CausticMap : LightSource::Lookup;
        ASSERT_TRUE(pass_->drawLit(scene.gbuffer(), scene.target(), {source, {}, &*water_}).ok());
        radiance[mapped] = scene.read();
        // Best takes the map as soon as there is one.
        ASSERT_TRUE(pass_->drawLit(scene.gbuffer(), scene.target(), {LightSource::Best, {}, &*water_}).ok());
        EXPECT_EQ(scene.read(), radiance[mapped]);
    }
    EXPECT_NE(radiance[0], radiance[1]);

    // Each pixel against the same function at the position that the depth texture holds.
    for (const bool mapped : {false, true}) {
        int drawn = 0;
        for (int i = 0; i < 32 * 32; i += 101) {
            const auto k = static_cast<std::size_t>(i);
            const glm::dvec3 p = scene.positions()[k];
            const float* pixel = &radiance[mapped][4 * k];
            if (p.x >= 0.3) {
                EXPECT_EQ(pixel[0], 0) << "nothing is drawn there";
                continue;
            }
            const std::string at = "(vec3(" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " +
                                   std::to_string(p.z) + "), normalize(vec3(0.2, -0.3, 1.0)))";
            const auto direct = test::evaluate(
                gl_, mapped ? "photic_caustic_map.glsl" : "photic_water_lookup.glsl",
                "vec4(" + std::string(mapped ? "photicCausticIrradiance" : "photicLookupIrradiance") + at + ", 0)", 1,
                1, [&](const Uniforms& u) {
                    mapped ? water_->impl().setCausticMap(u, 0) : water_->impl().setLookup(u, 0);
                });
            const float albedo[3] = {0.5f, 0.25f, 1};
            for (std::size_t c = 0; c < 3; ++c) {
                const double expected = direct[c] * albedo[c] / std::numbers::pi;
                EXPECT_NEAR(pixel[c], expected, 1e-3 * expected + 1e-4) << i << " channel " << c;
            }
            drawn += pixel[2] > 0;
        }
        EXPECT_GT(drawn, 4);
    }
}

TEST_F(LightSources, IrradianceAndScaleAreThoseOfVolumes) {
    fill(test::pool3Water(64));
    const Plate plate;
    const test::DrawnScene scene(gl_, plate.view, 16, 16, plate);
    const Lighting lighting{LightSource::Lookup, {}, &*water_};
    ASSERT_TRUE(pass_->drawLit(scene.gbuffer(), scene.target(), lighting).ok());
    const auto radiance = scene.read();
    ASSERT_TRUE(pass_->drawLit(scene.gbuffer(), scene.target(), lighting, {ReceiverOutput::Irradiance, 2}).ok());
    const auto irradiance = scene.read();
    for (std::size_t i = 0; i < radiance.size(); i += 4) {
        EXPECT_NEAR(irradiance[i], 2 * radiance[i] / 0.5 * std::numbers::pi, 1e-5);
    }
}

// Movers darken light that nobody baked as they darken baked light: along its way back, to the sun above the water.
TEST_F(LightSources, MoversDarkenItToo) {
    const test::SampledWater still = test::sampleWater(64, [](double, double) { return 0.0; });
    fill(still);
    WaterLight light = test::pool3Light();
    ASSERT_TRUE(water_->setLight(light).ok());
    CausticMapOptions map;
    map.bottom = -1.5f, map.resolution = 64, map.full_precision = true;
    ASSERT_TRUE(water_->updateCausticMap(map).ok());
    const Plate plate;
    const test::DrawnScene scene(gl_, plate.view, 32, 32, plate);
    // Light in still water (Snell), and a ball in it, half of it above the water.
    const double x = double(light.direction[0]) / double(light.ior), y = double(light.direction[1]) / double(light.ior);
    const Vec3 down{x, y, -std::sqrt(1 - x * x - y * y)};
    Movers movers;
    movers.shapes = {sphere({0.1, 0, -0.6}, 0.15), sphere({-0.2, 0.1, 0}, 0.1)};
    movers.surface[3] = double(still.water.level), movers.ior = double(light.ior);
    movers.sun = {double(light.direction[0]), double(light.direction[1]), double(light.direction[2])};
    ReceiverOptions shaded;
    shaded.shadows.movers = &movers;
    for (const LightSource source : {LightSource::CausticMap, LightSource::Lookup}) {
        ASSERT_TRUE(pass_->drawLit(scene.gbuffer(), scene.target(), {source, {}, &*water_}).ok());
        const auto bright = scene.read();
        const Status done = pass_->drawLit(scene.gbuffer(), scene.target(), {source, {}, &*water_}, shaded);
        ASSERT_TRUE(done.ok()) << done.error().message;
        const auto dim = scene.read();
        int dark = 0, open = 0;
        for (std::size_t i = 0; i < bright.size() / 4; ++i) {
            if (!(bright[4 * i] > 0)) continue;
            const glm::dvec3 p = scene.positions()[i];
            const double passes = passesMovers(movers, {p.x, p.y, p.z}, down, 1);
            ASSERT_NEAR(double(dim[4 * i]) / double(bright[4 * i]), passes, 0.02) << i;
            if (passes < 0.01) ++dark;
            if (passes > 0.99) ++open;
        }
        EXPECT_GT(dark, 10);
        EXPECT_GT(open, 100);
    }
}

TEST_F(LightSources, GodRaysFollowTheirFunction) {
    fill(test::pool3Water(64));
    LookupOptions lookup;
    lookup.plane_distance = 0.1f, lookup.ray_strength = 0.7f;
    ASSERT_TRUE(water_->setLookup(lookup).ok());
    const Plate plate;
    const test::DrawnScene scene(gl_, plate.view, 16, 16, plate);
    ASSERT_TRUE(water_->drawGodRays(scene.gbuffer(), scene.target()).ok());
    const auto drawn = scene.read();
    int lit = 0;
    for (const std::size_t i : {std::size_t{17}, std::size_t{100}, std::size_t{211}}) {
        const glm::dvec3 p = scene.positions()[i], eye(plate.view.eye);
        const auto text = [](const glm::dvec3& v) {
            return "vec3(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + ")";
        };
        const auto gamma = test::evaluate(gl_, "photic_water_lookup.glsl",
                                          "vec4(photicGodRays(" + text(eye) + ", normalize(" + text(p - eye) + "), " +
                                              std::to_string(glm::length(p - eye)) + "))",
                                          1, 1, [&](const Uniforms& u) { water_->impl().setLookup(u, 0); });
        EXPECT_NEAR(drawn[4 * i], 0.7 * gamma[0], 0.01 * gamma[0] + 1e-4) << i;
        lit += gamma[0] > 0.05f;
    }
    EXPECT_GT(lit, 0);
}

// Each sample of a god ray is as dark as a receiver would be there: by the sum over crossings, one by one, in double.
TEST_F(LightSources, MoversDarkenGodRays) {
    fill(test::sampleWater(16, [](double, double) { return 0.0; }));
    LookupOptions lookup;
    lookup.plane_distance = 0.08f, lookup.plane_fade = 0.2f, lookup.plane_samples = 64;
    ASSERT_TRUE(water_->setLookup(lookup).ok());
    const WaterLight sun = test::pool3Light();
    const glm::dvec3 travel(sun.direction[0], sun.direction[1], sun.direction[2]);
    const glm::dvec3 light = test::refracted(glm::normalize(travel), {0, 0, 1}, 1, double(sun.ior));
    Movers movers;
    movers.shapes = {sphere({0.05, 0.05, -0.3}, 0.15), box({-0.2, -0.1, 0.1}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.05})};
    movers.surface[3] = 0, movers.ior = double(sun.ior), movers.sun = {travel.x, travel.y, travel.z};
    const Plate plate;
    const test::DrawnScene scene(gl_, plate.view, 32, 32, plate);
    ASSERT_TRUE(water_->drawGodRays(scene.gbuffer(), scene.target()).ok());
    const auto bright = scene.read();
    const Status done = water_->drawGodRays(scene.gbuffer(), scene.target(), {&movers, 0});
    ASSERT_TRUE(done.ok()) << done.error().message;
    const auto dim = scene.read();
    double taken = 0, lit = 0, apart = 0;
    for (std::size_t i = 0; i < bright.size() / 4; ++i) {
        const glm::dvec3 p = scene.positions()[i], eye(plate.view.eye), way = glm::normalize(p - eye);
        const double start = -eye.z / way.z, end = glm::length(p - eye);
        std::vector<double> crossings;
        for (int axis = 0; axis < 2; ++axis) {
            const double lean = light[axis] / light.z, at = eye[axis] - lean * eye.z, rate = way[axis] - lean * way.z;
            for (int k = -100; k <= 100; ++k) {
                const double t = (k * 0.08 - at) / rate;
                if (t > start && t < end) crossings.push_back(t);
            }
        }
        std::sort(crossings.begin(), crossings.end());
        double sum = 0;
        for (const double t : crossings) {
            const glm::dvec3 q = eye + t * way;
            const double part = std::clamp(-q.z / 0.2, 0.0, 1.0);
            sum += part * part * (3 - 2 * part) * passesMovers(movers, {q.x, q.y, q.z}, {light.x, light.y, light.z}, 1);
        }
        const double gamma = crossings.empty() ? 0 : sum / (crossings.back() - start);
        lit += gamma, taken += double(bright[4 * i]) - gamma, apart += std::fabs(double(dim[4 * i]) - gamma);
    }
    EXPECT_GT(taken, 0.03 * lit);
    EXPECT_LT(apart, 1e-3 * lit);
    RecordProperty("apart", std::to_string(apart / lit));
    // What makes no sense is refused, and so is a map that is not there.
    movers.map.columns = movers.map.rows = 8, movers.map.across = {1, 0, 0}, movers.map.up = {0, 1, 0};
    movers.map.direction = {0, 0, -1};
    const Status refused = water_->drawGodRays(scene.gbuffer(), scene.target(), {&movers, 0});
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find("MoverShadows::map"), std::string::npos);
}

TEST_F(LightSources, WhatIsNotThereIsRefused) {
    const Plate plate;
    const test::DrawnScene scene(gl_, plate.view, 4, 4, plate);
    EXPECT_FALSE(pass_->drawLit(scene.gbuffer(), scene.target(), {LightSource::Best, {}, nullptr}).ok());
    EXPECT_FALSE(pass_->drawLit(scene.gbuffer(), scene.target(), {LightSource::Lookup, {}, &*water_}).ok())
        << "no heights yet";
    fill(test::pool3Water(16));
    EXPECT_FALSE(pass_->drawLit(scene.gbuffer(), scene.target(), {LightSource::CausticMap, {}, &*water_}).ok());
    EXPECT_TRUE(pass_->drawLit(scene.gbuffer(), scene.target(), {LightSource::Best, {}, &*water_}).ok());
}

}  // namespace
}  // namespace photic::runtime
