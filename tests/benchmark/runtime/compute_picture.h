// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "photic/runtime_gl.h"
#include "runtime/src/gl_functions.h"
#include "runtime/src/uniforms.h"

namespace photic::benchmark {

/// A picture by a compute shader: what the passes' GLSL takes in a renderer that shades in compute. Data-centre cards
/// run fragment shaders on few of their processors (an H100 on 2 of 66 pairs) and compute shaders on all.
class ComputePicture {
public:
    /// @param text   GLSL that defines `vec4 photicPixel(vec2 uv)`, behind #version
    /// @throws std::runtime_error when it does not compile
    ComputePicture(const runtime::GlFunctions& gl, const std::string& text, int width, int height);
    ~ComputePicture();
    ComputePicture(const ComputePicture&) = delete;
    ComputePicture& operator=(const ComputePicture&) = delete;

    /// Dispatches; does not wait.
    /// @param bind  sets uniforms and binds what the text reads; storage buffer 7 is the picture's
    void draw(const std::function<void(const runtime::Uniforms&)>& bind) const;
    /// RGBA, row 0 at the bottom.
    std::vector<float> pixels() const;

private:
    const runtime::GlFunctions& gl_;
    int width_, height_;
    unsigned program_ = 0, out_ = 0;
};

}  // namespace photic::benchmark
