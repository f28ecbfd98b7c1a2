// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/config_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "bake/libraries/toml.h"
#include "bake/report/error.h"
#include "bake/scene/plain_text.h"

namespace photic {
namespace {

std::string place(const std::string& name, const toml::source_region& source) {
    return fmt::format("{}:{}:{}", name, source.begin.line, source.begin.column);
}

ConfigValue convert(const toml::node& node, const std::string& name) {
    ConfigValue out;
    out.where = place(name, node.source());
    if (const auto* table = node.as_table()) {
        out.kind = ConfigValue::Kind::Table;
        for (const auto& [key, value] : *table) {
            ConfigValue entry = convert(value, name);
            entry.where = place(name, key.source());
            // A table under its own header, or an array of them: the header's place says more than the key's.
            if (value.is_table() && !value.as_table()->is_inline()) entry.where = place(name, value.source());
            out.entries.push_back({std::string(key.str()), std::move(entry)});
        }
        // The library sorts keys; messages follow the file.
        std::stable_sort(out.entries.begin(), out.entries.end(), [&](const auto& a, const auto& b) {
            const auto& sa = table->find(a.key)->first.source().begin;
            const auto& sb = table->find(b.key)->first.source().begin;
            return sa.line != sb.line ? sa.line < sb.line : sa.column < sb.column;
        });
    } else if (const auto* array = node.as_array()) {
        out.kind = ConfigValue::Kind::Array;
        for (const toml::node& item : *array) out.items.push_back(convert(item, name));
    } else if (const auto* boolean = node.as_boolean()) {
        out.kind = ConfigValue::Kind::Boolean, out.boolean = boolean->get();
    } else if (const auto* integer = node.as_integer()) {
        out.kind = ConfigValue::Kind::Integer, out.integer = integer->get(),
        out.number = static_cast<double>(out.integer);
    } else if (const auto* number = node.as_floating_point()) {
        out.kind = ConfigValue::Kind::Number, out.number = number->get();
    } else if (const auto* string = node.as_string()) {
        out.kind = ConfigValue::Kind::String, out.string = string->get();
    } else {
        out.kind = ConfigValue::Kind::Date;
    }
    return out;
}

// Past the string that begins at `at`: to the end of its line where it has none.
std::size_t pastString(std::string_view text, std::size_t at) {
    const char quote = text[at];
    const std::string_view fence = text.substr(at, 3);
    const bool many_lines = fence.size() == 3 && fence[1] == quote && fence[2] == quote;
    for (at += many_lines ? 3 : 1; at < text.size(); ++at) {
        if (quote == '"' && text[at] == '\\')
            ++at;
        else if (!many_lines && (text[at] == quote || text[at] == '\n'))
            return at + 1;
        else if (many_lines && text.substr(at, 3) == fence) {
            at += 3;
            while (at < text.size() && text[at] == quote) ++at;  // up to two quotes may stand before the end
            return at;
        }
    }
    return text.size();
}

// Names without quotes are ASCII. What toml++ 3.3 and 3.4 do with a letter beyond it is undefined.
void refuseStrayLetters(std::string_view text, const std::string& name) {
    for (std::size_t at = 0; at < text.size();) {
        const char c = text[at];
        if (c == '#') {
            at = std::min(text.find('\n', at), text.size());
        } else if (c == '"' || c == '\'') {
            at = pastString(text, at);
        } else if (static_cast<unsigned char>(c) < 0x80) {
            ++at;
        } else {
            const std::string_view before = text.substr(0, at);
            const std::size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0
            std::size_t end = at;
            while (end < text.size() && static_cast<unsigned char>(text[end]) >= 0x80) ++end;
            throw Error(
                ErrorCode::Input,
                fmt::format("'{}' can stand in comments and between quotes alone: put the name or the value that "
                            "it belongs to between quotes",
                            text.substr(at, end - at)),
                fmt::format("{}:{}:{}", name, 1 + std::count(before.begin(), before.end(), '\n'),
                            1 + std::count_if(before.begin() + static_cast<std::ptrdiff_t>(line_start), before.end(),
                                              [](char b) { return (b & 0xc0) != 0x80; })));
        }
    }
}

}  // namespace

const ConfigValue* ConfigValue::find(const std::string& key) const {
    for (const auto& [name, value] : entries)
        if (name == key) return &value;
    return nullptr;
}

const char* ConfigValue::kindName() const {
    switch (kind) {
        case Kind::Boolean:
            return "true or false";
        case Kind::Integer:
            return "an integer";
        case Kind::Number:
            return "a number";
        case Kind::String:
            return "a string";
        case Kind::Array:
            return "an array";
        case Kind::Table:
            return "a table";
        case Kind::Date:
            return "a date";
    }
    return "";
}

ConfigValue parseConfig(const std::string& given, const std::string& name) {
    const std::string_view text = plainText(given, name);
    // The parser descends a level per part of a dotted key, and never asks how deep it is.
    constexpr int kDeepest = 128;
    int line = 1, parts = 0;
    for (const char c : text) {
        line += c == '\n' ? 1 : 0;
        if (c == '.')
            ++parts;
        else if (c == '\n' || c == ',' || c == '=' || c == '"' || c == '\'' || c == '#')
            parts = 0;
        if (parts > kDeepest)
            throw Error(ErrorCode::Input,
                        fmt::format("a key of more than {} dotted parts; no key of a scene has more than 3", kDeepest),
                        fmt::format("{}:{}", name, line));
    }
    refuseStrayLetters(text, name);
    try {
        return convert(toml::parse(text, name), name);
    } catch (const toml::parse_error& error) {
        throw Error(ErrorCode::Input, fmt::format("not valid TOML: {}", error.description()),
                    place(name, error.source()));
    }
}

}  // namespace photic
