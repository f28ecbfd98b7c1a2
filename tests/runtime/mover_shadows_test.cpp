// SPDX-License-Identifier: Apache-2.0
// Shadows of movers beside what a bake with the same things in it says, and in the passes beside the CPU.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <tuple>

#include "photic/movers.h"
#include "tests/runtime/baked_scene.h"
#include "tests/runtime/gpu_fixture.h"
#include "tests/runtime/scene_view.h"

namespace photic {
namespace {

using runtime::Movers;
using runtime::Vec3;
using runtime::Volume;

/// Light on a level floor, looked up on a lattice.
template <class LookUp>
std::vector<double> onFloor(double z, const LookUp& look_up) {
    std::vector<double> out;
    for (int j = 0; j < 120; ++j) {
        for (int i = 0; i < 120; ++i) out.push_back(look_up(Vec3{-0.42 + 0.84 * i / 119, -0.42 + 0.84 * j / 119, z}));
    }
    return out;
}

/// All over the light that there is without movers.
struct AgainstRebake {
    double error = 0;       ///< sum of |with movers - baked with them|
    double unshadowed = 0;  ///< the same of the bake that knows nothing of movers
    double taken = 0;       ///< light that movers take less what the bake says that they take
};

AgainstRebake compared(double floor, const Volume& plain, const Volume& rebaked, const Movers& movers) {
    const Vec3 up = {0, 0, 1};
    const auto before = onFloor(floor, [&](const Vec3& p) { return plain.irradiance(p, up).x; });
    const auto truth = onFloor(floor, [&](const Vec3& p) { return rebaked.irradiance(p, up).x; });
    const auto shown = onFloor(floor, [&](const Vec3& p) { return irradiance(plain, p, up, movers).x; });
    AgainstRebake out;
    double light = 0;
    for (std::size_t n = 0; n < truth.size(); ++n) {
        out.error += std::fabs(shown[n] - truth[n]);
        out.unshadowed += std::fabs(before[n] - truth[n]);
        out.taken += truth[n] - shown[n];
        light += before[n];
    }
    out.error /= light, out.unshadowed /= light, out.taken /= light;
    return out;
}

void record(const std::string& name, const AgainstRebake& r) {
    for (const auto& [what, value] : {std::pair{"error", r.error}, {"unshadowed", r.unshadowed}, {"taken", r.taken}})
        testing::Test::RecordProperty(name + "_" + what, std::to_string(value));
}

Volume baked(const std::string& text) { return test::asGameVolume(test::bake(text).volume, NvdbPrecision::Half); }

// Where light is one sheet, only edges differ: they are as sharp as the sun's disc, and a bake's as its voxels.
TEST(MoverShadows, AreThoseOfABakeWithTheMoversInIt) {
    constexpr double kVoxel = 1.0 / 64;
    const Volume plain = baked(test::poolText("1000.0", "", kVoxel));
    const std::tuple<const char*, const char*, runtime::Mover> cases[] = {
        {"ball", "[[object]]\nrole = \"blocker\"\nsphere = { center = [0.1, 0.05, -0.55], radius = 0.12 }\n",
         runtime::sphere({0.1, 0.05, -0.55}, 0.12)},
        {"box", "[[object]]\nrole = \"blocker\"\nbox = { min = [-0.2, -0.15, -0.75], max = [0.05, 0.1, -0.6] }\n",
         runtime::box({-0.075, -0.025, -0.675}, {0.125, 0, 0}, {0, 0.125, 0}, {0, 0, 0.075})}};
    for (const auto& [name, text, mover] : cases) {
        const Volume rebaked = baked(test::poolText("1000.0", text, kVoxel));
        Movers movers = moversIn(plain.metadata());
        movers.shapes = {mover};
        const AgainstRebake r = compared(-1, plain, rebaked, movers);
        record(name, r);
        EXPECT_GT(r.unshadowed, 0.07) << name;
        EXPECT_LT(r.error, 0.13 * r.unshadowed) << name;
        EXPECT_LT(std::fabs(r.taken), 0.005 * r.unshadowed) << name;
    }
}

// Far below, several sheets cross, and their mean direction stands for all.
TEST(MoverShadows, AreNearToABakesWhereSheetsCross) {
    const std::string scene = R"(photic = 1
[domain]
min = [-0.6, -0.6, -3.1]
max = [0.6, 0.6, 0.15]
voxel_size = 0.025
[[light]]
type = "sun"
direction = [0.3, 0.1, -1]
[[surface]]
name = "water"
kind = "height_field"
size = [6.0, 6.0]
waves = [{ amplitude = 0.04, wavelength = 0.9, direction = 20.0, phase = 0.4 },
         { amplitude = 0.03, wavelength = 0.7, direction = 100.0, phase = 1.7 }]
[[object]]
name = "floor"
plane = { point = [0, 0, -3.0], normal = [0, 0, 1] }
)";
    const Volume plain = baked(scene);
    for (const double depth : {-2.8, -2.0}) {
        const Volume rebaked = baked(scene + "[[object]]\nrole = \"blocker\"\nsphere = { center = [0.05, 0.0, " +
                                     std::to_string(depth) + "], radius = 0.15 }\n");
        Movers movers = moversIn(plain.metadata());
        movers.shapes = {runtime::sphere({0.05, 0, depth}, 0.15)};
        const AgainstRebake r = compared(-3, plain, rebaked, movers);
        record(depth < -2.5 ? "near_floor" : "a_metre_above", r);
        EXPECT_LT(r.error, 0.2 * r.unshadowed) << depth;
        EXPECT_LT(std::fabs(r.taken), 0.08 * r.unshadowed) << depth;
        // Believing the light's own spread is what makes it so: without, the error is larger.
        movers.spread = 0;
        EXPECT_GT(compared(-3, plain, rebaked, movers).error, 1.3 * r.error) << depth;
    }
}

/// Light that leans and spreads a little, coloured or white, below z = 0.
test::NvdbSpec leaning(bool coloured) {
    test::NvdbSpec spec;
    spec.max = {63, 63, 47};
    constexpr double kVoxel = 2.0 / 64;
    spec.world_from_index = {kVoxel, 0, 0, 0, kVoxel, 0, 0, 0, kVoxel};
    spec.origin_world = {-1 + kVoxel / 2, -1 + kVoxel / 2, -1.5 + kVoxel / 2};
    spec.coloured = coloured;
    spec.json = R"({"reference_irradiance": 500, "water_level": 0})";
    spec.values = [](int i, int j, int) -> test::LightValues {
        const double e = 1 + 0.5 * std::sin(0.2 * i) * std::cos(0.15 * j);
        const glm::dvec3 w = 0.995 * glm::normalize(glm::dvec3(0.4 + 0.1 * std::sin(0.1 * j), 0.1, -1)) * e;
        return {float(w.x), float(w.y), float(w.z), float(e), float(0.6 * e), float(1.1 * e), float(1.3 * e)};
    };
    return spec;
}

/// A ball, a turned box, and a map on which a level rectangle is drawn.
struct ThreeKinds {
    ThreeKinds() : depths(2 * kSide * kSide, -1e9F) {
        movers.surface[3] = 0, movers.sun = {0.5, 0.2, -1}, movers.ior = 1.33;
        movers.shapes = {runtime::sphere({0.3, -0.2, -0.7}, 0.2), runtime::sphere({-0.9, -0.3, 0.4}, 0.15),
                         runtime::box({-0.4, 0.3, -1.1}, {0.15, 0.1, 0}, {-0.06, 0.09, 0}, {0, 0, 0.2})};
        runtime::MoverMap& map = movers.map;
        map.corner = {-1, -1, 0}, map.across = {2, 0, 0}, map.up = {0, 2, 0}, map.direction = {0, 0, -1};
        map.columns = map.rows = kSide, map.nearest = 0.4, map.farthest = 0.7;
        for (int j = 30; j < 50; ++j) {
            for (int i = 10; i < 22; ++i) {
                float* at = depths.data() + 2 * (j * kSide + i);
                at[0] = -0.45F, at[1] = 0.6F;
            }
        }
        map.depths = depths.data();
    }
    static constexpr int kSide = 64;
    std::vector<float> depths;
    Movers movers;
};

class MoverPasses : public test::WithGpu {
protected:
    void SetUp() override {
        WithGpu::SetUp();
        if (IsSkipped()) return;
        gl_.GenTextures(1, &map_);
        gl_.BindTexture(GL_TEXTURE_2D, map_);
        gl_.TexStorage2D(GL_TEXTURE_2D, 1, GL_RG32F, ThreeKinds::kSide, ThreeKinds::kSide);
        gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, ThreeKinds::kSide, ThreeKinds::kSide, GL_RG, GL_FLOAT,
                          kinds_.depths.data());
        gl_.BindTexture(GL_TEXTURE_2D, 0);
        eye_.position = {-1.6, -2.2, 1.2}, eye_.target = {0, 0, -0.9};
        eye_.width = 96, eye_.height = 64;
    }
    void TearDown() override {
        if (context_) gl_.DeleteTextures(1, &map_);
        WithGpu::TearDown();
    }
    runtime::MoverShadows shadows() { return {&kinds_.movers, map_}; }

