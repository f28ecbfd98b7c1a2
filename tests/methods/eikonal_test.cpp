// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/eikonal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"
#include "tests/methods/eikonal_bakes.h"
#include "tests/support/closed_forms.h"
#include "tests/support/wave_light.h"

namespace photic {
namespace {

using test::bakeEikonal;
using test::forLit;
using test::kMarching;
using test::options;
using test_scenes::boxFrame;
using test_scenes::CosineField;
using test_scenes::waterScene;

/// Flat water under a slanting sun: Snell's direction, Fresnel's power, no curvature; sides included, by both solvers.
TEST(Eikonal, FlatWaterIsExact) {
    const double zenith = 0.6;
    for (const GivenOptions& given : {GivenOptions{}, kMarching}) {
        const BakeResult r = bakeEikonal(waterScene(zenith), {-0.5, -0.5, -0.9}, {32, 32, 32}, 1.0 / 32, given);
        const truth::PlaneWater water{1, std::cos(zenith), 1, 1.333, 0};
        const double fluence = water.horizontal(0.5) / water.cosBelow(), sin_t = std::sin(zenith) / 1.333;
        int lit = 0;
        forLit(r, [&](const glm::ivec3& v) {
            ++lit;
            EXPECT_LE(std::fabs(double(r.caustic->value(v, 0))) / 32, 1e-9);
            EXPECT_NEAR(double(r.field.value(v, 0)), fluence, 1e-5);
            const glm::dvec3 w = r.field.flux(v) / double(r.field.value(v, 0));
            EXPECT_NEAR(w.x, 0.8 * sin_t, 1e-5);
            EXPECT_NEAR(w.z, -water.cosBelow(), 1e-5);
            const glm::dvec3 p = r.field.frame().worldFromIndex(glm::dvec3(v));
            EXPECT_NEAR(double(r.arrival_time->value(v, 0)),
                        1.333 * (sin_t * (0.8 * p.x + 0.6 * p.y) - water.cosBelow() * p.z), 1e-5);
        });
        EXPECT_EQ(lit, 32 * 32 * 29);
    }
}

/// A wave under light from straight above, down to its first caustic: the voxels' means from the truth.
TEST(Eikonal, WaveIsRightUpToTheCaustic) {
    const double a = 0.05, k = 8, focus = a - 1 / (a * k * k * (1 - 1 / 1.333));  // z of the cusp
    double last = 0;
    for (const int n : {32, 64, 128}) {
        const double h = 1.0 / n, low = std::ceil(0.6 * focus * n) * h;
        const BakeResult r = bakeEikonal(waterScene(0, std::make_shared<CosineField>(a, k)), {-0.5, -4 * h, low},
                                         {n, 8, static_cast<int>(std::lround(-low * n)) - n / 8}, h);
        EXPECT_EQ(r.metadata.at("single_arrival_fraction"), "1.0000");
        EXPECT_NEAR(std::stod(r.metadata.at("first_caustic_z")), focus, 4e-3);
        const GridFrame& f = r.field.frame();
        const truth::WaveLight light(truth::cosineProfile(a, k), 1.333, -2, 2, 4000);
        const truth::VoxelMeans truth = light.voxelMeans(-0.5, h, n, low, h, f.size().z);
        double error = 0, sum = 0;
        for (int x = 0; x < n; ++x)
            for (int z = 0; z < f.size().z; ++z) {
                const double e = truth.fluence[truth.index(x, z)];
                error += std::fabs(double(r.field.value({x, 3, z}, 0)) - e), sum += e;
            }
        error /= sum;
        if (last > 0) {
            EXPECT_GT(std::log2(last / error), 1.7) << n << ": " << error;
        }
        last = error;
    }
    EXPECT_LT(last, 1e-3);
}

/// Marching tends to the foot points: curvature and irradiance in the second order.
TEST(Eikonal, MarchingTendsToTheFootPoints) {
    double last_caustic = 0, last_light = 0;
    for (const int n : {32, 64, 128}) {
        const Scene scene = waterScene(0.4, std::make_shared<CosineField>(0.03, 6));
        const glm::ivec3 size(n, n / 4, n / 2);
        const glm::dvec3 low(-0.5, -0.125, -0.6);
        const BakeResult feet = bakeEikonal(scene, low, size, 1.0 / n),
                         marched = bakeEikonal(scene, low, size, 1.0 / n, kMarching);
        double off_caustic = 0, sum_caustic = 0, off_light = 0, sum_light = 0;
        forLit(feet, [&](const glm::ivec3& v) {
            off_caustic += std::fabs(double(marched.caustic->value(v, 0) - feet.caustic->value(v, 0)));
            sum_caustic += std::fabs(double(feet.caustic->value(v, 0)));
            off_light += std::fabs(double(marched.field.value(v, 0) - feet.field.value(v, 0)));
            sum_light += double(feet.field.value(v, 0));
        });
        const double caustic = off_caustic / sum_caustic, light = off_light / sum_light;
        if (n > 32) {
            EXPECT_GT(std::log2(last_caustic / caustic), 0.8) << n << ": " << caustic;
            EXPECT_GT(std::log2(last_light / light), 1.3) << n << ": " << light;
        }
        last_caustic = caustic, last_light = light;
    }
    EXPECT_LT(last_caustic, 0.02);
    EXPECT_LT(last_light, 2e-3);
}

/// A domain of a few columns, or of one: what marching finds there is the same light, in the second order of the cells.
/// Seeds that were frozen beside such a domain would lie in other columns, or outside of all memory.
TEST(Eikonal, NarrowDomainsAreMarchedToo) {
    const Scene scene = waterScene(0.3, std::make_shared<CosineField>(0.03, 6));
    for (const glm::ivec2 columns : {glm::ivec2(1, 1), {2, 1}, {1, 3}, {5, 2}, {3, 12}, {12, 1}})
        for (const double first : {-0.5, -0.40625, -0.3125}) {  // the blocks of cells begin elsewhere
            const glm::ivec3 size(columns, 24);
            const glm::dvec3 low(first, first / 2, -0.8);
            const BakeResult feet = bakeEikonal(scene, low, size, 1.0 / 32),
                             marched = bakeEikonal(scene, low, size, 1.0 / 32, kMarching);
            std::int64_t lit = 0;
            forLit(feet, [&](const glm::ivec3& v) {
                ++lit;
                const double light = double(feet.field.value(v, 0));
                EXPECT_NEAR(double(marched.field.value(v, 0)) / light, 1, 0.02) << columns.x << " " << columns.y;
                EXPECT_NEAR(double(marched.arrival_time->value(v, 0) - feet.arrival_time->value(v, 0)), 0, 1e-4);
            });
            EXPECT_EQ(lit, std::int64_t(24) * columns.x * columns.y);
        }
}

TEST(Eikonal, DarkBeyondTheCaustic) {
    const Scene scene = waterScene(0, std::make_shared<CosineField>(0.06, 9));
    const auto lit = [&](const GivenOptions& given) {
        const BakeResult r = bakeEikonal(scene, {-0.5, -0.1, -1.5}, {64, 12, 96}, 1.0 / 64, given);
        std::int64_t count = 0;
        forLit(r, [&](const glm::ivec3&) { ++count; });
        return std::pair{count, std::stod(r.metadata.at("single_arrival_fraction"))};
    };
    const auto [all, fraction] = lit({});
    const auto [dark, same] = lit(options({{"beyond", std::string("dark")}}));
    EXPECT_EQ(fraction, same);
    EXPECT_LT(fraction, 0.97);
    EXPECT_NEAR(double(dark) / double(all), fraction, 1e-3);
}

/// The paper's preset: light goes along the normals. Its sides are kept by their costs: under a tilted plane no side
/// differs by a cell from the plane that goes on.
TEST(Eikonal, MercierPreset) {
    class Tilted final : public HeightField {
    public:
        SurfacePoint at(glm::dvec2 uv) const override { return {{uv.x, uv.y, 0.2 * uv.x}, {-0.2, 0, 1}}; }
        double minZ() const override { return -0.4; }
        double maxZ() const override { return 0.4; }
        double featureSize() const override { return std::numeric_limits<double>::infinity(); }
    };
    const BakeResult r = bakeEikonal(waterScene(0, std::make_shared<Tilted>()), {-0.5, -0.5, -1}, {48, 48, 54},
                                     1.0 / 48, options({{"preset", std::string("mercier")}, {"threshold", 1.0}}));
    const glm::dvec3 normal = glm::normalize(glm::dvec3(-0.2, 0, 1));
    double worst = 0, turned = 0;
    std::int64_t count = 0;
    forLit(r, [&](const glm::ivec3& v) {
        const glm::dvec3 p = r.field.frame().worldFromIndex(glm::dvec3(v));
        worst = std::max(worst, 48 * std::fabs(double(r.arrival_time->value(v, 0)) + glm::dot(normal, p)));
        turned += glm::length(r.field.flux(v) / double(r.field.value(v, 0)) + normal), ++count;
    });
    EXPECT_LT(worst, 1.5);  // vertex splats are half a cell off
    EXPECT_LT(turned / double(count), 0.05);
    EXPECT_NE(r.metadata.at("caustic_kind").find("positive"), std::string::npos);
}

TEST(Eikonal, ThreadsChangeNothing) {
    const auto baked = [&](int threads, const GivenOptions& given) {
        setThreadCount(threads);
        const BakeResult r = bakeEikonal(waterScene(0.3, std::make_shared<CosineField>(0.03, 8)), {-0.5, -0.25, -1},
                                         {40, 20, 40}, 1.0 / 40, given);
        setThreadCount(0);
        return std::tuple{r.field.sum(0), r.caustic->sum(0), r.arrival_time->sum(0), r.field.value({7, 9, 5}, 3)};
    };
    for (const GivenOptions& given : {GivenOptions{}, kMarching}) EXPECT_EQ(baked(1, given), baked(3, given));
}

/// Marching: 8 bytes of arrival, 5/8 of mask and keys and 4 of irradiance a cell of the box with its ghosts, which is
/// rounded to blocks; foot points: a few layers.
TEST(Eikonal, BytesOfAVoxel) {
    const Scene scene = waterScene(0.3);
    const auto bytes = [&](const GivenOptions& given) {
        return std::stod(bakeEikonal(scene, {-0.5, -0.5, -0.99}, {128, 128, 128}, 1.0 / 128, given)
                             .metadata.at("solver_bytes_a_voxel"));
    };
    EXPECT_LT(bytes(kMarching), 12.75 * std::pow(144.0 / 128, 3) + 0.2);
    EXPECT_LT(bytes({}), 3.4);  // 2 layers x 80 + 8 x 33 bytes a column of 128
}

/// Almost level light goes down by the critical angle, and enters as weakly as Fresnel's law says.
TEST(Eikonal, GrazingLightGoesDownByTheCriticalAngle) {
    const double zenith = std::asin(1.0) - 1e-3;
    const BakeResult r = bakeEikonal(waterScene(zenith), {-0.25, -0.25, -0.5}, {16, 16, 16}, 1.0 / 32);
    const truth::PlaneWater water{1, std::cos(zenith), 1, 1.333, 0};
    int lit = 0;
    forLit(r, [&](const glm::ivec3& v) {
        const double e = double(r.field.value(v, 0));
        EXPECT_NEAR(e / (water.horizontal(0.25) / water.cosBelow()), 1, 1e-3);
        EXPECT_NEAR(double(r.field.flux(v).z) / e, -std::sqrt(1 - 1 / (1.333 * 1.333)), 1e-4);
        ++lit;
    });
    EXPECT_GT(lit, 3000);
}

/// A metre or a nanometre, here or a thousand kilometres away: the same light, and curvature in proportion.
TEST(Eikonal, ScaleAndPlaceAreNothing) {
    class Placed final : public HeightField {
    public:
        Placed(double scale, double shift) : s_(scale), shift_(shift) {}
        SurfacePoint at(glm::dvec2 uv) const override {
            SurfacePoint p = wave_.at((uv - shift_) / s_);
            p.position = p.position * s_ + glm::dvec3(shift_, shift_, 0);
            return p;
        }
        double minZ() const override { return s_ * wave_.minZ(); }
        double maxZ() const override { return s_ * wave_.maxZ(); }
        double featureSize() const override { return s_ * wave_.featureSize(); }

    private:
        CosineField wave_{0.03, 6};
        double s_, shift_;
    };
    const auto baked = [](double s, double shift, const GivenOptions& given) {
        Scene scene = waterScene(0.4, std::make_shared<Placed>(s, shift));
        scene.surfaces[0].size *= s, scene.surfaces[0].center = {shift, shift, 0};
        return bakeEikonal(scene, s * glm::dvec3(-0.5, -0.125, -0.6) + glm::dvec3(shift, shift, 0), {32, 8, 16}, s / 32,
                           given);
    };
    for (const GivenOptions& given : {GivenOptions{}, kMarching}) {
        const BakeResult one = baked(1, 0, given);
        for (const auto& [s, shift] : {std::pair{1e-9, 0.0}, {1e9, 0.0}, {1.0, 1e6}}) {
            const BakeResult other = baked(s, shift, given);
            double light = 0, curvature = 0, sum = 0;
            forLit(one, [&](const glm::ivec3& v) {
                light = std::max(light, std::fabs(double(other.field.value(v, 0) - one.field.value(v, 0))));
                curvature += std::fabs(double(other.caustic->value(v, 0)) * s - double(one.caustic->value(v, 0)));
                sum += std::fabs(double(one.caustic->value(v, 0)));
            });
            EXPECT_LT(light, 1e-4) << s << " " << shift;
            EXPECT_LT(curvature / sum, 1e-4) << s << " " << shift;
        }
    }
}

TEST(Eikonal, SaysWhatItCannotBake) {
    const Method method = eikonalMethod();
    Scene scene = waterScene(0.3);
    EXPECT_EQ(method.refusal(scene), "");
    Scene up = scene;
    up.lights[0].direction.z = 0.5;
    EXPECT_NE(method.refusal(up).find("below"), std::string::npos);
    Scene two = scene;
    two.lights.push_back(two.lights[0]);
    EXPECT_NE(method.refusal(two).find("2 lights"), std::string::npos);
    Scene mirror = scene;
    mirror.surfaces[0].event = SurfaceEvent::Both;
    EXPECT_NE(method.refusal(mirror).find("refract"), std::string::npos);
    Monitor monitor;
    const GridFrame flat = boxFrame({0, 0, -1}, {16, 16, 16}, {0.02, 0.02, 0.04});
    const auto needed = std::make_shared<const NeededVoxels>(NeededVoxels::everything(flat));
    EXPECT_NO_THROW(method.bake(scene, needed, {}, monitor));
    EXPECT_THROW(method.bake(scene, needed, kMarching, monitor), Error);
}

}  // namespace
}  // namespace photic
