// SPDX-License-Identifier: Apache-2.0
// Small scenes with media whose index varies.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
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

inline GivenOptions operator|(GivenOptions a, const GivenOptions& b) {
    a.insert(b.begin(), b.end());
    return a;
}

inline GivenOptions paths(std::int64_t count) { return with("count", count); }

/// Relative L1 between two bakes of one grid, neither with noise.
inline double apart(const Bake& a, const Bake& b) {
    const GridFrame& frame = a.field().frame();
    double difference = 0, sum = 0;
    for (int k = frame.min.z; k <= frame.max.z; ++k)
        for (int j = frame.min.y; j <= frame.max.y; ++j)
            for (int i = frame.min.x; i <= frame.max.x; ++i)
                difference += std::fabs(a.fluence({i, j, k}) - b.fluence({i, j, k})), sum += b.fluence({i, j, k});
    return difference / sum;
}

struct Difference {
    double apart = 0, error = 0;  ///< mean absolute difference and mean standard error, of the mean light
    double total = 0;             ///< of the second bake's light over the first one's
};

/// Photons against a bake of the same grid that has no noise.
/// @param lowest  layer that is looked at
inline Difference compare(const Bake& photons, const Bake& smooth, int lowest = -1000000) {
    const GridFrame& frame = photons.field().frame();
    double difference = 0, error = 0, sum = 0, other = 0;
    for (int k = std::max(lowest, frame.min.z); k <= frame.max.z; ++k)
        for (int j = frame.min.y; j <= frame.max.y; ++j)
            for (int i = frame.min.x; i <= frame.max.x; ++i) {
                const glm::ivec3 voxel(i, j, k);
                difference += std::fabs(photons.fluence(voxel) - smooth.fluence(voxel));
                if (photons.result.standard_error) error += double(photons.result.standard_error->value(voxel, 0));
                sum += photons.fluence(voxel), other += smooth.fluence(voxel);
            }
    return {difference / other, error / other, sum / other};
}

}  // namespace photic
