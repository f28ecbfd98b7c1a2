// SPDX-License-Identifier: Apache-2.0
#include "runtime/viewer/gl_objects.h"

#include <cstddef>

namespace photic::viewer {

runtime::Status Program::build(const char* vertex, const char* fragment) {
    name_ = glCreateProgram();
    std::string log(4096, '\0');
    GLint good = GL_FALSE;
    for (const auto& [stage, text] : {std::pair{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}}) {
        const GLuint shader = glCreateShader(static_cast<GLenum>(stage));
        glShaderSource(shader, 1, &text, nullptr);
        glCompileShader(shader);
        glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
        if (good == GL_FALSE) {
            glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
            glDeleteShader(shader);
            return runtime::Error{runtime::ErrorCode::Shader, "the viewer's shader does not compile: " + log};
        }
        glAttachShader(name_, shader);
        glDeleteShader(shader);
    }
    glLinkProgram(name_);
    glGetProgramiv(name_, GL_LINK_STATUS, &good);
    if (good == GL_TRUE) return runtime::Done{};
    glGetProgramInfoLog(name_, static_cast<GLsizei>(log.size()), nullptr, log.data());
    return runtime::Error{runtime::ErrorCode::Shader, "the viewer's program does not link: " + log};
}

Mesh::~Mesh() {
    glDeleteBuffers(1, &buffer_);
    glDeleteVertexArrays(1, &array_);
}

void Mesh::upload(const StageTriangles& triangles) {
    if (!array_) {
        glGenVertexArrays(1, &array_);
        glGenBuffers(1, &buffer_);
    }
    glBindVertexArray(array_);
    glBindBuffer(GL_ARRAY_BUFFER, buffer_);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(triangles.size() * sizeof(StageVertex)), triangles.data(),
                 GL_STATIC_DRAW);
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(StageVertex), nullptr);
    glEnableVertexAttribArray(1);
    glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, sizeof(StageVertex),
                          reinterpret_cast<const void*>(offsetof(StageVertex, normal)));
    glBindVertexArray(0);
    count_ = static_cast<GLsizei>(triangles.size());
}

void Mesh::draw() const {
    if (empty()) return;
    glBindVertexArray(array_);
    glDrawArrays(GL_TRIANGLES, 0, count_);
    glBindVertexArray(0);
}

void Targets::clear() {
    for (const GLuint* texture : {&depth, &normals, &albedo, &radiance[0], &radiance[1], &seen})
        glDeleteTextures(1, texture);
    for (const GLuint* framebuffer : {&seen_framebuffer, &stage_framebuffer, &framebuffers[0], &framebuffers[1],
                                      &surface_framebuffers[0], &surface_framebuffers[1]}) {
        glDeleteFramebuffers(1, framebuffer);
    }
    depth = normals = albedo = radiance[0] = radiance[1] = stage_framebuffer = seen = seen_framebuffer = 0;
    framebuffers[0] = framebuffers[1] = surface_framebuffers[0] = surface_framebuffers[1] = 0;
    width_ = height_ = 0;
}

runtime::Status Targets::resize(int width, int height) {
    if (width == width_ && height == height_) return runtime::Done{};
    clear();
    const auto texture = [&](GLenum format) {
        GLuint name = 0;
        glGenTextures(1, &name);
        glBindTexture(GL_TEXTURE_2D, name);
        glTexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        return name;
    };
    bool complete = true;
    const auto framebuffer = [&](GLuint first, GLuint second, GLuint depth_texture) {
        GLuint name = 0;
        glGenFramebuffers(1, &name);
        glBindFramebuffer(GL_FRAMEBUFFER, name);
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, first, 0);
        if (second) glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, second, 0);
        if (depth_texture) glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_texture, 0);
        const GLenum both[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
        glDrawBuffers(second ? 2 : 1, both);
        complete = complete && glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
        return name;
    };
    depth = texture(GL_DEPTH_COMPONENT32F);
    normals = texture(GL_RGBA16F);
    albedo = texture(GL_RGBA8);
    stage_framebuffer = framebuffer(normals, albedo, depth);
    seen = texture(GL_RGBA16F);
    seen_framebuffer = framebuffer(seen, 0, 0);
    for (int i = 0; i < 2; ++i) {
        radiance[i] = texture(GL_RGBA16F);
        framebuffers[i] = framebuffer(radiance[i], 0, 0);
        surface_framebuffers[i] = framebuffer(radiance[i], 0, depth);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    if (!complete) {
        return runtime::Error{runtime::ErrorCode::Memory, "the GPU cannot make framebuffers of " +
                                                              std::to_string(width) + " x " + std::to_string(height)};
    }
    width_ = width, height_ = height;
    return runtime::Done{};
}

}  // namespace photic::viewer
