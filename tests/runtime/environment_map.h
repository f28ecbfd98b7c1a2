// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <glm/vec3.hpp>
#include <vector>

#include "runtime/src/gl_functions.h"

namespace photic::test {

/// Surroundings as `Surroundings::environment` takes them: directions by angle around z and height, floats.
class EnvironmentMap {
public:
    /// @param texels  red, green, blue, alpha; rows from straight down upwards
    /// @param filter  GL_LINEAR or GL_NEAREST
    EnvironmentMap(const runtime::GlFunctions& gl, int width, int height, const std::vector<float>& texels,
                   GLint filter = GL_LINEAR)
        : gl_(gl) {
        gl.GenTextures(1, &texture);
        gl.BindTexture(GL_TEXTURE_2D, texture);
        gl.TexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32F, width, height);
        gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, GL_RGBA, GL_FLOAT, texels.data());
        for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
            gl.TexParameteri(GL_TEXTURE_2D, name, filter);
        gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
        gl.BindTexture(GL_TEXTURE_2D, 0);
    }
    /// @param width   [texels], twice the height
    /// @param colour  of a unit direction
    template <typename Colour>
    EnvironmentMap(const runtime::GlFunctions& gl, int width, const Colour& colour)
        : EnvironmentMap(gl, width, width / 2, texelsOf(width, colour)) {}
    ~EnvironmentMap() { gl_.DeleteTextures(1, &texture); }
    EnvironmentMap(const EnvironmentMap&) = delete;
    EnvironmentMap& operator=(const EnvironmentMap&) = delete;

    GLuint texture = 0;

private:
    template <typename Colour>
    static std::vector<float> texelsOf(int width, const Colour& colour) {
        const int height = width / 2;
        std::vector<float> texels;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const double up = ((y + 0.5) / height - 0.5) * M_PI, turn = (0.5 - (x + 0.5) / width) * 2 * M_PI;
                const glm::dvec3 c =
                    colour(glm::dvec3(std::cos(up) * std::cos(turn), std::cos(up) * std::sin(turn), std::sin(up)));
                for (const double v : {c.x, c.y, c.z, 1.0}) texels.push_back(static_cast<float>(v));
            }
        return texels;
    }

    const runtime::GlFunctions& gl_;
};

/// Surroundings in which each direction is its own colour: (d + 1) / 2.
struct DirectionMap : EnvironmentMap {
    explicit DirectionMap(const runtime::GlFunctions& gl)
        : EnvironmentMap(gl, 1024, [](const glm::dvec3& d) { return 0.5 * d + 0.5; }) {}
};

}  // namespace photic::test
