// SPDX-License-Identifier: Apache-2.0
#include "runtime/viewer/renderer.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <optional>
#include <tuple>

#include "photic/bent_rays.h"
#include "photic/live_bake.h"
#include "photic/runtime_gl.h"
#include "runtime/viewer/gl_objects.h"
#include "runtime/viewer/shown_volumes.h"
#include "runtime/viewer/viewer_shaders.h"

namespace photic::viewer {
namespace {

using runtime::Done;
using runtime::Status;

// Absorption of clean water at red, green and blue [1/m], rounded; tints scenes that set no medium.
const glm::vec3 kCleanWater{0.35f, 0.07f, 0.02f};

struct Matrices {
    glm::mat4 clip_from_world{1}, world_from_clip{1};
};

Matrices matricesOf(const Camera& camera, const Stage& stage, float aspect) {
    const float distance = glm::length(camera.eye - camera.target), extent = glm::length(stage.max - stage.min);
    const glm::vec3 forward = camera.target - camera.eye;
    const glm::vec3 up = std::abs(forward.z) > 0.999f * distance ? glm::vec3(0, 1, 0) : glm::vec3(0, 0, 1);
    const float far = distance + 2 * extent, near = std::max(1e-3f * extent, distance - 2 * extent);
    Matrices m;
    m.clip_from_world = glm::perspective(glm::radians(camera.field_of_view_deg), aspect, near, far) *
                        glm::lookAt(camera.eye, camera.target, up);
    m.world_from_clip = glm::inverse(m.clip_from_world);
    return m;
}

void copy(float* out, const glm::vec3& v) { std::copy_n(glm::value_ptr(v), 3, out); }

class GlRenderer final : public Renderer {
public:
    explicit GlRenderer(runtime::GpuContext context) : context_(std::move(context)) {}

    ~GlRenderer() override {
        glDeleteVertexArrays(1, &empty_array_);
        glDeleteTextures(1, &height_texture_);
        glDeleteTextures(1, &environment_texture_);
    }

    Status build() {
        using namespace shaders;
        glGenVertexArrays(1, &empty_array_);
        for (const auto& [program, vertex, fragment] : {std::tuple{&stage_program_, kStageVertex, kStageFragment},
                                                        {&base_program_, kFullScreenVertex, kBaseFragment},
                                                        {&veil_program_, kFullScreenVertex, kVeilFragment},
                                                        {&surface_program_, kStageVertex, kSurfaceFragment},
                                                        {&display_program_, kFullScreenVertex, kDisplayFragment}}) {
            if (const Status built = program->build(vertex, fragment); !built) return built;
        }
        auto receivers = runtime::ReceiverPass::create(context_);
        if (!receivers) return receivers.error();
        receivers_.emplace(std::move(receivers).value());
        auto media = runtime::MediumPass::create(context_);
        if (!media) return media.error();
        media_.emplace(std::move(media).value());
        auto water = runtime::LiveWater::create(context_);
        if (!water) return water.error();
        water_.emplace(std::move(water).value());
        ball_.upload(ball());
        return Done{};
    }

    Status setStage(const Stage& stage) override {
        stage_ = stage;
        room_.upload(stage.room);
        solids_.upload(stage.solids);
        sheets_.upload(stage.sheets);
        has_water_ = !stage.heights.empty() && stage.has_sun;
        map_current_ = live_current_ = false;
        live_.reset();
        uploadHeights();
        if (!has_water_) return Done{};
        stage_.water.heights = stage_.heights.data();
        if (const Status set = water_->setHeights(stage_.water); !set) return set;
        return setLight(stage_.light);
    }

    Status setVolume(int index, const runtime::Volume& volume) override {
        return volumes_.set(context_, index, volume);
    }
    Status sendVolume(int index, const runtime::Volume& volume) override {
        return volumes_.send(context_, index, volume);
    }
    runtime::Result<bool> bringVolume() override { return volumes_.bring(); }

    Status setLight(const runtime::WaterLight& light) override {
        stage_.light = light;
        map_current_ = live_current_ = false;
        // A sun that does not shine down on the water is for a bake alone.
        has_water_ = !stage_.heights.empty() && stage_.has_sun && water_->setLight(light).ok();
        return Done{};
    }

