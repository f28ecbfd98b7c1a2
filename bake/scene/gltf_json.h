// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <string>

namespace photic::gltf {

using Json = nlohmann::json;

/// A member, or null where there is none.
const Json& memberOf(const Json& object, const char* key);
/// What a member says, or else `otherwise` (an empty text).
double numberOf(const Json& object, const char* key, double otherwise);
std::string textOf(const Json& object, const char* key);
/// Three numbers of an array.
glm::dvec3 vectorOf(const Json& value, const glm::dvec3& otherwise);
const Json& extensionOf(const Json& object, const char* name);
/// What `extras` say to this program: a table `photic`, and keys that begin with `photic_`.
Json ownExtras(const Json& object);

/// From glTF's axes, Y up, to Z up.
inline glm::dvec3 zUp(const glm::dvec3& v) { return {v.x, -v.z, v.y}; }

/// A text and numbers as a scene file has them.
std::string quoted(const std::string& text);
std::string number(double v);
std::string vectorText(const glm::dvec3& v);

}  // namespace photic::gltf
