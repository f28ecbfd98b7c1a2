// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <unordered_map>

#include "bake/tubes/corner.h"
#include "bake/tubes/tube_builder.h"

namespace photic {

struct RefineOptions {
    /// Split where the landing points depart from a linear map: their second difference along a tube's edge, in voxels,
    /// where the tube ends. 0: never for curvature.
    double tolerance = 0.25;
    double max_edge = 0;        ///< [voxels] split longer edges, measured at the surface; 0: any length
    double silhouette = 0.125;  ///< [voxels] tubes that straddle a shadow's edge are split to this size
    int max_depth = 10;         ///< halvings of one edge
    bool ends_matter = true;    ///< false where only planes end tubes: a tube over their corner needs no split
};

/// Splits triangles of corner rays until each is a good tube, and hands them to a TubeBuilder.
/// Whether an edge is split depends on that edge alone, so neighbours agree: there are no gaps and no overlaps.
class Refiner {
public:
    Refiner(const CornerTracer& tracer, TubeBuilder& builder, const RefineOptions& options)
        : tracer_(tracer), builder_(builder), options_(options) {}

    /// @param face  geometric normal of the mesh triangle; unused for height fields
    void add(const Corner& a, const Corner& b, const Corner& c, const glm::dvec3& face) { add(a, b, c, face, 0); }

    /// Whether two corners can share a tube as they are: same fate, same end, same main axis.
    bool alike(const Corner& a, const Corner& b) const;

    /// Decides an edge before add() comes to it, by what its neighbours on a lattice show; its middle is traced only to
    /// split it.
    void decide(const Corner& a, const Corner& b, const glm::dvec3& face, bool split);

    /// Second difference [voxels] of the landing points of three rays evenly spaced on the surface, where the middle
    /// one ends; 0 where they have no common landing.
    double bend(const Corner& a, const Corner& middle, const Corner& b) const;

    std::int64_t traced() const { return traced_; }

private:
    struct Middle {
        Corner corner;
        bool split = false;
    };
    struct ParamHash {
        std::size_t operator()(const SurfaceParam& p) const;
    };
    struct ParamEqual {
        bool operator()(const SurfaceParam& p, const SurfaceParam& q) const {
            return p.position == q.position && p.normal == q.normal;
        }
    };

    void add(const Corner& a, const Corner& b, const Corner& c, const glm::dvec3& face, int depth);
    const Middle& middleOf(const Corner& a, const Corner& b, const glm::dvec3& face);
    bool mustSplit(const Corner& a, const Corner& b, const Corner& m) const;
    bool stepsInDepth(const Corner& a, const Corner& b, const Corner& m) const;

    const CornerTracer& tracer_;
    TubeBuilder& builder_;
    RefineOptions options_;
    std::unordered_map<SurfaceParam, Middle, ParamHash, ParamEqual> middles_;
    std::int64_t traced_ = 0;
};

}  // namespace photic