    Status setObjects(const std::vector<runtime::IndexVolume>& objects) override {
        objects_.reset();
        if (objects.empty()) return Done{};
        if (!bent_) {
            auto bent = runtime::BentRayPass::create(context_);
            if (!bent) return bent.error();
            bent_.emplace(std::move(bent).value());
        }
        auto uploaded = runtime::GpuIndexVolumes::upload(context_, objects);
        if (!uploaded) return uploaded.error();
        objects_.emplace(std::move(uploaded).value());
        return Done{};
    }
    void setEnvironment(const Environment& environment) override {
        if (!environment_texture_) glGenTextures(1, &environment_texture_);
        glBindTexture(GL_TEXTURE_2D, environment_texture_);
        glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, environment.width, environment.height, 0, GL_RGBA, GL_FLOAT,
                     environment.pixels.data());
        for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
            glTexParameteri(GL_TEXTURE_2D, name, GL_LINEAR);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
        environment_harmonics_ =
            runtime::environmentHarmonics(environment.pixels.data(), environment.width, environment.height);
        // Of the first one: what is played does not flicker, and is brighter where it is.
        if (environment_irradiance_ == 0) environment_irradiance_ = static_cast<float>(environment.irradiance());
    }
    bool hasObjects() const override { return objects_.has_value(); }

    bool has(Source source) const override {
        switch (source) {
            case Source::BakedA:
                return volumes_.has(0);
            case Source::BakedB:
                return volumes_.has(1);
            case Source::None:
                return true;
            default:
                return has_water_;
        }
    }

    std::string device() const override { return context_.renderer(); }

