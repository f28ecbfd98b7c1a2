// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/config_meaning.h"

#include <fmt/format.h>

#include <map>

namespace photic {

std::string meaningOf(const ConfigValue& value) {
    using Kind = ConfigValue::Kind;
    constexpr std::int64_t kExact = std::int64_t{1} << 53;
    // Lengths before texts, so that no two trees read alike.
    const auto counted = [](const std::string& text) { return fmt::format("{}:{}", text.size(), text); };
    switch (value.kind) {
        case Kind::Boolean:
            return value.boolean ? "true" : "false";
        case Kind::Integer:
            // Beyond 2^53 neighbouring integers are one number.
            if (value.integer > kExact || value.integer < -kExact) return fmt::format("{}", value.integer);
            [[fallthrough]];
        case Kind::Number:
            return fmt::format("{}", value.number == 0 ? 0.0 : value.number);
        case Kind::String:
        case Kind::Date:
            return counted(value.string);
        case Kind::Array: {
            std::string text = "[";
            for (const ConfigValue& item : value.items) text += meaningOf(item) + ",";
            return text + "]";
        }
        case Kind::Table:
            break;
    }
    std::map<std::string, std::string> entries;
    for (const ConfigEntry& entry : value.entries) entries[entry.key] = meaningOf(entry.value);
    std::string text = "{";
    for (const auto& [key, meaning] : entries) text += counted(key) + "=" + meaning + ",";
    return text + "}";
}

}  // namespace photic
