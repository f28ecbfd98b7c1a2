// SPDX-License-Identifier: Apache-2.0
#include "bake/file/runtime_metadata.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

using Json = nlohmann::ordered_json;

// Metadata is text; these keys hold numbers, or arrays of them.
void addNumbers(const LightVolume& volume, const char* key, Json& json) {
    const auto at = volume.metadata.find(key);
    if (at == volume.metadata.end()) return;
    const Json value = Json::parse(at->second, nullptr, false);
    const auto isNumber = [](const Json& v) { return v.is_number() && std::isfinite(v.get<double>()); };
    if (isNumber(value) || (value.is_array() && value.size() == 3 && std::all_of(value.begin(), value.end(), isNumber)))
        json[key] = value;
}

void addText(const LightVolume& volume, const char* key, Json& json) {
    if (const auto at = volume.metadata.find(key); at != volume.metadata.end()) json[key] = at->second;
}

}  // namespace

Json runtimeMetadata(const LightVolume& volume) {
    Json json = {{"version", format::kVersion}, {"reference_irradiance", volume.reference_irradiance}};
    for (const char* key : {"ior", "frame"}) addNumbers(volume, key, json);
    json["up_axis"] = "Z";
    for (const char* key : {"method", "paths", "scene_hash", "coarse_blocks"}) addText(volume, key, json);
    for (const char* key : {"scattering", "absorption", "anisotropy", "period", "water_level", "lobe_axis"})
        addNumbers(volume, key, json);
    return json;
}

}  // namespace photic
