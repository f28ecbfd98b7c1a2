// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/moved_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "bake/libraries/toml.h"
#include "bake/report/error.h"
#include "bake/scene/config_tree.h"

namespace photic {
namespace {

/// Keys whose strings name files, wherever they stand.
constexpr std::array<std::string_view, 2> kFileKeys{"file", "index"};
/// So do keys that end like this.
constexpr std::string_view kVolume = "_volume";

/// A piece of the text, and what stands there instead.
struct Replacement {
    std::size_t from, to;
    std::string text;
};

/// Where a line and a column, both from 1 and columns in letters, are in bytes.
std::size_t offsetOf(const std::string& text, const toml::source_position& at) {
    std::size_t byte = 0;
    for (toml::source_index line = 1; line < at.line; ++line) byte = text.find('\n', byte) + 1;
    for (toml::source_index column = 1; column < at.column && byte < text.size(); ++column) {
        ++byte;
        while (byte < text.size() && (static_cast<unsigned char>(text[byte]) & 0xc0) == 0x80) ++byte;
    }
    return byte;
}

class Edit {
public:
    explicit Edit(const std::string& text) : text_(text) {}
    void replace(const toml::node& value, std::string with) {
        pieces_.push_back(
            {offsetOf(text_, value.source().begin), offsetOf(text_, value.source().end), std::move(with)});
    }
    std::string done() {
        std::sort(pieces_.begin(), pieces_.end(), [](const auto& a, const auto& b) { return a.from > b.from; });
        std::string out = text_;
        for (Replacement& piece : pieces_) {
            // Numbers that stood on several lines keep them.
            const auto lines = std::count(text_.begin() + static_cast<std::ptrdiff_t>(piece.from),
                                          text_.begin() + static_cast<std::ptrdiff_t>(piece.to), '\n');
            if (piece.text.back() == ']')
                piece.text.insert(piece.text.size() - 1, static_cast<std::size_t>(lines), '\n');
            out.replace(piece.from, piece.to - piece.from, piece.text);
        }
        return out;
    }

private:
    const std::string& text_;
    std::vector<Replacement> pieces_;
};

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out + '"';
}

bool namesFiles(std::string_view key) {
    return std::find(kFileKeys.begin(), kFileKeys.end(), key) != kFileKeys.end() ||
           (key.size() > kVolume.size() && key.substr(key.size() - kVolume.size()) == kVolume);
}

/// @param is_file  whether a string here is a file's name; of an index there may be three in an array
void makeFilesAbsolute(const toml::node& node, bool is_file, const std::filesystem::path& directory, Edit& edit) {
    if (const auto* file = node.as_string()) {
        if (is_file && std::filesystem::path(file->get()).is_relative())
            edit.replace(node, quoted((directory / file->get()).string()));
    }
    if (const auto* array = node.as_array()) {
        for (const toml::node& item : *array) makeFilesAbsolute(item, is_file, directory, edit);
    }
    if (const auto* table = node.as_table()) {
        for (const auto& [key, value] : *table) makeFilesAbsolute(value, namesFiles(key.str()), directory, edit);
    }
}

void move(const toml::table& light, const MovedLight& to, const std::string& name, Edit& edit) {
    const auto refuse = [&](const std::string& why) {
        const auto& at = light.source().begin;
        throw Error(ErrorCode::Input, fmt::format("light {} {}", to.number + 1, why),
                    fmt::format("{}:{}:{}", name, at.line, at.column));
    };
    if (light.contains("keyframes")) refuse("moves by its keyframes; only lights that stand still can be moved");
    const auto set = [&](std::initializer_list<const char*> keys, const std::optional<glm::dvec3>& place) {
        if (!place) return;
        for (const char* key : keys) {
            if (const toml::node* value = light.get(key))
                return edit.replace(*value, fmt::format("[{}, {}, {}]", place->x, place->y, place->z));
        }
        refuse(fmt::format("has no '{}' to be moved by", *keys.begin()));
    };
    set({"position", "center"}, to.position);
    set({"direction"}, to.direction);
}

}  // namespace

std::string withMovedLights(const std::string& text, const std::string& name, const std::string& directory,
                            const std::vector<MovedLight>& moved) {
    parseConfig(text, name);  // whose messages are those of a bake
    const toml::table root = toml::parse(text);
    Edit edit(text);
    makeFilesAbsolute(root, false, std::filesystem::absolute(directory.empty() ? "." : directory), edit);
    const toml::array* lights = root["light"].as_array();
    for (const MovedLight& to : moved) {
        const toml::node* light = lights ? lights->get(to.number) : nullptr;
        if (!light || !light->is_table())
            throw Error(ErrorCode::Input,
                        fmt::format("there is no light {}; {}", to.number + 1,
                                    lights ? fmt::format("the scene has {}", lights->size()) : "add [[light]]"),
                        name);
        move(*light->as_table(), to, name, edit);
    }
    return edit.done();
}

}  // namespace photic
