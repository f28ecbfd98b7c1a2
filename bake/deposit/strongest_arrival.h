// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <span>
#include <vector>

#include "bake/deposit/bent_layers.h"
#include "bake/deposit/voxelise.h"

namespace photic {

/// What the arrivals in voxels are like, as sums over voxels.
struct ArrivalSums {
    double lit = 0;                 ///< voxels with light
    double several = 0;             ///< of them, those where all but the strongest arrival bring a hundredth or more
    double strongest_shares = 0;    ///< sum over those of what the strongest is of the light
    double all = 0, strongest = 0;  ///< sums of irradiance over lit voxels [W/m2]
    double all_squares = 0, left_out_squares = 0;
    void add(const ArrivalSums& other);
};

/// Keeps of each voxel the one arrival that brings most light, as [Ihrke et al. 2007, section 5.2] does.
///
/// An arrival is a piece of a front in one voxel: tubes that are turned the same way and whose cells on the launched
/// front hang together. Past a caustic a front lies in several sheets; where it turned inside out its tubes are turned
/// over, so that the sheets on both sides of a fold are two arrivals up to the fold itself. Tubes that went on along
/// another axis are known by their cells. An arrival's light is its mean over the voxel, exact in power as that of the
/// edge kernel, so that all arrivals together are what voxelise() gives. The paper compares single patches, whose
/// energy does not depend on how many of them a voxel got.
///
/// Cost: some half a microsecond a tube and layer. Memory: 36 bytes a voxel of lit leaves, besides the field; 96 bytes
/// a tube in one layer; and for each thread the pieces of tubes in eight rows of a layer, 24 bytes each: where light is
/// spread in long thin tubes there are thousands a voxel.
class StrongestArrival {
public:
    StrongestArrival(std::shared_ptr<const NeededVoxels> needed, FieldChannels channels);
    ~StrongestArrival();
    StrongestArrival(StrongestArrival&&) noexcept;

    /// What comes is of another light, or another direction of its disc: an arrival of its own everywhere.
    void beginLight() { ++light_; }
    /// What comes goes along an axis of its own.
    void beginFront() { ++front_; }
    /// Lays the tubes of one slab of a front, all together. Bitwise the same for any number of threads.
    /// @param points  1, 2 or 4 across a layer
    /// @param totals  expected: of all arrivals
    void lay(std::span<const BentTubes> tubes, const Slab& slab, int points, DepositTotals& totals);

    /// Power times path of the arrivals that are not kept [W m].
    double leftOut() const { return left_out_; }
    /// @param dark  [W/m2] voxels below are not lit
    ArrivalSums sums(double dark) const;
    /// Of the strongest arrivals. Nothing may be laid afterwards.
    LightField take() { return std::move(field_); }

private:
    struct Piece;
    struct Kept;
    struct Arriving;
    struct Landed;
    struct Layer;
    void land(std::span<const BentTubes> tubes, const Slab& slab, int lane, std::span<const LayerPoint> points,
              Layer& out) const;
    std::vector<Piece> gather(const Layer& layer, std::size_t strip) const;
    std::vector<Arriving> join(const Layer& layer, std::vector<Piece> pieces) const;
    void keep(const std::vector<Arriving>& arrivals, int axis, int w, double& left_out, double& unneeded);

    LightField field_;
    std::vector<std::unique_ptr<std::vector<Kept>>> kept_;  // per slot
    std::uint32_t light_ = 0, front_ = 0;
    double left_out_ = 0;
};

}  // namespace photic
