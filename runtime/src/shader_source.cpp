// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/shader_source.h"

#include <algorithm>
#include <cstring>

#include "runtime/src/embedded_shaders.h"

namespace photic::runtime {
namespace {

enum class LineNumbers { Kept, Left };

/// The name in `#include "name"`; empty for any other line.
std::string_view includedFile(std::string_view line) {
    const std::size_t start = line.find_first_not_of(" \t");
    constexpr std::string_view kDirective = "#include";
    if (start == std::string_view::npos || line.compare(start, kDirective.size(), kDirective) != 0) return {};
    const std::size_t open = line.find('"', start),
                      close = open == std::string_view::npos ? open : line.find('"', open + 1);
    return close == std::string_view::npos ? std::string_view{} : line.substr(open + 1, close - open - 1);
}

/// Appends `file` to `out`, its includes first met in their place. @return the name of a missing file, or nothing
std::string append(std::string_view file, LineNumbers numbers, ShaderText& out) {
    const char* text = embeddedShader(file);
    if (!text) return std::string(file);
    const std::size_t number = out.files.size();
    out.files.emplace_back(file);
    const auto markLine = [&](int line) {
        if (numbers == LineNumbers::Kept)
            out.text += "#line " + std::to_string(line) + " " + std::to_string(number) + "\n";
    };
    markLine(1);
    int line_number = 0;
    for (std::string_view rest = text; !rest.empty();) {
        const std::size_t end = std::min(rest.find('\n'), rest.size());
        const std::string_view line = rest.substr(0, end);
        rest.remove_prefix(std::min(end + 1, rest.size()));
        ++line_number;
        const std::string_view included = includedFile(line);
        if (included.empty()) {
            out.text.append(line).push_back('\n');
        } else if (std::find(out.files.begin(), out.files.end(), included) == out.files.end()) {
            const std::string missing = append(included, numbers, out);
            if (!missing.empty()) return missing;
            markLine(line_number + 1);
        } else {
            out.text.push_back('\n');
        }
    }
    return {};
}

Error missingShader(const std::string& name) {
    return Error{ErrorCode::Shader, "there is no shader '" + name + "' in the library"};
}

const char* header(GlslTarget target) {
    switch (target) {
        case GlslTarget::Gl430:
            return "#version 430 core\n";
        case GlslTarget::Gl460:
            return "#version 460 core\n";
        case GlslTarget::Es310:
            // ES has no default precision for these; half precision would show as bands.
            return "#version 310 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler2D;\n"
                   "precision highp sampler3D;\nprecision highp usampler3D;\nprecision highp sampler2DArray;\n"
                   "precision highp isampler3D;\nprecision highp image2D;\n";
    }
    return "";
}

}  // namespace

const char* embeddedShader(std::string_view file) {
    for (const EmbeddedShader* s = kEmbeddedShaders; s->name; ++s) {
        if (file == s->name) return s->text;
    }
    return nullptr;
}

std::vector<std::string> embeddedShaders() {
    std::vector<std::string> names;
    for (const EmbeddedShader* s = kEmbeddedShaders; s->name; ++s) names.emplace_back(s->name);
    std::sort(names.begin(), names.end());
    return names;
}

Result<ShaderText> assembleShader(std::string_view file, GlslTarget target, const std::vector<Define>& defines) {
    ShaderText out;
    out.text = header(target);
    for (const Define& define : defines) out.text += "#define " + define.name + " " + define.value + "\n";
    const std::string missing = append(file, LineNumbers::Kept, out);
    if (!missing.empty()) return missingShader(missing);
    return out;
}

Result<std::string> resolveIncludes(std::string_view file) {
    ShaderText out;
    const std::string missing = append(file, LineNumbers::Left, out);
    if (!missing.empty()) return missingShader(missing);
    return std::move(out.text);
}

}  // namespace photic::runtime
