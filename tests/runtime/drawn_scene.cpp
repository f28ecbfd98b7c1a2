// SPDX-License-Identifier: Apache-2.0
#include "tests/runtime/drawn_scene.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>

namespace photic::test {
namespace {

GLuint makeTarget(const runtime::GlFunctions& gl, GLenum format, int width, int height, GLenum channels,
                  const void* pixels) {
    GLuint name = 0;
    gl.GenTextures(1, &name);
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, name);
    gl.TexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
    if (pixels) gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, channels, GL_FLOAT, pixels);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.BindTexture(GL_TEXTURE_2D, 0);
    return name;
}

glm::dvec3 through(const glm::dmat4& m, const glm::dvec3& p) {
    const glm::dvec4 q = m * glm::dvec4(p, 1);
    return glm::dvec3(q) / q.w;
}

}  // namespace

DrawnScene::DrawnScene(const runtime::GlFunctions& gl, const DrawnView& view, int width, int height,
                       const std::function<DrawnPoint(const glm::dvec3& near, const glm::dvec3& far)>& at)
    : gl_(gl), width_(width), height_(height) {
    const glm::dmat4 clip_from_world(view.clip_from_world);
    const glm::mat4 inverse(glm::inverse(clip_from_world));
    const glm::dmat4 world_from_clip(inverse);
    std::vector<float> depth;
    std::vector<glm::vec4> normal, albedo;
    for (int j = 0; j < height; ++j) {
        for (int i = 0; i < width; ++i) {
            const double x = (i + 0.5) / width * 2 - 1, y = (j + 0.5) / height * 2 - 1;
            const DrawnPoint p = at(through(world_from_clip, {x, y, -1}), through(world_from_clip, {x, y, 1}));
            const auto stored =
                p.drawn ? static_cast<float>(through(clip_from_world, glm::dvec3(p.position)).z * 0.5 + 0.5) : 1.0f;
            depth.push_back(stored);
            normal.emplace_back(p.normal, 0);
            albedo.emplace_back(p.albedo, 1);
            positions_.push_back(through(world_from_clip, {x, y, stored * 2.0 - 1}));
        }
    }
    gbuffer_.depth = makeTarget(gl, GL_R32F, width, height, GL_RED, depth.data());
    gbuffer_.normals = makeTarget(gl, GL_RGBA32F, width, height, GL_RGBA, normal.data());
    gbuffer_.albedo = makeTarget(gl, GL_RGBA32F, width, height, GL_RGBA, albedo.data());
    std::copy_n(glm::value_ptr(inverse), 16, gbuffer_.world_from_clip);
    std::copy_n(glm::value_ptr(view.eye), 3, gbuffer_.camera);
    target_ = makeTarget(gl, GL_RGBA32F, width, height, GL_RGBA, nullptr);
    gl.GenFramebuffers(1, &framebuffer_);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target_, 0);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
}

DrawnScene::~DrawnScene() {
    for (const GLuint name : {gbuffer_.depth, gbuffer_.normals, gbuffer_.albedo, target_}) gl_.DeleteTextures(1, &name);
    gl_.DeleteFramebuffers(1, &framebuffer_);
}

runtime::Target DrawnScene::target() const {
    const float black[4] = {0, 0, 0, 0};
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    gl_.ClearBufferfv(GL_COLOR, 0, black);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
    return {framebuffer_, 0, 0, width_, height_};
}

std::vector<float> DrawnScene::read() const {
    std::vector<float> out(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 4);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    gl_.ReadPixels(0, 0, width_, height_, GL_RGBA, GL_FLOAT, out.data());
    gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
    return out;
}

}  // namespace photic::test
