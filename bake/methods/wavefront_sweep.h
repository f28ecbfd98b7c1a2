// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "bake/deposit/deposit_work.h"
#include "bake/deposit/first_arrival.h"
#include "bake/deposit/strongest_arrival.h"
#include "bake/deposit/voxelise.h"
#include "bake/field/light_field.h"
#include "bake/graded/front_integrators.h"
#include "bake/graded/index_slices.h"
#include "bake/paths/path.h"
#include "bake/report/bake_report.h"
#include "bake/report/monitor.h"

namespace photic {

/// Rays that go along one axis of the grid, and the tubes between them.
struct Front {
    static constexpr std::uint32_t kNoSource = 0xffffffff;
    struct Ray {
        glm::dvec3 voxel{0};     ///< where it starts, in index space
        glm::dvec3 momentum{0};  ///< along the ray, as long as n; world
        bool lit = false;        ///< it has been in a medium
        double time = 0;         ///< optical path so far [m]
        bool shadowed = false;   ///< an object stands between it and its light
        int surface = -1;        ///< that it starts on, in Scene::surfaces
        /// Which ray of the launched front it continues, if any that was not met by a surface; findLost sets it.
        std::uint32_t source = kNoSource;
    };
    struct Tube {
        std::uint32_t ray[3] = {0, 0, 0};
        glm::dvec3 power{0};        ///< at the start, per channel [W]
        std::uint32_t source = 0;   ///< which tube of the launched front it comes from; findLost sets it
        glm::ivec2 cell{0};         ///< of the launched front's, that it comes from
        double least = 0;           ///< [W, mean of the channels] below which no surface sends it on
        int turns = 0, events = 0;  ///< so far: of the axis, and at surfaces
        bool parted = false;        ///< its rays went apart, and it goes where most of them did
    };
    int axis = 2, sense = -1;
    MediumStack inside{};  ///< of all its rays
    /// Of a lattice whose rays are the first ones, row by row, cells.x + 1 a row; none: they lie anyhow.
    glm::ivec2 cells{0};
    std::vector<Ray> rays;
    void append(const Front& other);
    std::vector<Tube> tubes;  ///< neighbours near each other: each 128 are handled together
};

class FrontObstacles;
struct FrontBends;
class GradedSpace;

/// How far light is followed.
struct FrontLimits {
    int turns = 12;           ///< of the axis along which a tube is followed
    int events = 12;          ///< at surfaces
    double threshold = 1e-4;  ///< share of a tube's power below which no surface sends it on
};

/// What a front goes through.
struct FrontSpace {
    const SplineIndex* index = nullptr;    ///< null: the same everywhere
    double even = 0.5;                     ///< n^2 / 2 where it is
    glm::ivec3 first_node{0};              ///< voxel of the index's first node
    glm::ivec3 low{0}, high{0};            ///< voxels of the box that fronts cross, inclusive; it holds the grid
    std::vector<std::uint8_t> media{};     ///< per node: what attenuates, 0 nothing; empty: nothing does
    FrontMedia table{};                    ///< extinction of each
    std::vector<glm::dvec3> absorption{};  ///< [1/m] of each, which its extinction holds too; the first is 0
    glm::dvec3 absorbed_share{1};          ///< of all that is attenuated, per channel; the rest is scattered
    float least_lit = 1e-3f;               ///< difference of n^2 / 2 from the air's that counts as being in a medium
    int steps = 1;                         ///< a layer, at least
    FrontIntegrator integrator = FrontIntegrator::Planes;
    const FrontObstacles* obstacles = nullptr;  ///< what ends light; null: nothing stands in the scene
    const GradedSpace* beyond = nullptr;        ///< what lies beyond surfaces; null: there are none
    FrontLimits limits{};

    double halfSquareAt(const glm::dvec3& world) const { return index ? index->at(world).half_square : even; }
};

/// What a sweep takes, for an estimate.
struct SweepWork {
    double ray_steps = 0;
    double nodes = 0;  ///< of the index in planes across the light, one a step
    DepositWork deposit;
};

/// What a sweep counts.
struct SweepTotals {
    PowerLedger power;
    DepositTotals deposit;
    std::int64_t tubes = 0, rays = 0, turned = 0;
    double trace_seconds = 0, deposit_seconds = 0;
    SweepWork* work = nullptr;  ///< counted where somebody asks
};

/// What takes a front's light besides, or instead of, the field that sums it; null: nobody asks.
struct FrontSinks {
    StrongestArrival* strongest = nullptr;  ///< instead of the field
    FirstArrival* first = nullptr;
};

/// Marches a front through the grid, slab by slab, and lays its tubes into the field. Tubes of which a ray turns more
/// than 60 degrees from the axis end at a cross-section, between two layers, and begin another front there.
class FrontSweep {
public:
    /// @param space  that fronts begin in; where there are surfaces they go on in others
    FrontSweep(const FrontSpace& space, LightField& field, const VoxeliseOptions& options, SweepTotals& totals,
               Monitor& monitor, const FrontSinks& sinks = {})
        : start_(space),
          space_(&space),
          field_(field),
          options_(options),
          totals_(totals),
          monitor_(monitor),
          sinks_(sinks) {}

