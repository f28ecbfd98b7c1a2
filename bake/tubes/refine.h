// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>

#include "bake/paths/path_tracer.h"
#include "bake/report/monitor.h"
#include "bake/tubes/edge_table.h"
#include "bake/tubes/obstacles.h"
#include "bake/tubes/tube_builder.h"

namespace photic {

struct RefineOptions {
    /// Split where the landing points depart from a linear map: their second difference along a tube's edge, in voxels,
    /// where the tube ends. 0: never for curvature.
    double tolerance = 0.25;
    double max_edge = 0;        ///< [voxels] split longer edges, measured at the surface; 0: any length
    double silhouette = 0.125;  ///< [voxels] tubes that straddle a shadow's edge are split to this size
    /// What the widths above and below at which tubes are left whole are multiplied with, and what such a tube carries
    /// by its square: less than 1 for bodies that are few voxels across (bodyFineness), whose own edges part the light.
    double fineness = 1;
    int max_depth = 24;  ///< halvings of one edge
    /// Share of the emitted power that counts as full light. What a share's root is below it, tubes may be coarser by:
    /// most tubes go where they lessen the error most.
    double full_share = 1;
    /// How much less than usual a tube must carry to be too faint to be divided: a finer tolerance than the default
    /// asks for faint light too.
    double faint = 1;
    const Monitor* monitor = nullptr;  ///< asked now and then whether to stop; null: nobody is
};

/// RefineOptions::fineness for the bodies that a history meets: voxels of an eighth of the smallest one's width,
/// where those are finer than the grid's. A body's width is the middle one of its box's three sides. No finer than a
/// 512th of its length nor than an eighth of a voxel: sums over edges are in single precision, and the narrower a tube,
/// the more of its light is rounding.
double bodyFineness(const OpticalScene& optics, const History& history);

/// Optical thickness by which the edges of a tube may differ, per voxel of tolerance: light that is up to that much too
/// bright on one side and too faint on the other.
inline constexpr double kFading = 0.1;

/// How well two neighbouring paths, and what is between them, are told by a tube. The questions that refinement asks;
/// each depends on the paths that it is given and on nothing else.
class PathComparison {
public:
    /// @param tracer  must outlive the object
    explicit PathComparison(const PathTracer& tracer)
        : frame_(tracer.optics().frame()),
          optics_(tracer.optics()),
          emission_(tracer.emission()),
          ends_matter_(!tracer.optics().caster().planesOnly()) {}

    /// Whether two paths can share a tube as they are: same outcome, same end, same main axis.
    bool canShareTube(const Path& a, const Path& b) const;
    /// Whether all that keeps three paths from sharing a tube are the specular surfaces that they go on to.
    bool differByTheNextSurface(const Path& a, const Path& b, const Path& m) const;
    /// Second difference [voxels] of the landing points of three paths evenly spaced on the surface, where the middle
    /// one ends; 0 where they have no common landing.
    double bend(const Path& a, const Path& middle, const Path& b) const;
    /// Whether two paths that share a tube land more than a voxel apart.
    bool fansOut(const Path& a, const Path& b) const;
    /// Whether both lie on a ball's very rim: light there goes straight on, but their chord cuts off part of the ball.
    bool cutsOffRim(const Path& a, const Path& b) const;
    /// Whether their ends inside the grid or their starts are more than a layer apart.
    bool standApart(const Path& a, const Path& b) const { return endsApart(a, b) || startsApart(a, b); }
    /// Their ends: as on a slope or a wall.
    bool endsApart(const Path& a, const Path& b) const;
    /// Their starts: as of light that leaves level water at a low angle.
    bool startsApart(const Path& a, const Path& b) const;
    /// How much more of its light one path has left than the other where a medium has taken a good part of it, or
    /// where the first of them ends: in optical thicknesses. Inside of a tube light is the same across its way.
    double fadesApart(const Path& a, const Path& b) const;
    /// How much more of its light arrives at the next surface half-way between two paths than half-way between what of
    /// theirs does, where a medium takes some of it: a share of the light.
    double arrivesUnevenly(const Path& a, const Path& middle, const Path& b) const;
    /// By how much what goes on along the last leg half-way between two paths differs from the mean of theirs: a share
    /// of the light.
    double goesOnUnevenly(const Path& a, const Path& middle, const Path& b) const;
    /// A step in depth inside one object is a silhouette too. @param fineness  RefineOptions::fineness
    bool stepsInDepth(const Path& a, const Path& middle, const Path& b, double fineness) const;
    /// Distance between where the last legs start [voxels]; where one is lost on its way, between their entries.
    double width(const Path& a, const Path& b) const;
    /// Distance between where they meet the first surface [voxels].
    double entryWidth(const Path& a, const Path& b) const;
    /// The same in the parameters of the launch: of a height field the width of the water beneath, without its height.
    double launchWidth(const Path& a, const Path& b) const;
    /// Whether both last legs, and what is as far beside them as they are apart, stay outside of the grid.
    bool missesGrid(const Path& a, const Path& b) const;
    /// The larger share of the emitted power that either brings to its last leg; 1 before the first surface.
    double share(const Path& a, const Path& b) const;
    /// About what a tube of this edge carries, as a share of the unfocused light on a voxel's face.
    double carries(const Path& a, const Path& b) const;

private:
    bool sameWay(const Path& a, const Path& b) const;
    glm::dvec3 landing(const Path& path) const;

