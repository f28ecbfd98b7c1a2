// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/gl_program.h"

#include <string>

namespace photic::runtime {
namespace {

const char* stageName(GLenum stage) {
    switch (stage) {
        case GL_VERTEX_SHADER:
            return "vertex";
        case GL_FRAGMENT_SHADER:
            return "fragment";
        case GL_GEOMETRY_SHADER:
            return "geometry";
        case GL_COMPUTE_SHADER:
            return "compute";
        default:
            return "unknown";
    }
}

/// The info log of a shader or of a program, through its pair of GL functions.
template <class GetValue, class GetLog>
std::string infoLog(GLuint object, GetValue get_value, GetLog get_log) {
    GLint length = 0;
    get_value(object, GL_INFO_LOG_LENGTH, &length);
    if (length <= 1) return "the driver gives no reason";
    std::string log(static_cast<std::size_t>(length), '\0');
    GLsizei written = 0;
    get_log(object, length, &written, log.data());
    log.resize(static_cast<std::size_t>(written));
    while (!log.empty() && (log.back() == '\n' || log.back() == '\0')) log.pop_back();
    return log;
}

/// "0 = receiver.frag.glsl, 1 = photic_volume.glsl"
std::string legend(const ShaderText& source) {
    std::string out;
    for (std::size_t i = 0; i < source.files.size(); ++i) {
        out += (i ? ", " : "") + std::to_string(i) + " = " + source.files[i];
    }
    return out;
}

Result<GLuint> compile(const GlFunctions& gl, const ShaderSourceText& source) {
    const GLuint shader = gl.CreateShader(source.stage);
    const char* text = source.source.text.c_str();
    gl.ShaderSource(shader, 1, &text, nullptr);
    gl.CompileShader(shader);
    GLint compiled = GL_FALSE;
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_TRUE) return shader;
    const std::string log = infoLog(shader, gl.GetShaderiv, gl.GetShaderInfoLog);
    gl.DeleteShader(shader);
    return Error{ErrorCode::Shader, std::string(stageName(source.stage)) + " shader does not compile on '" +
                                        gl.renderer + "' (sources: " + legend(source.source) + "):\n" + log};
}

}  // namespace

GlslTarget targetOf(const GlFunctions& gl) { return gl.es ? GlslTarget::Es310 : GlslTarget::Gl430; }

Result<GLuint> makeProgram(const GlFunctions& gl, const std::vector<ShaderSourceText>& sources) {
    if (const std::optional<Error> lost = gl.lost()) return *lost;
    const GLuint program = gl.CreateProgram();
    for (const ShaderSourceText& source : sources) {
        const Result<GLuint> shader = compile(gl, source);
        if (!shader) {
            gl.DeleteProgram(program);
            return shader.error();
        }
        gl.AttachShader(program, *shader);
        gl.DeleteShader(*shader);  // goes with the program
    }
    gl.LinkProgram(program);
    GLint linked = GL_FALSE;
    gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked == GL_TRUE) return program;
    const std::string log = infoLog(program, gl.GetProgramiv, gl.GetProgramInfoLog);
    gl.DeleteProgram(program);
    return Error{ErrorCode::Shader, "the program of " + legend(sources.back().source) + " does not link on '" +
                                        gl.renderer + "':\n" + log};
}

Result<GLuint> makeProgram(const GlFunctions& gl, const std::vector<ShaderStage>& stages,
                           const std::vector<Define>& defines) {
    std::vector<ShaderSourceText> sources;
    for (const ShaderStage& stage : stages) {
        Result<ShaderText> text = assembleShader(stage.file, targetOf(gl), defines);
        if (!text) return text.error();
        sources.push_back({stage.stage, std::move(*text)});
    }
    return makeProgram(gl, sources);
}

}  // namespace photic::runtime