    ThreeKinds kinds_;
    unsigned map_ = 0;
    test::Eye eye_;
    test::Trace floor_ = test::planes({{{0, 0, -1.45}, {0, 0, 1}}, {{0.93, 0, 0}, {-1, 0, 0}}});
};

TEST_F(MoverPasses, ReceiversAreAsDarkAsOnTheCpu) {
    for (const bool coloured : {false, true}) {
        const Volume volume = test::makeVolume(leaning(coloured));
        runtime::GpuVolume gpu = upload(volume, {});
        const test::DrawnView view(gl_, eye_, floor_);
        auto pass = runtime::ReceiverPass::create(*gpu_);
        ASSERT_TRUE(pass.ok()) << pass.error().message;
        runtime::ReceiverOptions options;
        options.output = runtime::ReceiverOutput::Irradiance;
        options.shadows = shadows();
        const runtime::Status drawn = pass->draw(view.surfaces, view.target, {{&gpu}}, options);
        ASSERT_TRUE(drawn.ok()) << drawn.error().message;
        const auto pixels = view.pixels();
        double apart = 0, light = 0, taken = 0;
        for (int y = 0; y < eye_.height; ++y) {
            for (int x = 0; x < eye_.width; ++x) {
                const glm::dvec3 way = eye_.direction(x, y);
                const auto hit = floor_(eye_.position, way);
                if (!hit) continue;
                const glm::dvec3 p = eye_.position + hit->distance * way;
                const Vec3 at = {p.x, p.y, p.z}, normal = {hit->normal.x, hit->normal.y, hit->normal.z};
                const double cpu = irradiance(volume, at, normal, kinds_.movers).y;
                apart +=
                    std::fabs(static_cast<double>(pixels[4 * static_cast<std::size_t>(y * eye_.width + x) + 1]) - cpu);
                light += cpu, taken += volume.irradiance(at, normal).y - cpu;
            }
        }
        EXPECT_GT(taken, 0.05 * light);
        EXPECT_LT(apart, 2e-3 * light);
    }
}

