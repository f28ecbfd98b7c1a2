// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

namespace photic {

/// Grid axes in the order (u, v, w) for tubes that cross the layers of `axis`.
inline std::array<int, 3> axesFor(int axis) { return {(axis + 1) % 3, (axis + 2) % 3, axis}; }

/// How the triangles of a block hang together. Blocks of a regular mesh share one.
struct BlockTopology {
    static constexpr std::uint8_t kNone = 255;
    struct Triangle {
        std::uint8_t corner[3];
    };
    /// A directed edge: `left` runs through it from v0 to v1, `right` from v1 to v0; kNone at the block's rim.
    struct Edge {
        std::uint8_t v0, v1, left, right;
    };
    int vertex_count = 0;
    std::vector<Triangle> triangles;  ///< all in the same orientation on the surface
    std::vector<Edge> edges;

    /// Finds the edges of `triangles`.
    /// @param vertices  at most 255, as are the triangles
    static std::shared_ptr<const BlockTopology> fromTriangles(int vertices, std::vector<Triangle> triangles);
};

/// One end of a bundle: a traced ray in the voxeliser's frame. The frame's axes (u, v, w) are the grid's index axes,
/// turned so that w is the axis that the tubes cross layer by layer.
struct CornerRay {
    double u = 0, v = 0, w = 0;   ///< where the ray starts [voxels]
    double du_dw = 0, dv_dw = 0;  ///< slope
    double w_end = 0;             ///< where its deposit ends [voxels], overshoot included; exactly, as it opens
};

/// Constants of one tube: the bundle of rays between three corners.
struct TubeConstants {
    float power[3];   ///< at the start, per channel [W]; white light uses the first
    float length;     ///< mean path length per layer [m]
    float travel[3];  ///< mean of unit direction x path length per layer [m], world axes: what flux is made of
};

/// A few hundred neighbouring tubes that are culled, voxelised and refined together.
struct TubeBlock {
    std::shared_ptr<const BlockTopology> topology;
    std::uint32_t first_corner = 0;  ///< in TubeSet::corners
    std::uint32_t first_tube = 0;    ///< in TubeSet::tubes
    glm::dvec3 extinction{0};        ///< of the medium that this segment of the paths runs through, per channel [1/m]
    bool faceted = false;            ///< facets have thrown this light: each throws an outline of its own
    float share = 1;                 ///< of all light that counts, at most what this light's history has
};

/// Tubes that cross the layers of one grid axis in one sense.
struct TubeSet {
    int axis = 2;      ///< the grid axis that is w: 0 (u, v = y, z), 1 (z, x), 2 (x, y)
    int sense = -1;    ///< +1: light travels towards larger w
    int channels = 1;  ///< of power: 1 white, 3 coloured
    /// Sums of du/dw, dv/dw and of the sum of their squares, each x power, and of power.
    double slope_u_power = 0, slope_v_power = 0, slope2_power = 0, slope_power = 0;
    std::vector<TubeBlock> blocks;
    std::vector<CornerRay> corners;
    std::vector<TubeConstants> tubes;

    bool empty() const { return blocks.empty(); }
    /// Power-weighted mean slope of the rays.
    double meanSlopeU() const { return slope_power > 0 ? slope_u_power / slope_power : 0; }
    double meanSlopeV() const { return slope_power > 0 ? slope_v_power / slope_power : 0; }
    /// Root of the power-weighted mean square of the rays' slopes: light that goes apart slants, whatever its mean.
    double rmsSlope() const { return slope_power > 0 ? std::sqrt(slope2_power / slope_power) : 0; }
    /// Counts what the sums are made of.
    void addSlope(double du_dw, double dv_dw, double power) {
        slope_power += power, slope_u_power += power * du_dw, slope_v_power += power * dv_dw;
        slope2_power += power * (du_dw * du_dw + dv_dw * dv_dw);
    }
    /// Adds the blocks of a set of the same axis and sense.
    void append(const TubeSet& other);
};

/// The tubes of a launch: indexed by axis * 2 + (sense > 0), and from kSetsALobe on those of the second lobe alike.
inline constexpr std::size_t kSetsALobe = 6;
using TubeSets = std::array<TubeSet, 2 * kSetsALobe>;

}  // namespace photic
