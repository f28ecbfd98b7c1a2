// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "bake/methods/eikonal.h"
#include "tests/methods/photon_scenes.h"

namespace photic::test {

inline GivenOptions options(const std::vector<std::pair<std::string, OptionValue>>& given) {
    GivenOptions all;
    for (const auto& [name, value] : given) all[name] = {value, "test"};
    return all;
}
inline const GivenOptions kMarching = options({{"solver", std::string("marching")}});

/// All grids of a box of cubes of side h.
inline BakeResult bakeEikonal(Scene scene, const glm::dvec3& low, const glm::ivec3& size, double h,
                              const GivenOptions& given = {}) {
    scene.bake.grids = {true, true, true, true, false};
    Monitor monitor;
    const GridFrame frame = test_scenes::boxFrame(low, size, glm::dvec3(h));
    return eikonalMethod().bake(scene, std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame)), given,
                                monitor);
}

/// Calls body(voxel) for all voxels with light.
template <class Body>
void forLit(const BakeResult& result, const Body& body) {
    const GridFrame& f = result.field.frame();
    for (int x = f.min.x; x <= f.max.x; ++x)
        for (int y = f.min.y; y <= f.max.y; ++y)
            for (int z = f.min.z; z <= f.max.z; ++z)
                if (result.field.value({x, y, z}, 0) > 0) body(glm::ivec3(x, y, z));
}

}  // namespace photic::test
