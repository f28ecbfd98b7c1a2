// SPDX-License-Identifier: Apache-2.0
// Curved eye rays in a scene: the light of a volume that an object scatters, surfaces that bent rays meet, what hides
// an object, and the state that the pass leaves.
#include "bake/optics/phase_function.h"
#include "bake/scene/mesh_file.h"
#include "tests/runtime/bent_fixture.h"

namespace photic::test {
namespace {

/// A box without an index, 0.4 m a side, that scatters.
IndexVolumeObject smoke() {
    IndexVolumeObject object;
    object.name = "smoke";
    object.count = glm::ivec3(21);
    object.world_from_node = glm::dmat3(0.02);
    object.origin_world = glm::dvec3(-0.2);
    object.box_high = glm::vec3(20);
    object.sharp_sides = true;
    object.spline.emplace_back(21 * 21 * 21, 0.0F);
    object.scattering = {0.5, 1, 2};
    object.anisotropy = 0.6;
    for (int i = 0; i < 21 * 21 * 21; ++i) object.attenuation.emplace_back(0.5F, 0.0F, 0.0F, 1.0F);
    return object;
}

class BentScene : public BentRays {
protected:
    void SetUp() override {
        BentRays::SetUp();
        if (IsSkipped()) return;
        auto made = BentRayPass::create(*gpu_);
        ASSERT_TRUE(made.ok()) << made.error().message;
        pass_ = std::make_unique<BentRayPass>(std::move(*made));
    }
};

TEST_F(BentScene, ScatteredLightIsTheIntegralAlongTheRay) {
    const runtime::Volume volume = makeVolume(evenLight({0, 0, -1}));
    GpuVolume light = upload(volume, {});
    // In its box, and in sharp faces of nearly that size.
    IndexVolumeObject shaped = smoke();
    shaped.sharp_sides = false;
    shaped.shape = sharpMesh(boxMesh(glm::dvec3(1e-5), glm::dvec3(0.2 - 1e-5)), 1, false).shape;
    auto objects = GpuIndexVolumes::upload(*gpu_, readBack({smoke(), shaped}));
    ASSERT_TRUE(objects.ok());
    Eye eye = eyeAt({1.2, 0, 0}, 8, 9);
    const DrawnView view(gl_, eye, [](const glm::dvec3&, const glm::dvec3&) { return std::nullopt; });
    GBuffer surfaces = view.surfaces;
    surfaces.depth = 0;
    Surroundings dark;
    for (float& c : dark.colour) c = 0;
    for (const unsigned number : {0U, 1U}) {
        // Twice the same light at 3/4 and 1/2: one and a quarter of it.
        const auto drawn =
            pass_->draw(surfaces, view.target, *objects, {{number}}, dark, {{&light, 0.75F}, {&light, 0.5F}});
        ASSERT_TRUE(drawn.ok()) << drawn.error().message;
        const float* middle = nullptr;
        const auto pixels = view.pixels();
        middle = &pixels[4 * (4 * 9 + 4)];
        for (int c = 0; c < 3; ++c) {
            const double s[] = {0.5, 1, 2}, scattering = s[c], extinction = scattering + (c == 0 ? 0.5 : 0.0);
            const double truth =
                1.25 * 200 * scattering * henyeyGreenstein(0.0, 0.6) * (1 - std::exp(-0.4 * extinction)) / extinction;
            EXPECT_NEAR(double(middle[c]) / truth, 1, 4e-3) << c << " of " << number;
        }
    }
}

TEST_F(BentScene, BentRaysMeetTheSurfacesThatWereDrawn) {
    // A ball above a floor whose radiance is its own place: what is seen through the ball is where its rays meet it.
    const double n = 1.3, radius = 0.4;
    const glm::dvec3 floor(0, 0, -0.7);
    Eye eye = eyeAt({1.6, 0.2, 0.9}, 60, 96);
    eye.target = {0, 0, -0.2};
    const auto trace = planes({{floor, {0, 0, 1}}});
    const DrawnView view(gl_, eye, trace);
    std::vector<float> radiance;
    for (int y = 0; y < eye.height; ++y)
        for (int x = 0; x < eye.width; ++x) {
            const auto hit = trace(eye.position, eye.direction(x, y));
            const glm::dvec3 p = hit ? eye.position + hit->distance * eye.direction(x, y) : glm::dvec3(0);
            for (const double v : {p.x + 2, p.y + 2, 0.0, 1.0}) radiance.push_back(float(v));
        }
    GLuint texture = 0;
    gl_.GenTextures(1, &texture);
    gl_.BindTexture(GL_TEXTURE_2D, texture);
    gl_.TexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32F, eye.width, eye.height);
    gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, eye.width, eye.height, GL_RGBA, GL_FLOAT, radiance.data());
    gl_.BindTexture(GL_TEXTURE_2D, 0);
    auto lens = ball(n, radius, radius / 40, 1.5);
    lens.faces.clear();
    auto sharp = sharpBall(n, radius);
    sharp.shape->faces = photic::SharpShape::Faces::Clear;
    auto objects = GpuIndexVolumes::upload(*gpu_, readBack({lens, sharp}));
    ASSERT_TRUE(objects.ok());
    Surroundings s;
    s.radiance = texture;
    for (const unsigned number : {0U, 1U}) {
        const auto drawn = pass_->draw(view.surfaces, view.target, *objects, {{number}}, s);
        ASSERT_TRUE(drawn.ok()) << drawn.error().message;
        const auto pixels = view.pixels();
        double worst = 0, sum = 0;
        int rays = 0;
        for (int y = 0; y < eye.height; ++y)
            for (int x = 0; x < eye.width; ++x) {
                const glm::dvec3 d = eye.direction(x, y), o = eye.position;
                const double to_axis = -glm::dot(o, d), b = glm::length(o + to_axis * d);
                if (b > 0.75 * radius) continue;
                // Chord of the ball, then straight on to the floor.
                const double in = std::asin(b / radius), out = std::asin(b / radius / n);
                const glm::dvec3 entry = o + (to_axis - std::sqrt(radius * radius - b * b)) * d;
                const glm::dvec3 across = b > 1e-9 ? glm::normalize(-(o + to_axis * d)) : glm::dvec3(0);
                const glm::dvec3 inner = std::cos(in - out) * d + std::sin(in - out) * across;
                const glm::dvec3 leaves = entry + 2 * radius * std::cos(out) * inner;
                const glm::dvec3 after = std::cos(2 * (in - out)) * d + std::sin(2 * (in - out)) * across;
                const glm::dvec3 met = leaves + (floor.z - leaves.z) / after.z * after;
                const glm::dvec4 clip = eye.clipFromWorld() * glm::dvec4(met, 1);
                if (std::fabs(clip.x) > 0.95 * clip.w || std::fabs(clip.y) > 0.95 * clip.w) continue;
                const float* pixel = &pixels[4 * std::size_t(y * eye.width + x)];
                const double off = std::hypot(double(pixel[0]) - 2 - met.x, double(pixel[1]) - 2 - met.y);
                worst = std::max(worst, off), sum += off, ++rays;
            }
        ASSERT_GT(rays, 200);
        // A pixel of the floor is 0.02 to 0.04 m wide.
        EXPECT_LT(sum / rays, 0.03);
        EXPECT_LT(worst, 0.12);
        std::printf("floor through a ball%s: off by %.4f m on average, %.4f at most, %d rays\n",
                    number == 1 ? " with its own face" : "", sum / rays, worst, rays);
    }
    gl_.DeleteTextures(1, &texture);
}