    const GridFrame& frame_;
    const OpticalScene& optics_;
    const Emission& emission_;
    bool ends_matter_;
};

/// Splits triangles of paths until each is a good tube, and hands them to a TubeBuilder.
/// Whether an edge is split depends on that edge alone, so neighbours agree: there are no gaps and no overlaps.
class Refiner {
public:
    /// @param tracer, obstacles, builder  must outlive the refiner
    Refiner(const PathTracer& tracer, const Obstacles& obstacles, TubeBuilder& builder, const RefineOptions& options)
        : tracer_(tracer), obstacles_(obstacles), builder_(builder), options_(options), compare_(tracer) {}

    /// @param face  geometric normal of the mesh triangle; unused for height fields
    void add(const Path& a, const Path& b, const Path& c, const glm::dvec3& face) { add(a, b, c, face, 0); }

    /// Tells the bend of an edge before add() comes to it, from what its neighbours on a lattice show; its middle is
    /// traced only to split it.
    void knowBend(const Path& a, const Path& b, const glm::dvec3& face, double bend);

    std::int64_t traced() const { return traced_; }

private:
    using Edge = EdgeTable::Edge;

    // Both return what TubeBuilder::add does of all the tubes that they laid.
    int add(const Path& a, const Path& b, const Path& c, const glm::dvec3& face, int depth);
    int divide(const Path* const* corners, const Edge* const* edges, const glm::dvec3& face, int depth);
    int divided(const Path* const* corners, const Edge* const* edges, const glm::dvec3& face, int depth);
    bool joinable(const Path* const* corners, std::size_t first, int met) const;
    const Edge& edgeBetween(const Path& a, const Path& b, const glm::dvec3& face);
    double leastPower() const;
    double silhouette() const { return options_.silhouette * options_.fineness; }
    bool isFineEnough(const Path& a, const Path& b, double width) const;
    bool mustSplit(const Path& a, const Path& b, const Path& m, double width) const;
    bool bendsTooMuch(const Path& a, const Path& b, const Path& m) const;
    bool fadesTooMuch(const Path& a, const Path& b, double width) const;
    bool arrivesTooUnevenly(const Path& a, const Path& b, const Path& m) const;
    bool goesOnTooUnevenly(const Path& a, const Path& b, const Path& m) const;
    bool standsBetween(const Path& a, const Path& b, double width) const;
    void traceMiddle(Edge& edge, const EmissionParam& param, const glm::dvec3& face);

    const PathTracer& tracer_;
    const Obstacles& obstacles_;
    TubeBuilder& builder_;
    RefineOptions options_;
    PathComparison compare_;
    LentEdgeTable edges_;
    std::int64_t traced_ = 0;
};

}  // namespace photic
