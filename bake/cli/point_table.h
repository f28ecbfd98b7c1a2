// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace photic::cli {

/// A point to sample the light at.
struct SamplePoint {
    glm::dvec3 position{0};            ///< [m], world
    std::optional<glm::dvec3> normal;  ///< unit, out of the face that is lit
    std::vector<std::string> carried;  ///< what else its row holds, as it stands
};

/// The points of one table, all with a normal or none.
struct PointTable {
    std::vector<SamplePoint> points;
    bool normals = false;
    std::vector<std::string> carried_names;  ///< of the columns that SamplePoint::carried holds
};

/// Reads points from text: x, y, z in metres and, where wanted, a normal of any length nx, ny, nz; a row each, parted
/// by commas, semicolons, tabs or blanks. A first row of names may give the columns another order; those it names
/// otherwise are carried along. Empty lines and those that begin with # are passed over.
/// @param source  the table's name, for messages
/// @throws Error{Input} with the line of what is no such row; for a table without points
PointTable parsePoints(std::string_view text, const std::string& source);

}  // namespace photic::cli
