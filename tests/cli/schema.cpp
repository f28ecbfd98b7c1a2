// SPDX-License-Identifier: Apache-2.0
#include "tests/cli/schema.h"

#include <fstream>
#include <map>
#include <set>
#include <stdexcept>

namespace photic::test {

namespace {

using nlohmann::json;

/// Path -> type, in the page's words.
using Table = std::map<std::string, std::string>;

Table readTable(const std::string& page, const std::string& heading) {
    std::ifstream file(std::string(PHOTIC_SOURCE_DIR) + "/docs/schemas/" + page);
    if (!file) throw std::runtime_error("no page docs/schemas/" + page);
    Table table;
    bool wanted = heading.empty();
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with("## ")) wanted = heading.empty() || line == "## " + heading;
        if (!wanted || !line.starts_with("| `")) continue;
        const auto path_end = line.find("` | "), type_end = line.find(" | ", path_end + 4);
        table[line.substr(3, path_end - 3)] = line.substr(path_end + 4, type_end - path_end - 4);
    }
    if (table.empty()) throw std::runtime_error("no table in docs/schemas/" + page);
    return table;
}

bool hasType(const json& value, std::string type) {
    if (const auto optional = type.find(" (optional)"); optional != std::string::npos) type.erase(optional);
    if (const auto null = type.find(" or null"); null != std::string::npos) {
        if (value.is_null()) return true;
        type.erase(null);
    }
    if (type == "any") return true;
    if (type == "string") return value.is_string();
    if (type == "number") return value.is_number();
    if (type == "integer") return value.is_number_integer();
    if (type == "boolean") return value.is_boolean();
    if (type == "array") return value.is_array();
    if (type == "object" || type == "any object") return value.is_object();
    throw std::runtime_error("unknown type in a schema: " + type);
}

/// Checks a value at `path` and everything below it.
void walk(const json& value, const std::string& path, const Table& table, std::vector<std::string>& breaches) {
    bool open = false;
    if (!path.empty()) {
        const auto row = table.find(path);
        if (row == table.end()) {
            breaches.push_back(path + " is not documented");
            return;
        }
        if (!hasType(value, row->second))
            breaches.push_back(path + " should be " + row->second + ", is " + value.dump());
        open = row->second.starts_with("any");
    }
    if (open) return;
    if (value.is_array()) {
        for (const json& element : value) walk(element, path + "[]", table, breaches);
    } else if (value.is_object()) {
        const std::string prefix = path.empty() ? "" : path + ".";
        for (const auto& [key, child] : value.items()) walk(child, prefix + key, table, breaches);
        for (const auto& [documented, type] : table) {
            if (!documented.starts_with(prefix) || type.find("(optional)") != std::string::npos) continue;
            const std::string key = documented.substr(prefix.size());
            if (key.find_first_of(".[") == std::string::npos && !value.contains(key))
                breaches.push_back(documented + " is missing");
        }
    }
}

}  // namespace

std::vector<std::string> schemaBreaches(const json& document, const std::string& page, const std::string& heading) {
    std::vector<std::string> breaches;
    walk(document, "", readTable(page, heading), breaches);
    return breaches;
}

}  // namespace photic::test
