// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace photic {

/// Where a light of a scene is to be.
struct MovedLight {
    std::size_t number = 0;                 ///< of its [[light]], from 0
    std::optional<glm::dvec3> position{};   ///< [m]: of a rectangle its centre; a sun has none
    std::optional<glm::dvec3> direction{};  ///< of travel, any length; a point has none
};

/// A scene file's text with lights moved, for a file in another folder: the numbers are replaced where they stand, so
/// that all that messages speak of keeps its line, and relative files become absolute.
///
/// @param name       of the file, for messages
/// @param directory  that its relative files are looked up in
/// @throws Error{Input} for what is no TOML, for a light that is not there or has no such key, or moves by keyframes
std::string withMovedLights(const std::string& text, const std::string& name, const std::string& directory,
                            const std::vector<MovedLight>& moved);

}  // namespace photic
