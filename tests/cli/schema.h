// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace photic::test {

/// What is wrong with a document against the table of a page in docs/schemas (below `heading`, if given): documented
/// keys that are missing or of another type, and keys that the table does not have. Empty when all is well.
std::vector<std::string> schemaBreaches(const nlohmann::json& document, const std::string& page,
                                        const std::string& heading = "");

}  // namespace photic::test
