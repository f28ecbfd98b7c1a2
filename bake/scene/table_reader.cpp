// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/table_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include <numbers>

#include "bake/report/error.h"
#include "bake/scene/load_toml.h"
#include "bake/scene/plain_text.h"
#include "bake/scene/unit_vector.h"

namespace photic {
namespace {

bool contains(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

std::string didYouMean(const std::string& given, const std::vector<std::string>& known) {
    const std::string near = nearestName(given, known);
    return near.empty() ? fmt::format("known: {}", fmt::join(known, ", ")) : fmt::format("did you mean '{}'?", near);
}

std::string inWords(const Bounds& b) {
    const std::string unit = *b.unit ? std::string(" ") + b.unit : std::string();
    if (std::isfinite(b.min) && std::isfinite(b.max)) return fmt::format("it must be {} to {}{}", b.min, b.max, unit);
    if (std::isfinite(b.max)) return fmt::format("it must be at most {}{}", b.max, unit);
    return b.open_min ? fmt::format("it must be greater than {}{}", b.min, unit)
                      : fmt::format("it must be at least {}{}", b.min, unit);
}

}  // namespace

std::string nearestName(const std::string& given, const std::vector<std::string>& known) {
    std::string best;
    std::size_t best_distance = std::max<std::size_t>(2, given.size() / 3) + 1;
    for (const std::string& name : known) {
        // Edit distance, one row at a time.
        std::vector<std::size_t> row(name.size() + 1);
        for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
        for (std::size_t i = 0; i < given.size(); ++i) {
            std::size_t diagonal = row[0];
            row[0] = i + 1;
            for (std::size_t j = 0; j < name.size(); ++j) {
                const std::size_t changed = diagonal + (given[i] == name[j] ? 0 : 1);
                diagonal = row[j + 1];
                row[j + 1] = std::min({changed, row[j] + 1, row[j + 1] + 1});
            }
        }
        // A distance as long as the name itself is no likeness.
        if (row.back() < best_distance && row.back() < name.size()) best_distance = row.back(), best = name;
    }
    return best;
}

TableReader::TableReader(const ConfigValue& table, std::string title, std::vector<std::string> known,
                         const std::vector<std::string>& not_built)
    : table_(table), title_(std::move(title)) {
    if (table.kind != ConfigValue::Kind::Table)
        failAt(table.where, fmt::format("{} is {}; it must be a table", title_, table.kindName()));
    for (const auto& [key, value] : table.entries) {
        if (contains(known, key)) continue;
        if (contains(not_built, key))
            failAt(value.where, fmt::format("'{}' in {} is not built yet; remove it", key, title_));
        failAt(value.where, fmt::format("unknown key '{}' in {}; {}", key, title_, didYouMean(key, known)));
    }
}

const std::string& TableReader::where(const std::string& key) const {
    const ConfigValue* value = find(key);
    return value ? value->where : table_.where;
}

void TableReader::failAt(const std::string& where, const std::string& message) const {
    throw Error(ErrorCode::Input, visible(message), where);
}

void TableReader::refuseControl(const std::string& key, const ConfigValue& value) const {
    const auto bad = std::find_if(value.string.begin(), value.string.end(), [](char c) {
        const auto byte = static_cast<unsigned char>(c);
        return byte < 0x20 || byte == 0x7f;
    });
    if (bad != value.string.end())
        failAt(value.where,
               fmt::format("'{}' holds the control character {} at its character {}; names and files have none", key,
                           visible(std::string(1, *bad)), bad - value.string.begin() + 1));
}

void TableReader::missing(const std::string& key, const std::string& example) const {
    fail(fmt::format("{} needs '{}', for example {}", title_, key, example));
}

void TableReader::exclusive(const std::vector<std::string>& keys) const {
    std::vector<std::string> given;
    for (const std::string& key : keys)
        if (has(key)) given.push_back(key);
    if (given.size() > 1)
        fail(given[1],
             fmt::format("{} has both '{}' and '{}', which contradict; keep one", title_, given[0], given[1]));
}

double TableReader::checkedNumber(const ConfigValue& value, const std::string& key, const Bounds& b) const {
    if (value.kind != ConfigValue::Kind::Integer && value.kind != ConfigValue::Kind::Number)
        failAt(value.where, fmt::format("'{}' is {}; it must be a number", key, value.kindName()));
    const double v = value.number;
    if (!std::isfinite(v)) failAt(value.where, fmt::format("'{}' is {}; it must be finite", key, v));
    if (v < b.min || v > b.max || (b.open_min && v == b.min))
        failAt(value.where, fmt::format("'{}' is {}; {}", key, v, inWords(b)));
    return v;
}

void TableReader::numbers(const ConfigValue& value, const std::string& key, const Bounds& bounds, std::size_t count,
                          double* out) const {
    if (value.kind != ConfigValue::Kind::Array)
        failAt(value.where, fmt::format("'{}' is {}; it must be an array of {} numbers", key, value.kindName(), count));
    if (value.items.size() != count)
        failAt(value.where, fmt::format("'{}' has {} numbers; it must have {}", key, value.items.size(), count));
    for (std::size_t i = 0; i < count; ++i) out[i] = checkedNumber(value.items[i], key, bounds);
}

std::optional<double> TableReader::number(const std::string& key, const Bounds& bounds) const {
    const ConfigValue* value = find(key);
    if (!value) return std::nullopt;
    return checkedNumber(*value, key, bounds);
}

std::optional<std::int64_t> TableReader::integer(const std::string& key, std::int64_t min, std::int64_t max) const {
    const ConfigValue* value = find(key);
    if (!value) return std::nullopt;
    if (value->kind != ConfigValue::Kind::Integer)
        fail(key, fmt::format("'{}' is {}; it must be an integer", key, value->kindName()));
    if (value->integer < min || value->integer > max)
        fail(key, fmt::format("'{}' is {}; it must be {} to {}", key, value->integer, min, max));
    return value->integer;
}

std::optional<bool> TableReader::flag(const std::string& key) const {
    const ConfigValue* value = find(key);
    if (!value) return std::nullopt;
    if (value->kind != ConfigValue::Kind::Boolean)
        fail(key, fmt::format("'{}' is {}; it must be true or false", key, value->kindName()));
    return value->boolean;
}

std::optional<std::string> TableReader::text(const std::string& key) const {
    const ConfigValue* value = find(key);
    if (!value) return std::nullopt;
    if (value->kind != ConfigValue::Kind::String)
        fail(key, fmt::format("'{}' is {}; it must be a string", key, value->kindName()));
    if (value->string.empty()) fail(key, fmt::format("'{}' is empty", key));
    refuseControl(key, *value);
    return value->string;
}

std::optional<std::size_t> TableReader::choice(const std::string& key, const std::vector<std::string>& choices,
                                               const std::vector<std::string>& not_built) const {
    const std::optional<std::string> name = text(key);
    if (!name) return std::nullopt;
    if (contains(not_built, *name))
        fail(key, fmt::format("{} = \"{}\" is not built yet; use {}", key, *name, fmt::join(choices, ", ")));
    const auto found = std::find(choices.begin(), choices.end(), *name);
    if (found == choices.end()) fail(key, fmt::format("unknown {} \"{}\"; {}", key, *name, didYouMean(*name, choices)));
    return static_cast<std::size_t>(found - choices.begin());
}

std::optional<std::vector<std::string>> TableReader::texts(const std::string& key) const {
    const ConfigValue* value = find(key);
    if (!value) return std::nullopt;
    if (value->kind != ConfigValue::Kind::Array)
        fail(key, fmt::format("'{}' is {}; it must be an array of strings", key, value->kindName()));
    std::vector<std::string> out;
    for (const ConfigValue& item : value->items) {
        if (item.kind != ConfigValue::Kind::String)
            failAt(item.where, fmt::format("'{}' contains {}; it must be an array of strings", key, item.kindName()));
        refuseControl(key, item);
        out.push_back(item.string);
    }
    return out;
}

std::optional<glm::dvec2> TableReader::vector2(const std::string& key, const Bounds& bounds) const {
    const ConfigValue* value = find(key);
    if (!value) return std::nullopt;
    glm::dvec2 out;
    numbers(*value, key, bounds, 2, &out.x);
    return out;
}

std::optional<glm::dvec3> TableReader::vector3(const std::string& key, const Bounds& bounds) const {
    const ConfigValue* value = find(key);
    if (!value) return std::nullopt;
    glm::dvec3 out;
    numbers(*value, key, bounds, 3, &out.x);
    return out;
}

std::optional<glm::dvec3> TableReader::colour(const std::string& key, const Bounds& bounds) const {
    const ConfigValue* value = find(key);
    if (!value) return std::nullopt;
    if (value->kind == ConfigValue::Kind::Array) return vector3(key, bounds);
    return glm::dvec3(checkedNumber(*value, key, bounds));
}

std::optional<glm::dvec2> TableReader::heading(const std::string& key) const {
    const ConfigValue* value = find(key);
    if (!value) return std::nullopt;
    if (value->kind != ConfigValue::Kind::Array) {
        const double radians = checkedNumber(*value, key, {}) * std::numbers::pi / 180;
        return glm::dvec2(std::cos(radians), std::sin(radians));
    }
    const glm::dvec2 v = *vector2(key, {});
    if (v == glm::dvec2(0)) fail(key, fmt::format("'{}' has no length; give [x, y] or degrees", key));
    return unitVector(v);
}

}  // namespace photic
