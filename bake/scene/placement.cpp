// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/placement.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <utility>

namespace photic {
namespace {

/// About one axis, exact for quarter turns.
glm::dmat3 turnAbout(int axis, double degrees) {
    double s = std::sin(degrees * std::numbers::pi / 180), c = std::cos(degrees * std::numbers::pi / 180);
    if (std::fmod(degrees, 90.0) == 0) s = std::round(s), c = std::round(c);
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    glm::dmat3 m(1);
    m[a][a] = c, m[b][b] = c, m[a][b] = s, m[b][a] = -s;
    return m;
}

}  // namespace

const std::vector<std::string>& placementKeys() {
    static const std::vector<std::string> keys{"position", "rotation", "scale"};
    return keys;
}

Placement loadPlacement(const TableReader& table) {
    Placement placement;
    placement.position = table.vector3("position", anyNumber("m")).value_or(glm::dvec3(0));
    if (const auto degrees = table.vector3("rotation", between(-36000, 36000, "degrees")))
        placement.rotation = turnAbout(2, degrees->z) * turnAbout(1, degrees->y) * turnAbout(0, degrees->x);
    placement.scale = table.colour("scale", between(-1e9, 1e9)).value_or(glm::dvec3(1));
    for (int a = 0; a < 3; ++a)
        if (placement.scale[a] == 0)
            table.fail("scale", fmt::format("'scale' is 0 along {}, which leaves nothing; give a number that is not 0",
                                            "xyz"[a]));
    return placement;
}

void place(TriangleMesh& mesh, const Placement& placement) {
    if (!placement.moves()) return;
    glm::dmat3 world_from_shape = placement.rotation;
    for (int a = 0; a < 3; ++a) world_from_shape[a] *= placement.scale[a];
    // Normals are covectors, which a mirror leaves on their side; it turns the winding, which is turned back.
    const bool mirrored = glm::determinant(world_from_shape) < 0;
    const glm::dmat3 world_from_normal = glm::transpose(glm::inverse(world_from_shape));
    for (glm::dvec3& p : mesh.positions) p = placement.position + world_from_shape * p;
    for (glm::dvec3& n : mesh.normals) n = glm::normalize(world_from_normal * n);
    for (auto& corners : mesh.corner_normals)
        for (glm::dvec3& n : corners) n = glm::normalize(world_from_normal * n);
    if (mirrored)
        for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
}

}  // namespace photic
