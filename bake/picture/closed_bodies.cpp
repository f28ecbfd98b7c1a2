// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/closed_bodies.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <variant>

#include "bake/paths/ray_casting.h"
#include "bake/scene/mesh_shape.h"

namespace photic {

namespace {

/// The mesh with a vertex a place: of a box each face has its own, and no edge would belong to two.
TriangleMesh welded(const TriangleMesh& mesh) {
    TriangleMesh one;
    std::map<std::array<double, 3>, std::uint32_t> at;
    for (const auto& triangle : mesh.triangles) {
        auto& corners = one.triangles.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::dvec3& p = mesh.positions[triangle[k]];
            const auto [place, is_new] =
                at.try_emplace({p.x, p.y, p.z}, static_cast<std::uint32_t>(one.positions.size()));
            if (is_new) one.positions.push_back(p);
            corners[k] = place->second;
        }
    }
    return one;
}

}  // namespace

struct ClosedBodies::Body {
    Object object;
    const TriangleMesh& mesh;
    glm::dvec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
    mutable std::once_flag looked_into;
    mutable std::optional<RayCaster> caster;  ///< none when it is open

    Body(const Object& of, const TriangleMesh& of_mesh) : object(of), mesh(of_mesh) {
        for (const glm::dvec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
    }
    void lookInto() const {
        if (!shapeOf(welded(mesh)).closed()) return;
        Scene alone;
        alone.objects = {object};
        caster.emplace(alone);
    }
    bool holds(const glm::dvec3& point) const {
        if (!glm::all(glm::greaterThan(point, low)) || !glm::all(glm::lessThan(point, high))) return false;
        std::call_once(looked_into, [&] { lookInto(); });
        // Any way will do but along edges and faces, which run along the axes and their diagonals most often.
        static const glm::dvec3 way = glm::normalize(glm::dvec3(0.2377, 0.4129, 0.8791));
        return caster && caster->insideBody(point, way);
    }
};

ClosedBodies::ClosedBodies(const Scene& scene) {
    for (const Object& object : scene.objects) {
        const auto* mesh = std::get_if<std::shared_ptr<const TriangleMesh>>(&object.shape);
        if (mesh && object.blocks()) bodies_.push_back(std::make_unique<Body>(object, **mesh));
    }
}

ClosedBodies::~ClosedBodies() = default;

bool ClosedBodies::hold(const glm::dvec3& point) const {
    return std::any_of(bodies_.begin(), bodies_.end(), [&](const auto& body) { return body->holds(point); });
}

}  // namespace photic
