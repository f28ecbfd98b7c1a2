// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "bake/deposit/edge_kernel.h"
#include "bake/deposit/slabs.h"
#include "bake/field/light_field.h"
#include "bake/report/monitor.h"
#include "bake/tubes/tube_set.h"

namespace photic {

struct BentRows;
class KeptTiles;

/// Which kernel sums the deposits.
enum class DepositKernel {
    Edges,  ///< signed edge coverage over 4 to 16 layers at a time
    Scalar  ///< each tube clipped against each voxel: the reference, several times slower
};

struct VoxeliseOptions {
    DepositKernel kernel = DepositKernel::Edges;
    InstructionSet instruction_set = bestInstructionSet();
    int quadrature = 0;      ///< Gauss points across a layer: 1, 2, 4, 6, 8 or 12; 0: pointsOfBlocks
    bool has_edges = false;  ///< bodies shape the light: pointsAcrossLayer
    double noise_floor = 0;  ///< [W/m2] irradiance below this is rounding of the sums and becomes 0
    /// Tiles that came to the same before are taken from here, and those of this deposit kept; null: all are summed.
    KeptTiles* kept = nullptr;
};

/// What voxelising counted, in W m (mean of the channels).
struct DepositTotals {
    double expected = 0;          ///< integral of power along the tubes inside needed voxels
    std::int64_t degenerate = 0;  ///< tube layers that were clipped one by one
    std::int64_t constant_leaves = 0;
};

/// Points at which a layer of these tubes is evaluated: one where their slope (root mean square) moves them by at
/// most 0.65 voxels from a layer to the next, two up to 1, four beyond. A layer's middle stands for the whole layer
/// badly where light crosses it slantwise: under a sun at 75 degrees one point is off by 5 % in the volume, four by 0.5
/// %. Within a sheet of tubes what one misplaces the next one brings; at the outline of a beam or of a shadow nothing
/// does. Light with such edges gets two points from 0.1 voxels on and four from 0.3: a quarter longer, and the spots of
/// a ball of mirrors 0.2 % off instead of 5.5 %.
int pointsAcrossLayer(double slope_voxels, bool has_edges = false);
int pointsAcrossLayer(const TubeSet& tubes, bool has_edges = false);
/// The same of light that facets throw, which is outlines all over: so many that the edge of a half plane of light is
/// told within 0.05 % of that light, root mean square over the voxels that it passes.
int pointsAcrossFacets(double slope_voxels);
/// Of each block of a set: by the whole set's slope, so that neighbours agree, as far as the block's share of the
/// light makes it count (no fewer than two for its sake), but of faceted ones by its own slope.
std::vector<int> pointsOfBlocks(const TubeSet& tubes, bool has_edges);

/// Adds the light of `tubes` to `field`, exactly in power: in each layer of voxels the tubes are cut by the layer's
/// middle plane (or Gauss points), the triangle between the three corner rays is intersected with the voxels, and each
/// voxel gets power x transmittance x path length x its share / volume. Ernst et al. 2005, made exact
/// (docs/methods.md).
///
/// Only tiles of 64 x 64 columns that hold needed voxels are summed. Bitwise the same for any number of threads.
/// Cost: about one pass over the mesh's edges per 16 layers, and one store per voxel.
/// @throws Error{Cancelled}
void voxelise(const TubeSet& tubes, LightField& field, const VoxeliseOptions& options, DepositTotals& totals,
              Monitor& monitor);

/// The same of tubes with bent legs in one slab.
/// @param tubes  of the corners only w and w_end hold, and of the tubes' constants only the power
/// @param bent   where the corners are on the slab's layers; each slab has rows of its own
/// @param group  one of planSlabs(field.needed(), tubes.axis, 64, widestLanes(options.instruction_set)); its slabs are
///               to be laid in turn
/// @throws Error{Cancelled}
void voxeliseSlab(const TubeSet& tubes, const BentRows& bent, const SlabGroup& group, std::size_t slab,
                  LightField& field, const VoxeliseOptions& options, DepositTotals& totals, Monitor& monitor);

}  // namespace photic