TEST_F(BentScene, WhatIsInFrontHidesAnObject) {
    const Eye eye = eyeAt({1.6, 0, 0}, 45, 16);
    auto objects = GpuIndexVolumes::upload(*gpu_, readBack({ball(1.5, 0.4, 0.04, 1.5)}));
    ASSERT_TRUE(objects.ok());
    for (const bool reversed : {false, true})
        for (const double wall : {0.8, -0.8}) {
            Eye looking = eye;
            looking.reversed_depth = reversed;
            const DrawnView view(gl_, looking, planes({{{wall, 0, 0}, {1, 0, 0}}}));
            view.fill(-1, -1, -1);
            ASSERT_TRUE(pass_->draw(view.surfaces, view.target, *objects, {{}}, {}).ok());
            const auto pixels = view.pixels();
            EXPECT_EQ(pixels[4 * (8 * 16 + 8)]<0, wall> 0) << wall << reversed;
            EXPECT_EQ(pixels[0], -1) << "beside the ball nothing is changed";
        }
}

TEST_F(BentScene, StateIsAsItWas) {
    auto objects = GpuIndexVolumes::upload(*gpu_, readBack({ball(1.5, 0.4, 0.1, 1)}));
    ASSERT_TRUE(objects.ok());
    const DrawnView view(gl_, eyeAt({1.6, 0, 0}, 45, 8),
                         [](const glm::dvec3&, const glm::dvec3&) { return std::nullopt; });
    GLuint names[2];
    gl_.GenTextures(2, names);
    gl_.ActiveTexture(GL_TEXTURE11);
    gl_.BindTexture(GL_TEXTURE_2D, names[0]);
    gl_.ActiveTexture(GL_TEXTURE7);
    gl_.BindTexture(GL_TEXTURE_2D_ARRAY, names[1]);
    gl_.Enable(GL_BLEND);
    gl_.BlendFuncSeparate(GL_ZERO, GL_ONE, GL_ONE, GL_ZERO);
    ASSERT_TRUE(pass_->draw(view.surfaces, view.target, *objects, {{}}, {}).ok());
    const auto value = [&](GLenum name) {
        GLint out = -1;
        gl_.GetIntegerv(name, &out);
        return static_cast<GLuint>(out);
    };
    EXPECT_EQ(value(GL_ACTIVE_TEXTURE), static_cast<GLuint>(GL_TEXTURE7));
    EXPECT_EQ(value(GL_TEXTURE_BINDING_2D_ARRAY), names[1]);
    gl_.ActiveTexture(GL_TEXTURE11);
    EXPECT_EQ(value(GL_TEXTURE_BINDING_2D), names[0]);
    EXPECT_EQ(gl_.IsEnabled(GL_BLEND), GL_TRUE);
    EXPECT_EQ(value(GL_BLEND_SRC_ALPHA), static_cast<GLuint>(GL_ONE));
    EXPECT_EQ(value(GL_CURRENT_PROGRAM), 0U);
    gl_.Disable(GL_BLEND);
    gl_.DeleteTextures(2, names);
    // A lost context: names are forgotten, and nothing is deleted.
    objects->abandon();
    pass_->abandon();
}

}  // namespace
}  // namespace photic::test
