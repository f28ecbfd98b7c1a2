// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "photic/runtime_gl.h"
#include "runtime/src/gl_functions.h"

namespace photic::test {

/// A perspective camera.
struct Eye {
    glm::dvec3 position{0}, target{0, 0, -1}, up{0, 0, 1};
    double vertical_degrees = 50, near = 0.1, far = 100;
    int width = 64, height = 48;
    bool reversed_depth = false;  ///< 1 near, 0 far, clip depth 0 to 1

    glm::dmat4 clipFromWorld() const;
    /// Unit direction through the middle of a pixel; row 0 at the bottom.
    glm::dvec3 direction(int x, int y) const;
};

/// What an eye ray meets.
struct Hit {
    double distance;  ///< [m]
    glm::dvec3 normal;
    glm::dvec3 albedo{1};
};
using Trace = std::function<std::optional<Hit>(const glm::dvec3& origin, const glm::dvec3& direction)>;

/// Nearest of some planes, as (point, normal).
Trace planes(std::vector<std::pair<glm::dvec3, glm::dvec3>> all);

/// The contents of a G-buffer, row 0 at the bottom.
struct Drawing {
    Drawing(int w, int h);
    int width, height;
    std::vector<float> depth;            ///< one a pixel
    std::vector<float> normals, albedo;  ///< four a pixel
    glm::dmat4 world_from_clip{1};
    glm::dvec3 camera{0};
    bool reversed_depth = false;
};

/// What an eye sees, by casting rays on the CPU.
Drawing drawingOf(const Eye& eye, const Trace& trace);

/// A G-buffer and a float target of its size; both are deleted at the end.
class DrawnView {
public:
    DrawnView(const runtime::GlFunctions& gl, const Drawing& drawing);
    DrawnView(const runtime::GlFunctions& gl, const Eye& eye, const Trace& trace)
        : DrawnView(gl, drawingOf(eye, trace)) {}
    ~DrawnView();
    DrawnView(const DrawnView&) = delete;
    DrawnView& operator=(const DrawnView&) = delete;

    runtime::GBuffer surfaces;
    runtime::Target target;

    void fill(float r, float g, float b) const;
    /// RGBA of the target, row 0 at the bottom.
    std::vector<float> pixels() const;

private:
    const runtime::GlFunctions& gl_;
    unsigned textures_[4] = {};
};

}  // namespace photic::test