// Shafts of shadow in the medium: the same march, on the CPU.
TEST_F(MoverPasses, MediaAreAsDarkAsOnTheCpu) {
    const Volume volume = test::makeVolume(leaning(false));
    runtime::GpuVolume gpu = upload(volume, {});
    auto pass = runtime::MediumPass::create(*gpu_);
    ASSERT_TRUE(pass.ok()) << pass.error().message;
    runtime::MediumOptions options;
    options.scattering[0] = options.scattering[1] = options.scattering[2] = 0.2F;
    options.surface[2] = 1, options.surface[3] = 0;
    options.steps = 64;
    const test::DrawnView plain(gl_, eye_, floor_), dark(gl_, eye_, floor_);
    ASSERT_TRUE(pass->draw(plain.surfaces, plain.target, {{&gpu}}, options).ok());
    options.shadows = shadows();
    const runtime::Status drawn = pass->draw(dark.surfaces, dark.target, {{&gpu}}, options);
    ASSERT_TRUE(drawn.ok()) << drawn.error().message;
    const auto a = plain.pixels(), b = dark.pixels();
    // By a finer march: what is scattered evenly, dimmed on its way to the eye.
    double apart = 0, light = 0, taken = 0;
    for (int y = 0; y < eye_.height; y += 4) {
        for (int x = 0; x < eye_.width; x += 4) {
            const glm::dvec3 way = eye_.direction(x, y);
            const auto hit = floor_(eye_.position, way);
            if (!hit || way.z >= 0) continue;
            const double begin = -eye_.position.z / way.z;
            double radiance = 0;
            constexpr int kSteps = 256;
            const double step = (hit->distance - begin) / kSteps;
            for (int i = 0; i < kSteps; ++i) {
                const double t = (i + 0.5) * step;
                const glm::dvec3 p = eye_.position + (begin + t) * way;
                radiance += step * 0.2 / (4 * 3.14159265358979) * std::exp(-0.2 * t) *
                            runtime::sample(volume, {p.x, p.y, p.z}, kinds_.movers).irradiance.y;
            }
            const std::size_t at = 4 * static_cast<std::size_t>(y * eye_.width + x) + 1;
            apart += std::fabs(static_cast<double>(b[at]) - radiance);
            light += radiance, taken += static_cast<double>(a[at] - b[at]);
        }
    }
    EXPECT_GT(taken, 0.05 * light);
    EXPECT_LT(apart, 0.03 * light);
}

TEST_F(MoverPasses, AMapWithoutItsTextureIsRefused) {
    const Volume volume = test::makeVolume(leaning(false));
    runtime::GpuVolume gpu = upload(volume, {});
    const test::DrawnView view(gl_, eye_, floor_);
    auto pass = runtime::ReceiverPass::create(*gpu_);
    ASSERT_TRUE(pass.ok());
    runtime::ReceiverOptions options;
    options.shadows = {&kinds_.movers, 0};
    const runtime::Status drawn = pass->draw(view.surfaces, view.target, {{&gpu}}, options);
    ASSERT_FALSE(drawn.ok());
    EXPECT_NE(drawn.error().message.find("MoverShadows::map"), std::string::npos);
}

}  // namespace
}  // namespace photic
