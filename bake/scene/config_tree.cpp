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
    try {
        return convert(toml::parse(text, name), name);
    } catch (const toml::parse_error& error) {
        throw Error(ErrorCode::Input, fmt::format("not valid TOML: {}", error.description()),
                    place(name, error.source()));
    }
}

}  // namespace photic
