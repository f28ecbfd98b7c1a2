// SPDX-License-Identifier: Apache-2.0
// Warped caustic volumes drawn over a scene: against their own definition in double, triangle by triangle; against the
// exact floor; and in-scatter against its closed form.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <numbers>

#include "photic/movers.h"
#include "runtime/src/water_slopes.h"
#include "tests/runtime/drawn_scene.h"
#include "tests/runtime/water_fixture.h"
#include "tests/support/closed_forms.h"
#include "tests/support/pool3.h"

namespace photic::runtime {
namespace {

namespace pool3 = truth::pool3;
constexpr double kPi = std::numbers::pi;

/// Shows the level plane z under every line of sight.
auto floorAt(double z) {
    return [z](const glm::dvec3& near, const glm::dvec3& far) {
        const double t = (z - near.z) / (far.z - near.z);
        test::DrawnPoint p;
        p.position = glm::vec3(near + t * (far - near));
        return p;
    };
}

test::DrawnView viewFromAbove(double half) {
    const glm::vec3 eye(0, 0, 3);
    const float h = static_cast<float>(half);
    return test::DrawnView{glm::ortho(-h, h, -h, h, 0.5f, 6.0f) * glm::lookAt(eye, {0, 0, 0}, {0, 1, 0}), eye};
}

class WarpedVolumes : public test::WithWater {
protected:
    /// Irradiance on white receivers [W/m2], or radiance x pi where the water scatters.
    std::vector<double> draw(const test::DrawnScene& scene, const test::DrawnView& view,
                             const WarpedVolumesOptions& options) {
        const auto drawn =
            water_->drawWarpedVolumes(scene.gbuffer(), glm::value_ptr(view.clip_from_world), scene.target(), options);
        EXPECT_TRUE(drawn.ok()) << drawn.error().message;
        auto values = test::channel(scene.read(), 0);
        for (double& v : values) v *= kPi;
        return values;
    }
};

/// The irradiance on a level receiver by the paper's sections 3.2 and 3.3, over all triangles of the mesh; `step`
/// samples between vertices; pool3's surface and sun.
/// @param movers  what each triangle's light passes by, if anything
double byDefinition(const test::SampledWater& sampled, int step, const glm::dvec3& p, const Movers* movers = nullptr) {
    static const auto texels = waterTexels(sampled.water);
    const int side = sampled.water.columns, rim = 8, count = (side + 2 * rim - 1) / step;
    const auto vertex = [&](int i, int j, glm::dvec3& position, glm::dvec3& ray) {
        const double spacing = 4.0 / side;
        const int a = i * step - rim, b = j * step - rim;
        const bool inside = a >= 0 && b >= 0 && a < side && b < side;
        const float* t = inside ? &texels->values[static_cast<std::size_t>(b * side + a) * 4] : nullptr;
        position = {-2 + (a + 0.5) * spacing, -2 + (b + 0.5) * spacing, t ? t[0] : 0};
        const glm::dvec3 normal = glm::normalize(t ? glm::dvec3(-t[1], -t[2], 1) : glm::dvec3(0, 0, 1));
        ray = test::refracted(pool3::sun(), normal, 1, pool3::kIor);
        const double across = -glm::dot(pool3::sun(), normal);
        return across / normal.z * truth::fresnelTransmittance(across, 1, pool3::kIor);
    };
    double sum = 0;
    for (int j = 0; j < count; ++j) {
        for (int i = 0; i < count; ++i) {
            if (std::hypot(-2 + (i * step - rim) * 4.0 / side - p.x, -2 + (j * step - rim) * 4.0 / side - p.y) > 1.9)
                continue;
            for (int half = 0; half < 2; ++half) {
                glm::dvec3 v[3], r[3];
                const double power = (vertex(i, j, v[0], r[0]) + vertex(i + 1, j + 1, v[1], r[1]) +
                                      vertex(i + 1 - half, j + half, v[2], r[2])) /
                                     3 * 0.5 * std::pow(4.0 * step / side, 2);
                glm::dvec3 normal = glm::normalize(glm::cross(v[1] - v[0], v[2] - v[0]));
                if (normal.z > 0) normal = -normal;
                const double alpha = glm::dot(p - v[0], normal);
                if (alpha < 0) continue;
                glm::dvec3 c[3];
                for (int k = 0; k < 3; ++k) c[k] = v[k] + r[k] * (alpha / glm::dot(r[k], normal));
                glm::dvec3 beta;
                for (int k = 0; k < 3; ++k) {
                    beta[k] = glm::dot(glm::cross(c[(k + 1) % 3] - p, c[(k + 2) % 3] - p), normal);
                }
                const double least = std::min({beta.x, beta.y, beta.z}), most = std::max({beta.x, beta.y, beta.z});
                if (least < 0 && most > 0) continue;
                const double total = beta.x + beta.y + beta.z;
                glm::dvec3 mean{0};
                for (int k = 0; k < 3; ++k) mean += beta[k] / total * r[k] / glm::dot(r[k], normal);
                const glm::dvec3 w = glm::normalize(mean);
                const double passes = movers ? passesMovers(*movers, {p.x, p.y, p.z}, {w.x, w.y, w.z}, 1) : 1;
                sum += passes * power / (0.5 * std::fabs(total)) / glm::dot(w, normal) * -w.z;
            }
        }
    }
    return sum;
}

TEST_F(WarpedVolumes, EqualTheirDefinition) {
    const auto sampled = test::pool3Water(64);
    fill(sampled);
    const test::DrawnView view = viewFromAbove(0.6);
    const test::DrawnScene scene(gl_, view, 48, 48, floorAt(pool3::kFloor));
    WarpedVolumesOptions options;
    options.bottom = -1.6f;
    const auto drawn = draw(scene, view, options);
    int apart = 0;
    double sum_drawn = 0, sum_defined = 0;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
        const double defined = byDefinition(sampled, 1, scene.positions()[i]);
        sum_drawn += drawn[i], sum_defined += defined;
        apart += std::fabs(drawn[i] - defined) > 2e-3 * defined;
    }
    EXPECT_NEAR(sum_drawn / sum_defined, 1, 0.01);
    // A point on the very side of a volume may fall to either neighbour.
    EXPECT_LT(apart, static_cast<int>(drawn.size() / 100)) << "of " << drawn.size();
}

TEST_F(WarpedVolumes, LookAlikeFromEverySide) {
    // Parallel or perspective, mirrored or not, eye in the volumes or outside: the same light on the same points.
    const auto sampled = test::pool3Water(64);
    fill(sampled);
    WarpedVolumesOptions options;
    options.bottom = -1.6f;
    const glm::mat4 lens = glm::perspective(0.9f, 1.0f, 0.05f, 20.0f), mirror = glm::scale(glm::mat4(1), {1, -1, 1});
    const glm::vec3 above(0.3f, -1.2f, 1.5f), inside(0.2f, 0.1f, -0.6f), target(0, 0, -1.5f);
    const test::DrawnView views[] = {test::DrawnView{lens * glm::lookAt(above, target, {0, 0, 1}), above},
                                     test::DrawnView{mirror * lens * glm::lookAt(above, target, {0, 0, 1}), above},
                                     test::DrawnView{lens * glm::lookAt(inside, target, {0, 1, 0}), inside}};
    for (std::size_t k = 0; k < 3; ++k) {
        const test::DrawnScene scene(gl_, views[k], 32, 32, floorAt(pool3::kFloor));
        const auto drawn = draw(scene, views[k], options);
        int apart = 0, counted = 0;
        for (std::size_t i = 0; i < drawn.size(); ++i) {
            const glm::dvec3 p = scene.positions()[i];
            if (std::fabs(p.x) > 0.9 || std::fabs(p.y) > 0.9) continue;
            const double defined = byDefinition(sampled, 1, p);
            apart += std::fabs(drawn[i] - defined) > 5e-3 * defined;
            ++counted;
        }
        EXPECT_GT(counted, 150) << k;
        EXPECT_LT(apart, 1 + counted / 50) << "view " << k << ", of " << counted;
    }
}

TEST_F(WarpedVolumes, ConvergeToTheExactFloor) {
    const auto exact = pool3::exactFloor();
    fill(test::pool3Water(256));
    const test::DrawnView view = viewFromAbove(0.5);
    // 512 pixels of the map over 2 m: its middle quarter, 4 points a pixel.
    constexpr int kPixels = 256;
    const test::DrawnScene scene(gl_, view, 2 * kPixels, 2 * kPixels, floorAt(pool3::kFloor));
    double last = 1;
    for (const int step : {8, 4, 2}) {
        WarpedVolumesOptions options;
        options.bottom = -1.6f, options.step = step;
        const auto drawn = draw(scene, view, options);
        std::vector<double> mine(kPixels * kPixels), truth(kPixels * kPixels);
        for (int j = 0; j < kPixels; ++j) {
            for (int i = 0; i < kPixels; ++i) {
                const auto at = [&](int a, int b) {
                    return drawn[static_cast<std::size_t>((2 * j + b) * 2 * kPixels + 2 * i + a)];
                };
                mine[static_cast<std::size_t>(j * kPixels + i)] = (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4;
                truth[static_cast<std::size_t>(j * kPixels + i)] = exact.at(128 + i, 128 + j);
            }
        }
        const auto like = test::likeness(mine, truth);
        std::printf("warped volumes, %d a side: correlation %.4f, energy %.4f, relative L1 %.4f\n", 256 / step,
                    like.correlation, like.energy, like.relative_l1);
        EXPECT_NEAR(like.energy, 1, 0.05) << step;
        EXPECT_LT(like.relative_l1, 0.85 * last) << step;
        last = like.relative_l1;
    }
}

TEST_F(WarpedVolumes, InScatterInStillWaterIsItsIntegral) {
    // Light straight down in still water, a line of sight s from the eye at depth d: the integral of
    // sigma_s p E0 T exp(-sigma_t (s + d(s))).
    fill(test::sampleWater(64, [](double, double) { return 0.0; }));
    WaterLight light = test::pool3Light();
    light.direction[0] = light.direction[1] = 0, light.direction[2] = -1;
    for (float& x : light.extinction) x = 0.3f;
    ASSERT_TRUE(water_->setLight(light).ok());
    const glm::vec3 eye(-0.8f, 0.1f, -0.5f);
    const test::DrawnView view = test::DrawnView{
        glm::perspective(0.7f, 1.0f, 0.05f, 20.0f) * glm::lookAt(eye, glm::vec3(0.5f, 0, -0.8f), {0, 0, 1}), eye};
    // A black wall at x = 1, so that only the water shines.
    const test::DrawnScene scene(gl_, view, 24, 24, [](const glm::dvec3& near, const glm::dvec3& far) {
        test::DrawnPoint p;
        p.position = glm::vec3(near + (1.0 - near.x) / (far.x - near.x) * (far - near));
        p.normal = {-1, 0, 0}, p.albedo = glm::vec3(0);
        return p;
    });
    WarpedVolumesOptions options;
    options.bottom = -2.5f;
    for (float& x : options.scattering) x = 0.1f;
    options.anisotropy = 0.6f;
    auto drawn = draw(scene, view, options);
    const double g = 0.6f, transmittance = truth::fresnelTransmittance(1, 1, pool3::kIor);
    double worst = 0;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
        const glm::dvec3 to = scene.positions()[i] - glm::dvec3(eye);
        const double length = glm::length(to), down = to.z / length;  // dz per metre of sight
        // Travel (0, 0, -1) against the direction towards the eye, -to.
        const double k = 1 + g * g - 2 * g * (down);
        const double phase = (1 - g * g) / (4 * kPi * k * std::sqrt(k));
        const double rate = 0.3 * (1 - down), integral = std::exp(-0.3 * 0.5) * -std::expm1(-rate * length) / rate;
        const double expected = 0.1 * phase * transmittance * integral;
        worst = std::max(worst, std::fabs(drawn[i] / kPi / expected - 1));
    }
    EXPECT_LT(worst, 0.01);
}

/// A ball under the waves, and a board that floats on them.
Movers ballAndBoard() {
    Movers movers;
    movers.shapes = {sphere({0.1, 0.05, -0.9}, 0.15), box({-0.3, -0.2, 0.1}, {0.1, 0, 0}, {0, 0.15, 0}, {0, 0, 0.03})};
    movers.surface[3] = 0, movers.ior = pool3::kIor;
    const glm::dvec3 sun = pool3::sun();
    movers.sun = {sun.x, sun.y, sun.z};
    return movers;
}

// Where sheets of light cross, each is darkened along its own way.
TEST_F(WarpedVolumes, MoversDarkenEachBeamByItself) {
    const auto sampled = test::pool3Water(64);
    fill(sampled);
    const Movers movers = ballAndBoard();
    const test::DrawnView view = viewFromAbove(0.6);
    const test::DrawnScene scene(gl_, view, 40, 40, floorAt(pool3::kFloor));
    WarpedVolumesOptions options;
    options.bottom = -1.6f;
    const auto bright = draw(scene, view, options);
    options.shadows.movers = &movers;
    const auto drawn = draw(scene, view, options);
    int apart = 0;
    double taken = 0, light = 0;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
        const double defined = byDefinition(sampled, 1, scene.positions()[i], &movers);
        taken += bright[i] - drawn[i], light += bright[i];
        apart += std::fabs(drawn[i] - defined) > 2e-3 * bright[i];
    }
    EXPECT_GT(taken, 0.05 * light);
    // A point on the very side of a volume may fall to either neighbour.
    EXPECT_LT(apart, static_cast<int>(drawn.size() / 100)) << "of " << drawn.size();
}

