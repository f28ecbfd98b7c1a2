// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "bake/field/grid_frame.h"
#include "bake/report/bake_report.h"
#include "bake/scene/scene.h"

namespace photic::cli {

/// Keys keep the order in which they are written.
using Json = nlohmann::ordered_json;

Json toJson(const glm::dvec3& v);
Json toJson(const glm::ivec3& v);
Json toJson(const PowerLedger& ledger);
Json toJson(const PathLedger& ledger);
Json toJson(const OptionValue& value);
/// Size, bounds and transform of a grid.
Json toJson(const GridFrame& frame);
/// All of a bake's report (docs/schemas/report.md), without the scene's part.
Json toJson(const BakeReport& report);

/// Both ledgers as the `ledger` metadata holds them.
Json ledgerJson(const BakeReport& report);
/// The ledgers of a `ledger` metadata; throws Error{Input} when it is not one.
void readLedger(const std::string& text, PowerLedger& power, PathLedger& path);

/// Text of a document: names that are not UTF-8 are made so, numbers that are not finite become null.
std::string dump(const Json& json, int indent = -1);
/// Prints a document on stdout.
void print(const Json& json);

}  // namespace photic::cli
