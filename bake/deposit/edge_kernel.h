// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "bake/simd/instruction_set.h"
#include "bake/tubes/tube_set.h"

namespace photic {

struct BentRows;

/// A box of voxels that is summed in the cache: up to 64 x 64 columns (u, v), 4, 8 or 16 layers (w) in the lanes.
///
/// `sums` holds, per row v, column u, channel and lane, the change of density from one column to the next; after all
/// edges are in, a running sum along u gives the density. Lane l is shifted by whole voxels (shift_u[l], shift_v[l])
/// that follow the mean slope of the light, so that a tube meets the same few columns in all lanes:
/// column c of lane l is the voxel u0 + c + shift_u[l]. Rows and columns count from the buffer's own origin.
struct TileSums {
    static constexpr int kColumns = 64;
    static constexpr int kMaxLanes = 16;
    int lanes = 16;
    int active_lanes = 16;      ///< lanes past these are padding: computed, not counted, not kept
    int first_w = 0;            ///< layer of lane 0
    int u0 = 0, v0 = 0;         ///< voxel of column 0, row 0 for a lane that is not shifted
    int columns = 0, rows = 0;  ///< of the buffer, shifts included
    int shift_u[kMaxLanes] = {}, shift_v[kMaxLanes] = {};
    int tile_min_u = 0, tile_min_v = 0, tile_max_u = 0, tile_max_v = 0;  ///< the tile's voxels, max exclusive
    int rect_min_u = 0, rect_min_v = 0, rect_max_u = 0, rect_max_v = 0;  ///< rectangle of processed tiles around it
    int channels = 4;                                                    ///< irradiance channels + 3 with flux
    float* sums = nullptr;                                               ///< rows x (columns + 1) x channels x lanes
    double layer_offset = 0.5;  ///< where in the layer the plane lies, 0 entry .. 1 exit (Gauss point)
    float layer_weight = 1;     ///< of that Gauss point
    double expected = 0;        ///< sum of power x path length inside the rectangle [W m], owned by this tile
    const BentRows* bent =
        nullptr;                  ///< where legs are bent: the corners' places on these layers (bake/tubes/bent_rows.h)
    bool running = true;          ///< sums hold changes along u; false: densities (the scalar kernel)
    std::int64_t degenerate = 0;  ///< tube layers that were clipped one by one
    int cellStride() const { return channels * lanes; }
    int rowStride() const { return (columns + 1) * cellStride(); }
};

/// Adds the tubes of some blocks to a tile's sums by signed edge coverage (docs/methods.md): each mesh edge adds
/// (density right - density left) x the exact area of each voxel to its right. Degenerate tubes are clipped.
using EdgeKernel = void (*)(const TubeSet&, const std::uint32_t* blocks, int block_count, TileSums&);

/// Turns changes along u into densities: one running sum per row.
using SumKernel = void (*)(TileSums&);

/// Copies 8 x 8 columns x 8 lanes out of a tile whose w is the grid's z, into leaf order (u, v, lane), all channels, 0
/// where lanes from `first_lane` on are not the tile's, times `scale`; voxels whose irradiance is below `floor`
/// (rounding of the running sums) become 0 in all channels.
/// @param u, v  the leaf's first voxel; out: channels x 512 @return whether any value is not 0
using LeafKernel = bool (*)(const TileSums&, int u, int v, int first_lane, int irradiance_channels, float scale,
                            float floor, float* out);

struct TileKernels {
    EdgeKernel edges = nullptr;
    SumKernel sum = nullptr;
    LeafKernel leaf = nullptr;
};

/// @param lanes  4, 8 or 16
/// @param irradiance_channels  1 or 3
TileKernels tileKernels(InstructionSet set, int lanes, int irradiance_channels, bool flux);

/// Adds one tube's layer by clipping its triangle against the voxels in barycentric coordinates, which stays exact
/// when the image of the triangle collapses (docs/methods.md). Sub-voxel exact at any size.
///
/// @param x, y     the corners in the buffer's columns and rows
/// @param amounts  per channel, what the whole tube deposits in this layer
void depositClipped(TileSums& tile, int lane, const float x[3], const float y[3], const float* amounts);

/// The same, voxel by voxel and without running sums: the plain kernel that the vector ones are measured against.
void scalarKernel(const TubeSet& set, const std::uint32_t* blocks, int block_count, TileSums& tile);

/// Whether this tile counts a tube's layer for the ledger: whether it holds the centroid of the tube there, moved into
/// the rectangle of processed tiles. In double precision and from what all tiles share, so that of the tiles beside a
/// seam exactly one does.
///
/// @param first_corner, c  of the block, and the tube's three in it
bool ownsTubeLayer(const TileSums& tile, const TubeSet& set, std::uint32_t first_corner, const std::uint8_t c[3],
                   int lane);

/// Mean over a triangle of a linear function clamped to [0, 1], from its corner values.
double meanClamped(double a, double b, double c);

/// Fraction of a triangle inside the rectangle [0, width] x [0, height].
double fractionInside(const double x[3], const double y[3], double width, double height);

}  // namespace photic