    Status draw(const Picture& picture, unsigned framebuffer, int width, int height) override {
        if (const Status sized = targets_.resize(width, height); !sized) return sized;
        const Matrices matrices =
            matricesOf(picture.camera, stage_, static_cast<float>(width) / static_cast<float>(height));
        glViewport(0, 0, width, height);
        drawStage(picture, matrices);
        const bool two = picture.split > 0 && picture.split < 1;
        for (int side = 0; side < 2; ++side) {
            if (side == 1 && !two && picture.split >= 1) continue;
            if (side == 0 && picture.split <= 0) continue;
            const Status lit = light(picture, matrices, side == 0 ? picture.left : picture.right, side, width, height);
            if (!lit) return lit;
        }
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
        glViewport(0, 0, width, height);
        glDisable(GL_DEPTH_TEST);
        glDisable(GL_BLEND);
        display_program_.use();
        display_program_.texture("left_texture", 0, targets_.radiance[0]);
        display_program_.texture("right_texture", 1, targets_.radiance[1]);
        // Unfocused light on a receiver reaches half of the curve's range.
        display_program_.set("exposure", picture.exposure * 1.3f / (stage_.reference * stage_.level));
        display_program_.set("split", picture.split);
        fullScreen();
        return Done{};
    }

private:
    /// z of the water's surface; without water one texel that nothing is above.
    void uploadHeights() {
        const bool wet = !stage_.heights.empty();
        std::vector<float> z = stage_.heights;
        for (float& value : z) value += stage_.water.level;
        if (!wet) z = {1e30f};
        if (!height_texture_) glGenTextures(1, &height_texture_);
        glBindTexture(GL_TEXTURE_2D, height_texture_);
        glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
        glTexImage2D(GL_TEXTURE_2D, 0, GL_R32F, wet ? stage_.water.columns : 1, wet ? stage_.water.rows : 1, 0, GL_RED,
                     GL_FLOAT, z.data());
        for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
            glTexParameteri(GL_TEXTURE_2D, name, GL_LINEAR);
        for (const GLenum name : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
            glTexParameteri(GL_TEXTURE_2D, name, GL_CLAMP_TO_EDGE);
    }

    void fullScreen() const {
        glBindVertexArray(empty_array_);
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glBindVertexArray(0);
    }

    /// Depth, normals and albedo of the room and the ball.
    void drawStage(const Picture& picture, const Matrices& matrices) const {
        glBindFramebuffer(GL_FRAMEBUFFER, targets_.stage_framebuffer);
        glEnable(GL_DEPTH_TEST);
        glDepthFunc(GL_LESS);
        glDepthMask(GL_TRUE);
        glDisable(GL_BLEND);
        // A cutaway: walls are seen from their fronts only.
        glEnable(GL_CULL_FACE);
        glCullFace(GL_BACK);
        glFrontFace(GL_CCW);
        glClearColor(0, 0, 0, 0);
        glClearDepth(1);
        glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        stage_program_.use();
        stage_program_.set("clip_from_world", matrices.clip_from_world);
        stage_program_.set("place", glm::vec4(0, 0, 0, 1));
        stage_program_.set("base", picture.albedo);
        stage_program_.set("tile_size", picture.tile_size);
        stage_program_.set("walls", stage_.walls);
        stage_program_.set("wall_count", static_cast<float>(stage_.walls.size()));
        stage_program_.set("tolerance", 1e-4f * glm::length(stage_.max - stage_.min));
        room_.draw();
        glDisable(GL_CULL_FACE);
        solids_.draw();
        if (picture.ball_radius > 0) {
            stage_program_.set("place", glm::vec4(picture.ball_centre, picture.ball_radius));
            stage_program_.set("base", glm::vec3(0.82f));
            stage_program_.set("tile_size", 0.0f);
            ball_.draw();
        }
        glDisable(GL_DEPTH_TEST);
    }

    runtime::GBuffer gBuffer(const Picture& picture, const Matrices& matrices) const {
        runtime::GBuffer g;
        g.depth = targets_.depth, g.normals = targets_.normals, g.albedo = targets_.albedo;
        std::copy_n(glm::value_ptr(matrices.world_from_clip), 16, g.world_from_clip);
        copy(g.camera, picture.camera.eye);
        return g;
    }

    /// One half: skylight, the source's light on receivers, what the water takes and scatters, the water's surface.
    Status light(const Picture& picture, const Matrices& matrices, Source source, int side, int width, int height) {
        glBindFramebuffer(GL_FRAMEBUFFER, targets_.framebuffers[side]);
        glDisable(GL_BLEND);
        const glm::vec3 sun(stage_.light.direction[0], stage_.light.direction[1], stage_.light.direction[2]);
        const glm::vec3 irradiance(stage_.light.irradiance[0], stage_.light.irradiance[1], stage_.light.irradiance[2]);
        base_program_.use();
        base_program_.texture("depth_texture", 0, targets_.depth);
        base_program_.texture("normal_texture", 1, targets_.normals);
        base_program_.texture("albedo_texture", 2, targets_.albedo);
        base_program_.set("world_from_clip", matrices.world_from_clip);
        base_program_.set("ambient", picture.ambient * stage_.reference * stage_.level * glm::vec3(0.85f, 0.95f, 1.0f));
        base_program_.set("sun_direction", sun);
        base_program_.set("sun_irradiance", stage_.has_sun ? irradiance : glm::vec3(0));
        base_program_.texture("water_texture", 3, height_texture_);
        base_program_.set("water_rect", glm::vec4(stage_.water.corner[0], stage_.water.corner[1],
                                                  1 / stage_.water.size[0], 1 / stage_.water.size[1]));
        base_program_.texture("environment_texture", 4, environment_texture_);
        base_program_.set("environment_gain", environmentGain(picture));
        base_program_.set("environment_turn", picture.turn);
        base_program_.set("eye", picture.camera.eye);
        fullScreen();

        const runtime::GBuffer surfaces = gBuffer(picture, matrices);
        const runtime::Target target{targets_.framebuffers[side], 0, 0, width, height};
        if (const Status lit = receivers(picture, matrices, source, surfaces, target); !lit) return lit;
        veil(picture, matrices, target);
        if (const Status lit = media(picture, matrices, source, surfaces, target); !lit) return lit;
        waterSurface(picture, matrices, side, sun);
        return bentRays(picture, source, surfaces, target);
    }

    /// Such that a level receiver gets of the environment what the skylight is said to be.
    float environmentGain(const Picture& picture) const {
        if (!objects_ || !picture.objects || !(environment_irradiance_ > 0)) return 0;
        return picture.ambient * stage_.reference * stage_.level / environment_irradiance_;
    }

    /// Objects that are seen through, before what has been drawn.
    Status bentRays(const Picture& picture, Source source, const runtime::GBuffer& surfaces,
                    const runtime::Target& target) {
        if (!objects_ || !picture.objects) return Done{};
        glBindFramebuffer(GL_READ_FRAMEBUFFER, target.framebuffer);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, targets_.seen_framebuffer);
        glBlitFramebuffer(0, 0, target.width, target.height, 0, 0, target.width, target.height, GL_COLOR_BUFFER_BIT,
                          GL_NEAREST);
        std::vector<runtime::PlacedObject> placed;
        for (int i = 0; i < objects_->info().objects; ++i) placed.push_back({static_cast<unsigned>(i)});
        runtime::Surroundings around;
        around.environment = environment_texture_;
        for (float& c : around.colour) c = environmentGain(picture);
        around.turn = picture.turn;
        around.harmonics = environment_harmonics_;
        around.radiance = targets_.seen;
        std::vector<runtime::LitVolume> light;
        if (runtime::GpuVolume* volume = volumeOf(source)) light.push_back({volume});
        return bent_->draw(surfaces, target, *objects_, placed, around, light);
    }

