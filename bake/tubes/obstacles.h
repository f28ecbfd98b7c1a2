// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "bake/paths/path_tracer.h"
#include "bake/paths/row_trace.h"

namespace photic {

/// What stands between paths, and not only where they go.
///
/// Three paths that agree say nothing of a pole between them. So the space between two neighbouring paths, as wide to
/// either side as they are apart, is held against the triangles of the scene: on the way to the first surface, and
/// along the last leg. The answer depends on the two paths alone, so that both tubes that share an edge divide it
/// alike; the spaces of a triangle's three edges cover it as long as no angle is above 126 degrees.
///
/// What stands beyond the grid counts where it sends light on, which may come back: mirrors and glass.
///
/// Legs are looked at up to a voxel before their ends: what lies there is the receiver itself. A receiver that is made
/// of many triangles must also cover the space, or light falls through a gap between the paths.
class Obstacles {
public:
    /// @param tracer  whose history the paths have; must outlive the object
    explicit Obstacles(const PathTracer& tracer);

    bool none() const { return optics_.tree().empty(); }

    /// Whether something between two paths that agree may end part of the light between them elsewhere than they end.
    /// @param width     of the edge between them [voxels]
    /// @param searches  counts how often the space between them was searched, where bodies are near it
    bool between(const Path& a, const Path& b, double width, std::int64_t& searches) const;

    /// What a block of a regular lattice has before it.
    enum class Way {
        Free,     ///< nothing but planes
        Covered,  ///< everything ends on one object, whose ends `row` now holds
        Unclear   ///< each edge must be looked at
    };
    /// The block's neighbours are looked at too, a cell wide, as far as the lattice goes: an edge on the rim reads the
    /// same from both sides.
    /// @param row  rows + 3 traced rows from -1 on, of which corners [first - 1, first + columns + 1] are used; ends
    /// and
    ///             hit distances of the block's own are set where an object ends them
    Way ofBlock(RayRow* row, int first, int columns, int rows) const;

private:
    struct Leg {
        glm::dvec3 start, end;
    };
    ConvexRegion spaceAround(const std::vector<Leg>& legs) const;
    /// Kites around both ends of an edge, four corners each.
    struct Kites {
        std::array<glm::dvec3, 8> points;
        glm::dvec3 along{0, 0, 1}, widest{0}, widest_across{0};
    };
    /// @param narrowed  of the kites' width
    Kites kitesOf(const Leg& a, const Leg& b, double narrowed = 1) const;
    ConvexRegion spaceBetween(const Kites& kites) const;
    ConvexRegion spaceBetween(const Leg& a, const Leg& b) const { return spaceBetween(kitesOf(a, b)); }
    bool isNear(const ConvexRegion& space) const;
    bool standsBehind(const Path& a, const Path& b, std::int64_t& searches) const;
    bool standsIn(const ConvexRegion& space, const PathEvent& event, double width, std::int64_t& searches) const;
    bool isLitBetween(const Leg& to_a, const Leg& to_b, double width) const;
    bool covered(const Leg& a, const Leg& b, double before, double behind) const;
    Leg lastLeg(const Path& path, double shortened_voxels) const;
    bool standsBeyond(const Path& a, const Path& b, double width, std::int64_t& searches) const;
    Leg legBeyond(const glm::dvec3& position, const glm::dvec3& direction, double exit, double hit) const;
    Leg legFromLight(const glm::dvec3& entry) const;
    bool endOnOneObject(RayRow* row, int first, int columns, int rows, const std::vector<Leg>& around) const;

    bool isFlatAndBare(const std::vector<glm::dvec3>& points, int columns, int rows, const glm::dvec3& d,
                       const std::vector<Leg>& around) const;

    const OpticalScene& optics_;
    const PathTracer& tracer_;
    bool enters_on_mesh_, leaves_mesh_, first_is_closed_;
    glm::dvec3 bodies_low_{1}, bodies_high_{0};  // of all specular bodies [m]; low > high without any
};

}  // namespace photic
