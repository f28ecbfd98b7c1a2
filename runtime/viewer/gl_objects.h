// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <epoxy/gl.h>

#include <glm/gtc/type_ptr.hpp>
#include <string>
#include <utility>
#include <vector>

#include "photic/result.h"
#include "runtime/viewer/stage.h"

namespace photic::viewer {

/// A linked program and its uniforms by name.
class Program {
public:
    Program() = default;
    ~Program() { glDeleteProgram(name_); }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    /// @return Error{Shader} with the driver's log
    runtime::Status build(const char* vertex, const char* fragment);
    void use() const { glUseProgram(name_); }
    void set(const char* name, float v) const { glUniform1f(at(name), v); }
    void set(const char* name, const glm::vec3& v) const { glUniform3fv(at(name), 1, glm::value_ptr(v)); }
    void set(const char* name, const glm::vec4& v) const { glUniform4fv(at(name), 1, glm::value_ptr(v)); }
    void set(const char* name, const std::vector<glm::vec4>& v) const {
        glUniform4fv(at(name), static_cast<GLsizei>(v.size()), v.empty() ? nullptr : glm::value_ptr(v.front()));
    }
    void set(const char* name, const glm::mat4& v) const {
        glUniformMatrix4fv(at(name), 1, GL_FALSE, glm::value_ptr(v));
    }
    void texture(const char* name, int unit, GLuint texture) const {
        glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
        glBindTexture(GL_TEXTURE_2D, texture);
        glUniform1i(at(name), unit);
    }

private:
    GLint at(const char* name) const { return glGetUniformLocation(name_, name); }
    GLuint name_ = 0;
};

/// Triangles on the GPU.
class Mesh {
public:
    Mesh() = default;
    ~Mesh();
    Mesh(const Mesh&) = delete;
    Mesh& operator=(const Mesh&) = delete;

    void upload(const StageTriangles& triangles);
    void draw() const;
    bool empty() const { return count_ == 0; }

private:
    GLuint buffer_ = 0, array_ = 0;
    GLsizei count_ = 0;
};

/// The textures that a frame is drawn through, made again when the size changes.
class Targets {
public:
    Targets() = default;
    ~Targets() { clear(); }
    Targets(const Targets&) = delete;
    Targets& operator=(const Targets&) = delete;

    /// @return Error{Memory} when the framebuffers cannot be made
    runtime::Status resize(int width, int height);

    GLuint depth = 0, normals = 0, albedo = 0;
    GLuint seen = 0, seen_framebuffer = 0;                  ///< a copy of the radiance, for bent rays to meet
    GLuint stage_framebuffer = 0;                           ///< normals, albedo, depth
    GLuint radiance[2] = {0, 0}, framebuffers[2] = {0, 0};  ///< of the two halves, float, without depth
    GLuint surface_framebuffers[2] = {0, 0};                ///< the same with the stage's depth

private:
    void clear();
    int width_ = 0, height_ = 0;
};

}  // namespace photic::viewer