    /// The ball darkens light, baked or not.
    runtime::Movers moversOf(const Picture& picture) const {
        runtime::Movers movers;
        if (!stage_.heights.empty()) movers.surface[3] = stage_.water.level;
        movers.ior = stage_.light.ior;
        if (stage_.has_sun)
            movers.sun = {stage_.light.direction[0], stage_.light.direction[1], stage_.light.direction[2]};
        const glm::vec3& at = picture.ball_centre;
        if (picture.ball_radius > 0)
            movers.shapes = {runtime::sphere({at.x, at.y, at.z}, static_cast<double>(picture.ball_radius))};
        movers.bias = 1e-3 * static_cast<double>(picture.ball_radius) + 1e-6;
        return movers;
    }

    Status receivers(const Picture& picture, const Matrices& matrices, Source source, const runtime::GBuffer& surfaces,
                     const runtime::Target& target) {
        if (source == Source::None || !has(source)) return Done{};
        if (source == Source::LiveBake) {
            if (const Status ready = prepareWater(picture, source); !ready) return ready;
        }
        const runtime::Movers movers = moversOf(picture);
        runtime::ReceiverOptions lit;
        lit.shadows.movers = &movers;
        if (runtime::GpuVolume* volume = volumeOf(source)) return receivers_->draw(surfaces, target, {{volume}}, lit);
        if (const Status ready = prepareWater(picture, source); !ready) return ready;
        if (source == Source::WarpedVolumes) {
            runtime::WarpedVolumesOptions options;
            options.bottom = stage_.min.z;
            options.step = picture.warped_step;
            options.shadows.movers = &movers;
            return water_->drawWarpedVolumes(surfaces, glm::value_ptr(matrices.clip_from_world), target, options);
        }
        const auto kind =
            source == Source::CausticMap ? runtime::LightSource::CausticMap : runtime::LightSource::Lookup;
        return receivers_->drawLit(surfaces, target, {kind, {}, &*water_}, lit);
    }

    /// The volume that a source looks light up in; null where it looks at something else, or has none.
    runtime::GpuVolume* volumeOf(Source source) {
        if (source == Source::LiveBake) return has_water_ && live_ ? &live_->volume() : nullptr;
        if (source != Source::BakedA && source != Source::BakedB) return nullptr;
        return volumes_.at(source == Source::BakedA ? 0 : 1);
    }

    /// Anew where the water or its light has changed.
    Status bakeLive() {
        if (live_current_) return Done{};
        if (!live_) {
            runtime::LiveBakeOptions options;
            constexpr float kMostVoxels = 128;
            const glm::vec3 size = stage_.max - stage_.min;
            const float voxel = std::max({size.x, size.y, size.z}) / kMostVoxels;
            for (int a = 0; a < 3; ++a) {
                const auto axis = static_cast<std::size_t>(a);
                options.min[axis] = stage_.min[a], options.max[axis] = stage_.max[a];
                options.voxels[axis] = std::max(1, static_cast<int>(std::ceil(size[a] / voxel)));
            }
            auto made = runtime::LiveBake::create(context_, options);
            if (!made) return made.error();
            live_.emplace(std::move(made).value());
        }
        live_current_ = true;
        return live_->update(*water_);
    }

    Status prepareWater(const Picture& picture, Source source) {
        runtime::WaterLight light = stage_.light;
        copy(light.extinction, picture.extinction);
        if (picture.extinction != extinction_) {
            if (const Status set = water_->setLight(light); !set) return set;
            extinction_ = picture.extinction;
            map_current_ = live_current_ = false;
        }
        runtime::LookupOptions lookup;
        lookup.tightening = picture.tightening;
        lookup.plane_distance = 0.03f * glm::length(stage_.max - stage_.min);
        // gamma is crossings a metre; light scattered evenly to all sides.
        lookup.ray_strength = picture.scattering.y * lookup.plane_distance / (4 * 3.14159265f);
        if (const Status set = water_->setLookup(lookup); !set) return set;
        if (source == Source::LiveBake) return bakeLive();
        if (source != Source::CausticMap || map_current_) return Done{};
        runtime::CausticMapOptions map;
        map.bottom = stage_.min.z, map.top = stage_.water.level;
        map.layers = 32, map.resolution = 768;
        map_current_ = true;
        return water_->updateCausticMap(map);
    }

