// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "bake/scene/config_tree.h"

namespace photic {

/// Bounds of a number, as messages state them.
struct Bounds {
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    bool open_min = false;  ///< min itself is excluded
    const char* unit = "";
};
inline Bounds positive(const char* unit) { return {0, std::numeric_limits<double>::infinity(), true, unit}; }
inline Bounds notNegative(const char* unit) { return {0, std::numeric_limits<double>::infinity(), false, unit}; }
inline Bounds between(double min, double max, const char* unit = "") { return {min, max, false, unit}; }
inline Bounds anyNumber(const char* unit) {
    return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), false, unit};
}

/// A place or a length that floating point still resolves to micrometres.
inline Bounds withinReach(const char* unit) { return {-1e9, 1e9, false, unit}; }

/// Typed access to one table. The constructor refuses keys that it does not know; every getter refuses a wrong type, a
/// value that is not finite and one out of bounds, each with the key's place, the value, the limit and what would do.
class TableReader {
public:
    /// @param title      of the table in messages: "[domain]", "[[light]]"
    /// @param known      all keys of the schema
    /// @param not_built  keys of the schema that are refused by name
    TableReader(const ConfigValue& table, std::string title, std::vector<std::string> known,
                const std::vector<std::string>& not_built = {});

    const std::string& where() const { return table_.where; }
    /// Place of a key, or of the table when absent.
    const std::string& where(const std::string& key) const;
    bool has(const std::string& key) const { return find(key) != nullptr; }
    const ConfigValue* find(const std::string& key) const { return table_.find(key); }

    std::optional<double> number(const std::string& key, const Bounds& bounds) const;
    std::optional<std::int64_t> integer(const std::string& key, std::int64_t min, std::int64_t max) const;
    std::optional<bool> flag(const std::string& key) const;
    std::optional<std::string> text(const std::string& key) const;
    /// Index of a string among `choices`; names in `not_built` are refused as such.
    std::optional<std::size_t> choice(const std::string& key, const std::vector<std::string>& choices,
                                      const std::vector<std::string>& not_built = {}) const;
    std::optional<std::vector<std::string>> texts(const std::string& key) const;
    std::optional<glm::dvec2> vector2(const std::string& key, const Bounds& bounds) const;
    std::optional<glm::dvec3> vector3(const std::string& key, const Bounds& bounds) const;
    /// A number for all three channels, or [r, g, b].
    std::optional<glm::dvec3> colour(const std::string& key, const Bounds& bounds) const;
    /// A unit vector from [x, y] of any length but 0, or from an angle in degrees from +x towards +y.
    std::optional<glm::dvec2> heading(const std::string& key) const;

    [[noreturn]] void fail(const std::string& message) const { failAt(table_.where, message); }
    [[noreturn]] void fail(const std::string& key, const std::string& message) const { failAt(where(key), message); }
    [[noreturn]] void missing(const std::string& key, const std::string& example) const;
    /// Refuses two keys that say different things about one matter.
    void exclusive(const std::vector<std::string>& keys) const;

    const std::string& title() const { return title_; }

private:
    [[noreturn]] void failAt(const std::string& where, const std::string& message) const;
    void refuseControl(const std::string& key, const ConfigValue& value) const;
    double checkedNumber(const ConfigValue& value, const std::string& key, const Bounds& bounds) const;
    void numbers(const ConfigValue& value, const std::string& key, const Bounds& bounds, std::size_t count,
                 double* out) const;

    const ConfigValue& table_;
    std::string title_;
};

}  // namespace photic
