// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>

#include "bake/baker/report_json.h"
#include "bake/field/grid_frame.h"

namespace photic::cli {

/// Keys keep the order in which they are written.
using Json = nlohmann::ordered_json;

using photic::dump;
using photic::toJson;

Json toJson(const glm::dvec3& v);
Json toJson(const glm::ivec3& v);
/// Size, bounds and transform of a grid.
Json toJson(const GridFrame& frame);

/// Prints a document on stdout.
void print(const Json& json);

}  // namespace photic::cli
