// SPDX-License-Identifier: Apache-2.0
// Small scenes with media whose index varies.
#pragma once

#include <string>
#include <utility>

#include "bake/field/scene_grid.h"
#include "bake/methods/catalogue.h"
#include "bake/scene/load_toml.h"

namespace photic {

struct Bake {
    Scene scene;
    BakeResult result;
    const LightField& field() const { return result.field; }
    const BakeReport& report() const { return result.report; }
    double fluence(const glm::ivec3& voxel) const { return result.field.irradiance(voxel); }
};

inline Scene sceneOf(const std::string& domain, const std::string& light, const std::string& media) {
    Monitor monitor;
    return parseScene("photic = 1\n[domain]\n" + domain + "\n[[light]]\n" + light + "\n" + media, "s.toml", "", 0,
                      monitor);
}

inline Bake bakeWith(const std::string& name, const Scene& scene, const GivenOptions& options = {}) {
    Monitor monitor;
    const Method& method = chooseMethod(name, scene);
    auto needed = std::make_shared<const NeededVoxels>(NeededVoxels::everything(sceneFrame(scene)));
    return {scene, method.bake(scene, needed, options, monitor)};
}
inline Bake bake(const Scene& scene, const GivenOptions& options = {}) { return bakeWith("wavefront", scene, options); }

inline const std::string kDown = "type = \"sun\"\ndirection = [0, 0, -1]\nirradiance = 1\nangular_diameter = 0";

inline std::string medium(const std::string& index, const std::string& more = "") {
    return "[[medium]]\nname = \"lens\"\nindex = " + index + "\n" + more + "\n";
}

inline GivenOptions with(const std::string& key, OptionValue value) { return {{key, {std::move(value), "test"}}}; }

}  // namespace photic
