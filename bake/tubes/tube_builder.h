// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/geometric.hpp>
#include <memory>
#include <tuple>
#include <vector>

#include "bake/paths/emission.h"
#include "bake/paths/optical_scene.h"
#include "bake/paths/path.h"
#include "bake/paths/row_trace.h"
#include "bake/report/bake_report.h"
#include "bake/tubes/tube_set.h"

namespace photic {

/// What a launch does with its light, beside laying it.
struct TubeLaunch {
    int channels = 1;             ///< of power: 1 white, 3 coloured
    bool counts_emission = true;  ///< false for a second history of the same light: what is emitted is counted once
    bool counts_event = true;     ///< false for a second branch of the same event: what it leaves out is counted once
    bool counts_dropped = true;  ///< what an event turns the wrong way: by the last of its branches, whose rays show it
    bool follows_on = false;     ///< light that meets a specular surface is handed on to longer histories
    bool faceted = false;        ///< TubeBlock::faceted
    double share = 1;            ///< TubeBlock::share
    glm::dvec3 lobe_axis{0};     ///< tubes that travel against it belong to the second lobe; 0: all to the first
};

/// Paths that meet a specular surface at the end of a tube: the domain of the histories that continue them.
struct TubeSeed {
    EmissionParam corner[3];
    glm::dvec3 face{0};  ///< geometric normal of the mesh triangle that they enter through
    int surface = -1;    ///< that some of the corners meet
    double power = 0;    ///< that arrives there, mean of the channels [W]
    int root = -1;       ///< the launched mesh's triangle of which it is a part; -1: of a height field
};

/// A lattice of columns x rows cells, two triangles a cell, corners row by row.
std::shared_ptr<const BlockTopology> regularTopology(int columns, int rows);

/// Slope of a ray against z [voxels] up to which its tubes are laid in z layers, the cheapest to store, though another
/// axis be nearer to it.
constexpr double kSteepestZ = 1.5;

/// Turns triangles of traced paths into tubes of their last legs in the voxeliser's frame, block by block, and keeps
/// the power ledger.
class TubeBuilder {
public:
    /// @param optics, emission  must outlive the builder
    TubeBuilder(const OpticalScene& optics, const Emission& emission, const TubeLaunch& launch);

    /// True when one grid axis serves all three legs: they cross its layers in the same sense and not too slantingly.
    bool axisServes(const Path& a, const Path& b, const Path& c) const { return chooseAxis(a, b, c, kMaxSlope) >= 0; }

    /// Adds the tube between three paths; orientation must be that of the surface. Each stands for about a
    /// third of the power.
    /// @param face  of the mesh triangle through which they enter; unused for height fields
    /// @return the specular surface that hands on what all three bring there; -1 when there is no one such surface
    int add(const Path& a, const Path& b, const Path& c, const glm::dvec3& face);

    /// Adds the tubes of a regular block from traced rows, all of whose rays z layers serve (per_layer > 0).
    /// @param topology  regularTopology(columns, rows)
    /// @param row       rows + 1 traced rows, of which corners [first, first + columns] are used
    void addRegular(const std::shared_ptr<const BlockTopology>& topology, const RayRow* row, int first, int columns,
                    int rows);

    /// What is added between these two brings `power` [W, mean of the channels] to its last event, or takes it away
    /// from there, all in all. Each history divides its tubes in its own way, which changes their sums in the fourth
    /// digit; so the shorter history says what arrives, and the first branch of an event what is left for the second.
    enum class Held { Arriving, Leaving };
    void beginHold();
    void endHold(Held what, double power);

    /// Makes one seed of those from `first` on, which are parts of this triangle and meet one surface: longer histories
    /// divide it anew, in their own way.
    void joinSeeds(std::size_t first, const Path& a, const Path& b, const Path& c);

    /// Makes room for the tubes of regular blocks that go down (`sense` < 0) or up through z layers.
    void reserve(int sense, std::size_t corners, std::size_t tubes);

    /// Ends the open blocks.
    void finish();
    /// After finish().
    TubeSets& sets() { return sets_; }

    /// Of the seeds that are added from here on. @param short_of  LaunchMesh::shortOf of what is added from here on
    void setRoot(int root, double short_of = 1) { root_ = root, short_of_ = short_of; }

