// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/gltf_json.h"

#include <fmt/format.h>

#include <string_view>

namespace photic::gltf {

const Json& memberOf(const Json& object, const char* key) {
    static const Json kNone;
    if (!object.is_object()) return kNone;
    const auto found = object.find(key);
    return found == object.end() ? kNone : *found;
}

double numberOf(const Json& object, const char* key, double otherwise) {
    const Json& value = memberOf(object, key);
    return value.is_number() ? value.get<double>() : otherwise;
}

std::string textOf(const Json& object, const char* key) {
    const Json& value = memberOf(object, key);
    return value.is_string() ? value.get<std::string>() : std::string();
}

glm::dvec3 vectorOf(const Json& value, const glm::dvec3& otherwise) {
    if (!value.is_array() || value.size() < 3) return otherwise;
    return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
}

const Json& extensionOf(const Json& object, const char* name) { return memberOf(memberOf(object, "extensions"), name); }

Json ownExtras(const Json& object) {
    Json out = Json::object();
    const Json& extras = memberOf(object, "extras");
    if (!extras.is_object()) return out;
    if (const Json& table = memberOf(extras, "photic"); table.is_object()) out = table;
    constexpr std::string_view kPrefix = "photic_";
    for (const auto& [key, value] : extras.items())
        if (key.substr(0, kPrefix.size()) == kPrefix) out[key.substr(kPrefix.size())] = value;
    return out;
}

std::string quoted(const std::string& text) {
    return Json(text).dump(-1, ' ', true, Json::error_handler_t::replace);  // JSON's escapes are TOML's
}

std::string number(double v) { return fmt::format("{:.9g}", v); }

std::string vectorText(const glm::dvec3& v) {
    return fmt::format("[{}, {}, {}]", number(v.x), number(v.y), number(v.z));
}

}  // namespace photic::gltf
