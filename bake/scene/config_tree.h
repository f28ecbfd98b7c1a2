// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace photic {

struct ConfigEntry;

/// A value of a TOML file with its place. Keeps the loader's tables apart from the parser.
struct ConfigValue {
    enum class Kind { Boolean, Integer, Number, String, Array, Table, Date };
    Kind kind = Kind::Table;
    std::string where;  ///< "pool.toml:12:5"; of a table's entry: of its key
    bool boolean = false;
    std::int64_t integer = 0;
    double number = 0;  ///< of integers too
    std::string string;
    std::vector<ConfigValue> items;    ///< of an array
    std::vector<ConfigEntry> entries;  ///< of a table, in the file's order

    /// The entry `key` of a table, or null.
    const ConfigValue* find(const std::string& key) const;
    /// "a string", "an array" ...
    const char* kindName() const;
};

struct ConfigEntry {
    std::string key;
    ConfigValue value;
};

/// Parses TOML 1.0.
/// @param name  of the file, for `where`
/// @throws Error{Input} with the place of a syntax error
ConfigValue parseConfig(const std::string& text, const std::string& name);

}  // namespace photic
