// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bake/methods/wavefront_bends.h"
#include "bake/methods/wavefront_launch.h"
#include "bake/methods/wavefront_sweep.h"

namespace photic {

/// Tubes that are coarser than was asked for, since each is halved three times at most, and a front has no more than
/// four times as many as were launched.
struct FrontCoarse {
    double power = 0;       ///< that goes in them [W, mean of the channels]
    double by = 0;          ///< how much the worst of them bends [voxels]
    bool too_many = false;  ///< there was no room for all that should have been halved
};

/// Divides the tubes of a launched front where its rays go apart unevenly, and where tubes would be given up or meet
/// different things. New rays start from the light, between those that are there, so that they are exact; an edge is
/// halved or not for all tubes that share it, so that tubes still cover the light without gap or overlap.
class FrontRefiner {
public:
    /// All must outlive it.
    /// @param sweep  for looking; nothing is laid by it, and its totals are nobody's
    FrontRefiner(const FrontLaunch& launch, const LightSample& sample, FrontSweep& sweep, double tolerance)
        : launch_(launch), sample_(sample), sweep_(sweep), tolerance_(tolerance) {}

    Front refine(Front front);

    /// Of the last front that was refined.
    const FrontCoarse& coarse() const { return coarse_; }

    /// Halves edges that bend by more than `tolerance`, and the edges of some tubes once, until none bends by more, or
    /// each was halved three times, or there would be more than `most` tubes: then what bends most is halved.
    /// @param whole  tubes of which all edges are halved at least once, in order
    /// @param from   per tube of the result, which of the front's it is a part of
    /// @param coarse  what still bends by more is added; null: nobody asks
    static Front halveEdges(const LaunchPlane& plane, const Front& front, const FrontBends* bends, double tolerance,
                            const std::vector<std::uint32_t>& whole, std::size_t most, std::vector<std::uint32_t>& from,
                            FrontCoarse* coarse = nullptr);

private:
    const FrontLaunch& launch_;
    const LightSample& sample_;
    FrontSweep& sweep_;
    double tolerance_;
    FrontCoarse coarse_;
};

}  // namespace photic
