// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "photic/runtime_gl.h"
#include "runtime/src/gl_functions.h"

namespace photic::test {

/// A point that a pixel shows.
struct DrawnPoint {
    glm::vec3 position{0}, normal{0, 0, 1}, albedo{1};
    bool drawn = true;
};

struct DrawnView {
    glm::mat4 clip_from_world{1};
    glm::vec3 eye{0};
};

/// The depth textures of a picture that was never rasterised, filled pixel by pixel, and a float target to draw on.
class DrawnScene {
public:
    /// @param at  what the line of sight through a pixel shows: given its nearest and farthest point
    DrawnScene(const runtime::GlFunctions& gl, const DrawnView& view, int width, int height,
               const std::function<DrawnPoint(const glm::dvec3& near, const glm::dvec3& far)>& at);
    ~DrawnScene();
    DrawnScene(const DrawnScene&) = delete;
    DrawnScene& operator=(const DrawnScene&) = delete;

    const runtime::GBuffer& gbuffer() const { return gbuffer_; }
    /// World positions as the depth texture holds them, row 0 lowest.
    const std::vector<glm::dvec3>& positions() const { return positions_; }
    /// All of the target, black.
    runtime::Target target() const;
    /// Four floats a pixel, row 0 lowest.
    std::vector<float> read() const;

private:
    const runtime::GlFunctions& gl_;
    runtime::GBuffer gbuffer_;
    std::vector<glm::dvec3> positions_;
    int width_ = 0, height_ = 0;
    GLuint target_ = 0, framebuffer_ = 0;
};

}  // namespace photic::test
