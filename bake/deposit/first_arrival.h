// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "bake/deposit/bent_layers.h"

namespace photic {

/// When light first comes to the centres of voxels: the least optical path of the tubes that cross a centre.
///
/// In a tube the optical path T is known at three corners with its slope, which is the ray's momentum p, so that
/// T(x) = sum b_i (T_i + p_i . (x - x_i) / 2), with the place's barycentric coordinates b, is exact to second order.
/// Voxels whose light misses their centre, as beside a caustic, take the T of a tube that passes, carried on by its
/// momentum.
class FirstArrival {
public:
    explicit FirstArrival(std::shared_ptr<const NeededVoxels> needed);

    /// Lays the tubes of one slab of a front. Bitwise the same for any number of threads.
    /// @param origin  optical path [m] that the rows count from
    void lay(std::span<const BentTubes> tubes, const Slab& slab, double origin);
    /// One channel [m]; 0 where no light came. Nothing may be laid afterwards.
    LightField take();

private:
    void layLane(const BentTubes& tubes, const Slab& slab, int lane, double origin);
    LightField across_, beside_;  // through the centre, and past it
};

}  // namespace photic
