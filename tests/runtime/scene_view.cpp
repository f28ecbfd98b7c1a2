// SPDX-License-Identifier: Apache-2.0
#include "tests/runtime/scene_view.h"

#include <cmath>
#include <cstddef>
#include <glm/gtc/matrix_transform.hpp>

namespace photic::test {

using namespace runtime;

glm::dmat4 Eye::clipFromWorld() const {
    const double aspect = static_cast<double>(width) / height, angle = glm::radians(vertical_degrees);
    const glm::dmat4 clip_from_eye = reversed_depth ? glm::perspectiveRH_ZO(angle, aspect, far, near)
                                                    : glm::perspectiveRH_NO(angle, aspect, near, far);
    return clip_from_eye * glm::lookAt(position, target, up);
}

glm::dvec3 Eye::direction(int x, int y) const {
    const glm::dvec4 p =
        glm::inverse(clipFromWorld()) * glm::dvec4(2 * (x + 0.5) / width - 1, 2 * (y + 0.5) / height - 1, 0.5, 1);
    return glm::normalize(glm::dvec3(p) / p.w - position);
}

Trace planes(std::vector<std::pair<glm::dvec3, glm::dvec3>> all) {
    return [all = std::move(all)](const glm::dvec3& origin, const glm::dvec3& direction) {
        std::optional<Hit> nearest;
        for (const auto& [point, normal] : all) {
            const double t = glm::dot(point - origin, normal) / glm::dot(direction, normal);
            if (t > 0 && (!nearest || t < nearest->distance)) {
                nearest = Hit{t, glm::dot(direction, normal) > 0 ? -normal : normal};
            }
        }
        return nearest;
    };
}

Drawing::Drawing(int w, int h)
    : width(w),
      height(h),
      depth(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), 1.0F),
      normals(4 * depth.size(), 0.0F),
      albedo(4 * depth.size(), 0.0F) {}

Drawing drawingOf(const Eye& eye, const Trace& trace) {
    Drawing out(eye.width, eye.height);
    const glm::dmat4 clip_from_world = eye.clipFromWorld();
    out.world_from_clip = glm::inverse(clip_from_world);
    out.camera = eye.position;
    out.reversed_depth = eye.reversed_depth;
    for (int y = 0; y < eye.height; ++y) {
        for (int x = 0; x < eye.width; ++x) {
            const auto at =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(eye.width) + static_cast<std::size_t>(x);
            out.depth[at] = eye.reversed_depth ? 0.0F : 1.0F;
            const glm::dvec3 direction = eye.direction(x, y);
            const auto hit = trace(eye.position, direction);
            if (!hit) continue;
            const glm::dvec4 clip = clip_from_world * glm::dvec4(eye.position + hit->distance * direction, 1);
            out.depth[at] = static_cast<float>(eye.reversed_depth ? clip.z / clip.w : 0.5 + 0.5 * clip.z / clip.w);
            for (int c = 0; c < 3; ++c) {
                out.normals[4 * at + static_cast<std::size_t>(c)] = static_cast<float>(hit->normal[c]);
                out.albedo[4 * at + static_cast<std::size_t>(c)] = static_cast<float>(hit->albedo[c]);
            }
        }
    }
    return out;
}

DrawnView::DrawnView(const GlFunctions& gl, const Drawing& drawing) : gl_(gl) {
    gl.GenTextures(4, textures_);
    const auto texture = [&](int n, GLenum format, GLenum layout, const float* data) {
        gl.BindTexture(GL_TEXTURE_2D, textures_[n]);
        gl.TexStorage2D(GL_TEXTURE_2D, 1, format, drawing.width, drawing.height);
        if (data) gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, drawing.width, drawing.height, layout, GL_FLOAT, data);
    };
    texture(0, GL_R32F, GL_RED, drawing.depth.data());
    texture(1, GL_RGBA32F, GL_RGBA, drawing.normals.data());
    texture(2, GL_RGBA32F, GL_RGBA, drawing.albedo.data());
    texture(3, GL_RGBA32F, GL_RGBA, nullptr);
    gl.BindTexture(GL_TEXTURE_2D, 0);

    surfaces.depth = textures_[0];
    surfaces.normals = textures_[1];
    surfaces.albedo = textures_[2];
    surfaces.clip_depth = drawing.reversed_depth ? ClipDepth::ZeroToOne : ClipDepth::NegativeOneToOne;
    surfaces.empty_depth = drawing.reversed_depth ? 0.0F : 1.0F;
    for (int i = 0; i < 16; ++i)
        surfaces.world_from_clip[i] = static_cast<float>(drawing.world_from_clip[i / 4][i % 4]);
    for (int i = 0; i < 3; ++i) surfaces.camera[i] = static_cast<float>(drawing.camera[i]);

    gl.GenFramebuffers(1, &target.framebuffer);
    gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures_[3], 0);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    target.width = drawing.width;
    target.height = drawing.height;
    fill(0, 0, 0);
}

DrawnView::~DrawnView() {
    gl_.DeleteFramebuffers(1, &target.framebuffer);
    gl_.DeleteTextures(4, textures_);
}

void DrawnView::fill(float r, float g, float b) const {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    const float color[4] = {r, g, b, 0.25F};
    gl_.ClearBufferfv(GL_COLOR, 0, color);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
}

std::vector<float> DrawnView::pixels() const {
    std::vector<float> out(4 * static_cast<std::size_t>(target.width) * static_cast<std::size_t>(target.height));
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, target.framebuffer);
    gl_.ReadPixels(0, 0, target.width, target.height, GL_RGBA, GL_FLOAT, out.data());
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    return out;
}

}  // namespace photic::test