// A shaft of shadow in still water, seen from within it: against the integral along each line of sight.
TEST_F(WarpedVolumes, MoversThrowShaftsIntoTheWater) {
    fill(test::sampleWater(64, [](double, double) { return 0.0; }));
    WaterLight light = test::pool3Light();
    for (float& x : light.extinction) x = 0.3f;
    ASSERT_TRUE(water_->setLight(light).ok());
    Movers movers = ballAndBoard();
    movers.shapes[0].centre = {0.2, 0.1, -0.4};
    const glm::dvec3 eye(-0.8f, 0.1f, -0.5f);
    const test::DrawnView view = test::DrawnView{
        glm::perspective(0.9f, 1.0f, 0.05f, 20.0f) * glm::lookAt(glm::vec3(eye), glm::vec3(0.5f, 0, -0.8f), {0, 0, 1}),
        glm::vec3(eye)};
    const test::DrawnScene scene(gl_, view, 24, 24, [](const glm::dvec3& near, const glm::dvec3& far) {
        test::DrawnPoint p;
        p.position = glm::vec3(near + (1.0 - near.x) / (far.x - near.x) * (far - near));
        p.normal = {-1, 0, 0}, p.albedo = glm::vec3(0);
        return p;
    });
    WarpedVolumesOptions options;
    options.bottom = -2.5f;
    for (float& x : options.scattering) x = 0.1f;
    const auto bright = draw(scene, view, options);
    options.shadows.movers = &movers;
    const auto drawn = draw(scene, view, options);
    const glm::dvec3 down = test::refracted(pool3::sun(), {0, 0, 1}, 1, pool3::kIor);
    const double fluence =
        truth::fresnelTransmittance(-pool3::sun().z, 1, pool3::kIor) * pool3::sun().z / down.z / (4 * kPi);
    double taken = 0, sum = 0, apart = 0;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
        const glm::dvec3 to = scene.positions()[i] - eye;
        const double length = glm::length(to), end = to.z > 0 ? std::min(length, -eye.z / (to.z / length)) : length;
        double integral = 0;
        constexpr int kSteps = 4000;
        for (int k = 0; k < kSteps; ++k) {
            const double t = end * (k + 0.5) / kSteps;
            const glm::dvec3 p = eye + t / length * to;
            integral += end / kSteps * 0.1 * fluence * std::exp(-0.3 * (t + p.z / down.z)) *
                        passesMovers(movers, {p.x, p.y, p.z}, {down.x, down.y, down.z}, 1);
        }
        sum += integral, taken += bright[i] / kPi - integral, apart += std::fabs(drawn[i] / kPi - integral);
    }
    EXPECT_GT(taken, 0.08 * sum);
    EXPECT_LT(apart, 0.01 * sum);
    RecordProperty("apart", std::to_string(apart / sum));
    std::printf("shafts in warped volumes: off by %.5f of the light, of which movers take %.3f\n", apart / sum,
                taken / sum);
}

TEST_F(WarpedVolumes, NonsenseIsRefused) {
    fill(test::pool3Water(16));
    EXPECT_FALSE(water_->drawWarpedVolumes({}, nullptr, {}, {}).ok());
    const test::DrawnView view = viewFromAbove(0.5);
    const test::DrawnScene scene(gl_, view, 4, 4, floorAt(-1));
    WarpedVolumesOptions options;
    options.step = 0;
    EXPECT_FALSE(
        water_->drawWarpedVolumes(scene.gbuffer(), glm::value_ptr(view.clip_from_world), scene.target(), options).ok());
}

}  // namespace
}  // namespace photic::runtime
