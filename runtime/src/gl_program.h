// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "photic/result.h"
#include "runtime/src/gl_functions.h"
#include "runtime/src/shader_source.h"

namespace photic::runtime {

/// A shader of a program: which stage (GL_VERTEX_SHADER ...) and which file of runtime/shaders.
struct ShaderStage {
    GLenum stage;
    std::string_view file;
};

/// Compiles and links. All shaders get the same defines. The program is the caller's to delete.
/// @return Error{Shader}: the stage, the driver's log, and which file each source number in it means
Result<GLuint> makeProgram(const GlFunctions& gl, const std::vector<ShaderStage>& stages,
                           const std::vector<Define>& defines = {});

/// The same of texts that are whole already: stage and text.
struct ShaderSourceText {
    GLenum stage;
    ShaderText source;
};
Result<GLuint> makeProgram(const GlFunctions& gl, const std::vector<ShaderSourceText>& sources);

/// What a context compiles by default.
GlslTarget targetOf(const GlFunctions& gl);

}  // namespace photic::runtime