    /// The box of water, or of what scatters; its sides are where the baked box ends.
    void veil(const Picture& picture, const Matrices& matrices, const runtime::Target& target) const {
        const bool wet = !stage_.heights.empty();
        if (!wet && picture.scattering == glm::vec3(0)) return;
        glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
        glEnable(GL_BLEND);
        // What dims also covers: where nothing lies behind lit water, its light is seen before the background.
        glBlendFuncSeparate(GL_ZERO, GL_SRC_COLOR, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
        veil_program_.use();
        veil_program_.set("covers", picture.scattering == glm::vec3(0) ? 0.0f : 1.0f);
        veil_program_.texture("depth_texture", 0, targets_.depth);
        veil_program_.set("world_from_clip", matrices.world_from_clip);
        veil_program_.set("eye", picture.camera.eye);
        veil_program_.set("low", stage_.min);
        veil_program_.set("high", glm::vec3(stage_.max.x, stage_.max.y, wet ? stage_.water.level : stage_.max.z));
        veil_program_.set("extinction", picture.extinction == glm::vec3(0) ? kCleanWater : picture.extinction);
        fullScreen();
        glDisable(GL_BLEND);
    }

    Status media(const Picture& picture, const Matrices&, Source source, const runtime::GBuffer& surfaces,
                 const runtime::Target& target) {
        const runtime::Movers movers = moversOf(picture);
        if (source == Source::Lookup && has_water_ && picture.scattering != glm::vec3(0)) {
            return water_->drawGodRays(surfaces, target, {&movers, 0});
        }
        runtime::GpuVolume* volume = volumeOf(source);
        if (picture.scattering == glm::vec3(0) || !volume) return Done{};
        runtime::MediumOptions medium;
        copy(medium.scattering, picture.scattering);
        copy(medium.absorption, glm::max(glm::vec3(0), picture.extinction - picture.scattering));
        medium.anisotropy = picture.anisotropy;
        medium.steps = picture.steps;
        medium.jitter = runtime::StepJitter::PerPixel;
        medium.extinction = runtime::Extinction::Left;  // veil() has dimmed what is behind the water
        medium.shadows.movers = &movers;
        if (!stage_.heights.empty()) copy(medium.surface, {0, 0, 1}), medium.surface[3] = stage_.water.level;
        return media_->draw(surfaces, target, {{volume}}, medium);
    }

    void waterSurface(const Picture& picture, const Matrices& matrices, int side, const glm::vec3& sun) const {
        if (!picture.surface || sheets_.empty()) return;
        glBindFramebuffer(GL_FRAMEBUFFER, targets_.surface_framebuffers[side]);
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_FALSE);
        glEnable(GL_BLEND);
        glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
        surface_program_.use();
        surface_program_.set("clip_from_world", matrices.clip_from_world);
        surface_program_.set("place", glm::vec4(0, 0, 0, 1));
        surface_program_.set("eye", picture.camera.eye);
        surface_program_.set("sun_direction", sun);
        surface_program_.set("sky", 0.25f * stage_.reference * stage_.level / 3.14159265f);
        surface_program_.set("metal", stage_.sheet_reflectance);
        surface_program_.set("low", stage_.min);
        surface_program_.set("high", stage_.max);
        surface_program_.set("ior", stage_.light.ior);
        sheets_.draw();
        glDisable(GL_BLEND);
        glDisable(GL_DEPTH_TEST);
        glDepthMask(GL_TRUE);
    }

    runtime::GpuContext context_;
    std::optional<runtime::ReceiverPass> receivers_;
    std::optional<runtime::MediumPass> media_;
    std::optional<runtime::LiveWater> water_;
    std::optional<runtime::LiveBake> live_;
    std::optional<runtime::BentRayPass> bent_;
    std::optional<runtime::GpuIndexVolumes> objects_;
    GLuint environment_texture_ = 0;
    float environment_irradiance_ = 0;
    runtime::Harmonics environment_harmonics_{};
    ShownVolumes volumes_;
    Stage stage_;
    Program stage_program_, base_program_, veil_program_, surface_program_, display_program_;
    Mesh room_, solids_, sheets_, ball_;
    Targets targets_;
    GLuint empty_array_ = 0, height_texture_ = 0;
    glm::vec3 extinction_{-1};  ///< that the water has
    bool has_water_ = false, map_current_ = false, live_current_ = false;
};

}  // namespace

runtime::Result<std::unique_ptr<Renderer>> Renderer::create(const runtime::GlLoader& loader) {
    auto context = runtime::GpuContext::create(loader);
    if (!context) return context.error();
    auto renderer = std::make_unique<GlRenderer>(std::move(*context));
    if (const Status built = renderer->build(); !built) return built.error();
    return std::unique_ptr<Renderer>(std::move(renderer));
}

}  // namespace photic::viewer
