// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/json.h"

#include <cstdio>

namespace photic::cli {

Json toJson(const glm::dvec3& v) { return Json::array({v.x, v.y, v.z}); }
Json toJson(const glm::ivec3& v) { return Json::array({v.x, v.y, v.z}); }

Json toJson(const GridFrame& frame) {
    Json rows = Json::array();
    for (int row = 0; row < 3; ++row) {
        rows.push_back(
            {frame.worldFromIndex()[0][row], frame.worldFromIndex()[1][row], frame.worldFromIndex()[2][row]});
    }
    return {{"size", toJson(frame.size())},         {"index_min", toJson(frame.min)},
            {"index_max", toJson(frame.max)},       {"world_from_index", rows},
            {"origin", toJson(frame.origin_world)}, {"voxel_volume", frame.voxelVolume()},
            {"sheared", !frame.axisAligned()}};
}

void print(const Json& json) {
    // A failure is found by main, which checks stdout at the end.
    std::fputs((dump(json, 2) + "\n").c_str(), stdout);
}

}  // namespace photic::cli
