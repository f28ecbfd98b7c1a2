// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <vector>

#include "bake/field/grid_frame.h"
#include "bake/report/bake_report.h"
#include "bake/tubes/corner.h"
#include "bake/tubes/ray_tube.h"
#include "bake/tubes/row_trace.h"

namespace photic {

/// What tubes carry and where it goes, shared by all builders of a bake.
struct TubeLight {
    glm::dvec3 irradiance{0};                 ///< across the beam, per channel [W/m2], of this part of the light
    glm::dvec3 direction{0};                  ///< unit, of travel
    int channels = 1;                         ///< 1: white
    glm::dvec3 absorption{0}, scattering{0};  ///< of the medium that the branch runs through [1/m]; 0 in air
    bool ends_matter = true;  ///< a tube over two objects stops at the first; false where only planes end light, behind
                              ///< which nothing is seen: each ray keeps its own end
    bool two_sided = false;   ///< meshes take light from either side, height fields from above
    TubeDensity density = TubeDensity::Constant;
    bool counts_emission = true;  ///< false for a second branch of the same light: emitted power is counted once
};

/// A lattice of columns x rows cells, two triangles a cell, corners row by row.
std::shared_ptr<const BlockTopology> regularTopology(int columns, int rows);

/// Turns triangles of traced corners into tubes in the voxeliser's frame, block by block, and keeps the power ledger.
class TubeBuilder {
public:
    TubeBuilder(const GridFrame& frame, const TubeLight& light);

    /// True when one grid axis serves all three rays: they cross its layers in the same sense and not too slantingly.
    bool axisServes(const Corner& a, const Corner& b, const Corner& c) const {
        return chooseAxis(a, b, c, kMaxSlope) >= 0;
    }

    /// Adds the tube between three corners; orientation must be that of the surface. Each corner stands for a third of
    /// the power.
    void add(const Corner& a, const Corner& b, const Corner& c);

    /// Adds the tubes of a regular block from traced rows, all of whose rays z layers serve (per_layer > 0).
    /// @param topology  regularTopology(columns, rows)
    /// @param row       rows + 1 traced rows, of which corners [first, first + columns] are used; linear density reads
    /// one
    ///                  more on either side
    void addRegular(const std::shared_ptr<const BlockTopology>& topology, const RayRow* row, int first, int columns,
                    int rows);

    /// Makes room for the tubes of regular blocks that go down (`sense` < 0) or up through z layers.
    void reserve(int sense, std::size_t corners, std::size_t tubes);

    /// Ends the open blocks. Sets are indexed by axis * 2 + (sense > 0).
    std::array<TubeSet, 6>& finish();

    /// Index-space direction per metre of travel.
    glm::dvec3 indexDirection(const glm::dvec3& direction) const { return index_from_world_ * direction; }
    glm::dvec3 indexPosition(const glm::dvec3& position) const {
        return index_from_world_ * (position - frame_.origin_world);
    }
    /// Distance [m] at which a ray from inside or outside leaves the box for good; < 0 when that lies behind it.
    double exitDistance(const glm::dvec3& index_position, const glm::dvec3& index_direction) const;

    const PowerLedger& power() const { return power_; }
    std::int64_t tubes() const { return tubes_; }
    std::int64_t cornerRays() const { return corner_rays_; }

private:
    static constexpr double kMaxSlope = 2.0;    // of a ray against its axis, in voxels
    static constexpr double kLastSlope = 20.0;  // at the refinement floor
    struct OpenBlock {
        std::vector<BlockTopology::Triangle> triangles;
        std::vector<SurfaceParam> params;  // of its corners, to find shared ones
        std::vector<float> ends;
        std::uint32_t first_corner = 0, first_tube = 0;
    };

    int chooseAxis(const Corner& a, const Corner& b, const Corner& c, double max_slope) const;
    bool missesBox(const Corner* const* corners, int count, int axis) const;
    CornerRay cornerRay(const Corner& corner, int axis, double end_distance) const;
    std::uint8_t cornerIndex(int set, const Corner& corner, double end_distance);
    void closeBlock(int set);
    void countTube(const Corner* const* corners, const glm::dvec3& arriving, bool culled);
    bool regularMissesBox(const RayRow* row, int first, int columns, int rows) const;
    void addSpreads(const RayRow* row, int first, int columns, int rows, TubeSet& set) const;
    void countRegular(double arriving, double fraction, double untraced, double hit_distance, double exit_distance,
                      bool culled);

    GridFrame frame_;
    glm::dmat3 index_from_world_;
    TubeLight light_;
    glm::dvec3 extinction_;
    std::array<TubeSet, 6> sets_;
    std::array<OpenBlock, 6> open_;
    PowerLedger power_;
    std::int64_t tubes_ = 0, corner_rays_ = 0;
};

}  // namespace photic