    /// @return the fronts that go on where tubes of this one turned away, or met a surface
    std::vector<Front> run(const Front& front);
    /// Follows fronts, and all that go on where they end, to the last.
    /// @param progress  how much of it is done, 0 to 1
    void runAll(std::vector<Front> fronts, const std::function<void(double from, double share)>& progress);

    /// Which tubes of a front would be given up, have rays that end on different things or one in a shadow, or go apart
    /// at a surface; lays nothing. Its counts are those of a bake, so the totals should be none that anybody reads.
    /// @param bends  how much the edges of the front's lattice bend on their way; null: nobody asks
    std::vector<std::uint32_t> findLost(Front front, FrontBends* bends = nullptr);

    /// A look at every fourth of a lattice's rays: whether any turns by 45 degrees from its axis, since where none does
    /// no tube is lost; and how much the lattice's edges bend.
    /// @param to_the_end  bends are measured even where light turns
    bool scout(const Front& front, bool to_the_end, FrontBends& bends);

private:
    struct Chunk;
    struct Packed;
    struct State;
    struct Turned;
    struct Leaving;
    struct RayEnd;
    struct TubeEnd;
    struct WayPoint;
    struct Through;

    /// The voxel that rays and rows count from: single precision holds no map's coordinates.
    glm::ivec3 origin() const { return field_.frame().min; }
    std::vector<Chunk> chunksOf(const Front& front, const std::vector<SlabGroup>& groups) const;
    std::vector<SlabGroup> groupsAlong(int axis) const;
    bool goesStraight(const State& state) const;
    void setOut(const Front& front, State& state) const;
    void pack(const Front& front, const std::vector<TubeEnd>& ends, Packed& packed) const;
    int stepsIn(const Front& front, const Chunk& chunk) const;
    void march(const Front& front, const Chunk& chunk, State& state);
    void follow(const Front& front, const Front::Ray& ray, const WayPoint& from, const WayPoint& to, double lit,
                RayEnd& end) const;
    void findRayEnds(const Front& front, const std::vector<Chunk>& chunks, State& state, std::vector<RayEnd>& ends,
                     std::vector<char>& parted);
    bool standsWithin(const Front& front, const Chunk& chunk, const State& state, const std::vector<RayEnd>& ends,
                      const Front::Tube& tube) const;
    void findEnds(const Front& front, const std::vector<Chunk>& chunks, State& state);
    void findStraightEnds(const Front& front, const State& state, std::vector<RayEnd>& ends,
                          std::vector<char>& parted) const;
    TubeEnd handedOn(const Front& front, const Front::Tube& tube, const std::vector<RayEnd>& rays, const RayEnd& middle,
                     State& state);
    void handOn(const Front& front, const Front::Tube& tube, const std::vector<RayEnd>& rays,
                const std::array<std::uint32_t, 3>& from, State& state);
    void layBranch(const Front& front, const Front::Tube& tube, const Through& through, bool crosses,
                   const glm::dvec3& power, State& state);
    void countEnd(const Front& front, std::size_t tube, const TubeEnd& end);
    void retire(const Front& front, const Chunk& chunk, State& state);
    void turnAway(const Front& front, const Chunk& chunk, State& state);
    void carryOn(int axis, double layers, Front::Ray& ray) const;
    Leaving leave(const Front& front, const Chunk& chunk, const State& state, std::uint32_t ray, int lane) const;
    void passOn(const Front& front, const Chunk& chunk, State& state, const Turned& turned);
    void lay(const Front& front, const Chunk& chunk, State& state);
    void packTurned(const Front& front, const Chunk& chunk, const State& state, Packed& packed) const;
    void finish(const Front& front, const State& state);
    void countLoss(const glm::dvec3& power, const glm::dvec3& left);
    void findLattice(const Front& front, State& state) const;
    void measureBends(const Front& front, const Chunk& chunk, State& state);

    const FrontSpace& start_;
    const FrontSpace* space_;  // of the front that is run
    LightField& field_;
    const VoxeliseOptions& options_;
    SweepTotals& totals_;
    Monitor& monitor_;
    FrontSinks sinks_;
    std::vector<std::uint32_t>* lost_ = nullptr;  ///< while findLost looks
    FrontBends* bends_ = nullptr;                 ///< while somebody measures
};

}  // namespace photic