    const GridFrame& frame() const { return optics_->frame(); }
    const PowerLedger& power() const { return power_; }
    /// What its `dropped` is made of: outlines, turned and events.
    const GivenUpPower& givenUp() const { return given_up_; }
    /// Of laid tubes whose corners end on different things [W].
    double astride() const { return astride_; }
    /// Of the power that came to the last event what neither went on nor stayed there: the other branch's [W].
    double leftForOther() const { return std::max(0.0, arriving_ - leaving_ - kept_); }
    std::int64_t tubes() const { return tubes_; }
    /// Triangles that add() was given, whatever became of them: what is not in regular blocks.
    std::int64_t added() const { return added_; }
    /// Of the space between two paths, among bodies (Obstacles::between).
    void countSearches(std::int64_t count) { searches_ += count; }
    std::int64_t searches() const { return searches_; }
    std::vector<TubeSeed>& seeds() { return seeds_; }

private:
    static constexpr double kMaxSlope = 2.0;    // of a ray against its axis, in voxels
    static constexpr double kLastSlope = 20.0;  // at the refinement floor
    struct OpenBlock {
        std::vector<BlockTopology::Triangle> triangles;
        std::vector<EmissionParam> params;  // of its corners, to find shared ones
        std::vector<double> ends;
        std::uint32_t first_corner = 0, first_tube = 0;
        int medium = 0;
    };
    using Corners = std::array<const Path*, 3>;

    /// Where in sets_ tubes lie that go this way along an axis.
    int setFor(int axis, bool upwards, const glm::dvec3& direction) const {
        const bool against = glm::dot(direction, launch_.lobe_axis) < 0;
        return axis * 2 + (upwards ? 1 : 0) + (against ? static_cast<int>(kSetsALobe) : 0);
    }
    int chooseAxis(const Path& a, const Path& b, const Path& c, double max_slope) const;
    bool missesBox(const Corners& corners) const;
    bool standsAstride(const Corners& corners) const;
    std::array<double, 3> sharesOfCorners(const Corners& corners) const;
    CornerRay cornerRay(const Path& path, int axis, double end_distance) const;
    std::uint8_t cornerIndex(int set, const Path& path, double end_distance);
    void openBlock(int set, int medium);
    void closeBlock(int set);
    /// @param powers  of each corner's share [W]
    void layTube(const Corners& corners, int axis, const std::array<glm::dvec3, 3>& powers);
    void layPart(const Corners& corners, int axis, const glm::dvec3& power, const std::array<double, 3>& ends);
    TubeConstants constantsOf(const Corners& corners, int axis, const glm::dvec3& power) const;
    double exitDistance(const glm::dvec3& position, const glm::dvec3& direction) const;
    void countFirstLeg(const Path& path, const glm::dvec3& emitted);
    double countCorner(const Path& path, const glm::dvec3& emitted, double PowerLedger::*unlaid);
    bool regularMissesBox(const RayRow* row, int first, int columns, int rows) const;
    void layRegular(const TubeBlock& block, const RayRow* row, int first, int columns, int rows,
                    const std::vector<double>& areas, TubeSet& set);
    void countRegular(const RayRow* row, int first, int columns, int rows, const std::vector<double>& across,
                      bool culled);

    const OpticalScene* optics_;
    const Emission* emission_;
    TubeLaunch launch_;
    TubeSets sets_;
    std::array<OpenBlock, std::tuple_size_v<TubeSets>> open_;
    std::vector<TubeSeed> seeds_;
    int root_ = -1;
    double short_of_ = 1;
    PowerLedger power_;
    GivenUpPower given_up_;
    double astride_ = 0;
    double arriving_ = 0, leaving_ = 0,
           kept_ = 0;  // at the last event [W]: in all, along the branch, and by the surface
    std::int64_t tubes_ = 0, added_ = 0, searches_ = 0;
    struct HoldStart {
        PowerLedger power;
        GivenUpPower given_up;
        double astride = 0;
        double arriving = 0, leaving = 0, kept = 0;
        std::array<std::size_t, std::tuple_size_v<TubeSets>> tubes{};
        std::size_t seeds = 0;
    } hold_;
};

}  // namespace photic
