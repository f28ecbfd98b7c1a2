// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "bake/paths/convex_region.h"
#include "bake/paths/ray_casting.h"
#include "bake/paths/shadowed_patch.h"
#include "bake/scene/scene.h"

namespace photic {

/// What stands inside a part of space: a hierarchy of boxes over the triangles of everything that a ray can meet.
///
/// Rays tell only of what they meet; whether anything stands between three of them is asked here. Boxes are in single
/// precision about the meshes' centre and rounded outwards, triangles are cut in double. Thread-safe.
/// Memory: 36 bytes a triangle. Build: a sort by Morton code (Lauterbach et al. 2009).
class TriangleTree {
public:
    explicit TriangleTree(const Scene& scene);

    bool empty() const { return nodes_.empty(); }
    /// Bounds of all triangles [m]; low > high without any.
    const glm::dvec3& low() const { return low_; }
    const glm::dvec3& high() const { return high_; }

    /// Whether a part of any triangle lies inside the region; all of them, but those of `ignored`.
    bool reaches(const ConvexRegion& region, Target ignored = {}) const;

    /// Area [m2] of the triangles' parts inside the region as seen along `direction`, on the side that most of it
    /// shows: a closed body counts once.
    double shownArea(const ConvexRegion& region, const glm::dvec3& direction) const;

    /// Shades a patch by all that may stand inside the region, until it is dark.
    /// @param first  what rays to the patch met: shaded first, since that is often all that is needed
    void shade(const ConvexRegion& region, std::span<const RayHit> first, ShadowedPatch& patch) const;

private:
    // Inner: children `first` and `first + 1`. Leaf: triangles [first, first + count).
    struct Node {
        float low[3], high[3];
        std::uint32_t first = 0;
        std::uint32_t count = 0;  // 0: inner
    };
    struct Item {
        std::uint32_t mesh, triangle;
    };
    struct Mesh {
        Target target;
        std::shared_ptr<const TriangleMesh> mesh;
    };

    void build(std::vector<std::uint32_t> codes);
    void fit(std::size_t node);
    std::array<glm::dvec3, 3> corners(const Item& item) const;
    template <class Visit>
    void visit(const ConvexRegion& region, const Visit& visit) const;

    std::vector<Mesh> meshes_;
    std::vector<Item> items_;
    std::vector<Node> nodes_;
    glm::dvec3 low_, high_, centre_{0};
};

}  // namespace photic
