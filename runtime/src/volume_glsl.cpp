// SPDX-License-Identifier: Apache-2.0
#include <cctype>

#include "photic/volume_bytes.h"
#include "runtime/src/guarded.h"
#include "runtime/src/shader_source.h"

namespace photic::runtime {
namespace {

bool inWord(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

/// Each identifier that begins with `photic` begins with `prefix` instead; PhoticLight and PHOTIC_... stay as they are.
std::string renamed(const std::string& text, const std::string& prefix) {
    constexpr std::string_view kOld = "photic";
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool starts = text.compare(i, kOld.size(), kOld) == 0 && (i == 0 || !inWord(text[i - 1]));
        if (starts) {
            out += prefix;
            i += kOld.size() - 1;
        } else {
            out.push_back(text[i]);
        }
    }
    return out;
}

}  // namespace

std::string volumeGlsl(const GlslOptions& options) {
    std::string out;
    const auto define = [&](const char* name, const std::string& value) {
        out += std::string("#undef ") + name + "\n" +
               (value.empty() ? "" : std::string("#define ") + name + " " + value + "\n");
    };
    const unsigned texture = options.first_texture, buffer = options.first_buffer;
    const VulkanBindings at =
        options.vulkan.value_or(VulkanBindings{0, texture, texture + 1, texture + 2, buffer, buffer});
    define("PHOTIC_SET", options.vulkan ? std::to_string(at.set) : "");
    define("PHOTIC_BINDING_LIGHT", std::to_string(at.light));
    define("PHOTIC_BINDING_COLOUR", std::to_string(at.colour));
    define("PHOTIC_BINDING_PAGES", std::to_string(at.pages));
    define("PHOTIC_BINDING_BUFFER", std::to_string(at.parameters));
    define("PHOTIC_BINDING_BRICKS", std::to_string(at.bricks));
    define("PHOTIC_LAYOUT", options.layout == Layout::Atlas ? "1" : options.layout == Layout::Dense ? "2" : "");
    const auto choice = [](Known known) { return known == Known::No ? "0" : known == Known::Yes ? "1" : ""; };
    define("PHOTIC_COLOURED", choice(options.coloured));
    define("PHOTIC_REPEATS", choice(options.repeats));
    define("PHOTIC_LIGHT_IN_BUFFER", options.layout == Layout::Buffer ? "1" : "");
    define("PHOTIC_MOVERS", options.movers ? "1" : "");
    define("PHOTIC_BINDING_MOVERS", std::to_string(options.vulkan ? at.movers : options.mover_buffer));
    define("PHOTIC_BINDING_MOVER_MAP", std::to_string(options.vulkan ? at.mover_map : options.mover_texture));
    define("PHOTIC_EXACT", options.filter == Filter::Exact ? "1" : "");
    for (const char* file : {"photic_volume.glsl", "photic_medium.glsl"}) {
        const Result<std::string> text = resolveIncludes(file);
        if (text) out += renamed(*text, options.prefix);  // both are built in
    }
    return out;
}

}  // namespace photic::runtime
