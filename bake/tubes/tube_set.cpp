// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/tube_set.h"

#include <map>
#include <utility>

#include "bake/report/error.h"

namespace photic {

std::shared_ptr<const BlockTopology> BlockTopology::fromTriangles(int vertices, std::vector<Triangle> triangles) {
    if (vertices > kNone || triangles.size() > kNone)
        throw Error(ErrorCode::Failed, "a tube block holds at most 255 corners and 255 tubes");
    auto topology = std::make_shared<BlockTopology>();
    topology->vertex_count = vertices;
    std::map<std::pair<std::uint8_t, std::uint8_t>, std::size_t> open;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        for (int e = 0; e < 3; ++e) {
            const std::uint8_t a = triangles[t].corner[e], b = triangles[t].corner[(e + 1) % 3];
            const auto twin = open.find({b, a});
            if (twin != open.end()) {
                topology->edges[twin->second].right = static_cast<std::uint8_t>(t);
                open.erase(twin);
            } else {
                open[{a, b}] = topology->edges.size();
                topology->edges.push_back({a, b, static_cast<std::uint8_t>(t), kNone});
            }
        }
    }
    topology->triangles = std::move(triangles);
    return topology;
}

void TubeSet::append(const TubeSet& other) {
    const auto corner_offset = static_cast<std::uint32_t>(corners.size()),
               tube_offset = static_cast<std::uint32_t>(tubes.size());
    for (TubeBlock block : other.blocks) {
        block.first_corner += corner_offset, block.first_tube += tube_offset;
        blocks.push_back(std::move(block));
    }
    corners.insert(corners.end(), other.corners.begin(), other.corners.end());
    tubes.insert(tubes.end(), other.tubes.begin(), other.tubes.end());
    slope_u_power += other.slope_u_power, slope_v_power += other.slope_v_power;
    slope2_power += other.slope2_power, slope_power += other.slope_power;
}

}  // namespace photic
