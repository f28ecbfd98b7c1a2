// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "photic/result.h"

namespace photic::runtime {

/// A macro of a shader; an empty value defines the bare name.
struct Define {
    std::string name, value;
};

/// What a shader is compiled for.
enum class GlslTarget {
    Gl430,  ///< #version 430 core
    Gl460,  ///< #version 460 core
    Es310   ///< #version 310 es, with high precision throughout
};

/// A shader's whole text, and the files that it is made of: `#line` directives name them by their place in `files`.
struct ShaderText {
    std::string text;
    std::vector<std::string> files;
};

/// The text of runtime/shaders/`file` as built into the library; null when there is none.
const char* embeddedShader(std::string_view file);

/// All names of embedded files, sorted.
std::vector<std::string> embeddedShaders();

/// `file` with each `#include "other"` replaced by that file's text, once per text, behind the version and the defines.
/// @return Error{Shader} naming a file that is not there
Result<ShaderText> assembleShader(std::string_view file, GlslTarget target, const std::vector<Define>& defines);

/// The same without version and defines, for a game's own shader: `file` and what it includes.
Result<std::string> resolveIncludes(std::string_view file);

}  // namespace photic::runtime
