// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "runtime/src/gl_functions.h"

namespace photic::runtime {

/// Sets uniforms of one program by name; names that the program does not use are left out. The program is made current.
class Uniforms {
public:
    Uniforms(const GlFunctions& gl, GLuint program) : gl_(gl), program_(program) { gl_.UseProgram(program_); }

    void set(const char* name, float x) const { gl_.Uniform1f(at(name), x); }
    void set(const char* name, float x, float y) const { gl_.Uniform2f(at(name), x, y); }
    void set(const char* name, float x, float y, float z, float w) const { gl_.Uniform4f(at(name), x, y, z, w); }
    void set(const char* name, int x) const { gl_.Uniform1i(at(name), x); }
    void set(const char* name, int x, int y) const { gl_.Uniform2i(at(name), x, y); }
    void set(const char* name, int x, int y, int z, int w) const { gl_.Uniform4i(at(name), x, y, z, w); }
    void set3(const char* name, const float* v) const { gl_.Uniform3fv(at(name), 1, v); }
    void set4(const char* name, const float* v) const { gl_.Uniform4fv(at(name), 1, v); }
    /// Column by column.
    void setMatrix(const char* name, const float* m) const { gl_.UniformMatrix4fv(at(name), 1, GL_FALSE, m); }
    /// Binds a texture to a unit and the unit to a sampler; the sampler object of the unit is taken off.
    void texture(const char* name, int unit, GLenum target, GLuint texture) const {
        gl_.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
        gl_.BindSampler(static_cast<GLuint>(unit), 0);
        gl_.BindTexture(target, texture);
        gl_.Uniform1i(at(name), unit);
    }

private:
    GLint at(const char* name) const { return gl_.GetUniformLocation(program_, name); }
    const GlFunctions& gl_;
    GLuint program_;
};

}  // namespace photic::runtime
