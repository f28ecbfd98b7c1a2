// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bake/methods/wavefront_bends.h"
#include "bake/methods/wavefront_launch.h"
#include "bake/methods/wavefront_sweep.h"

namespace photic {

/// Divides the tubes of a launched front where its rays go apart unevenly, and where tubes would be given up or meet
/// different things. New rays start from the light, between those that are there, so that they are exact; an edge is
/// halved or not for all tubes that share it, so that tubes still cover the light without gap or overlap.
class FrontRefiner {
public:
    /// All must outlive it.
    /// @param sweep  for looking; nothing is laid by it, and its totals are nobody's
    FrontRefiner(const FrontLaunch& launch, const LightSample& sample, FrontSweep& sweep, double tolerance)
        : launch_(launch), sample_(sample), sweep_(sweep), tolerance_(tolerance) {}

    Front refine(Front front) const;

    /// Halves edges that bend by more than `tolerance`, and the edges of some tubes once, until none bends by more, or
    /// each was halved three times, or there would be more than `most` tubes: then what bends most is halved.
    /// @param whole  tubes of which all edges are halved at least once, in order
    /// @param from   per tube of the result, which of the front's it is a part of
    static Front halveEdges(const LaunchPlane& plane, const Front& front, const FrontBends* bends, double tolerance,
                            const std::vector<std::uint32_t>& whole, std::size_t most,
                            std::vector<std::uint32_t>& from);

private:
    const FrontLaunch& launch_;
    const LightSample& sample_;
    FrontSweep& sweep_;
    double tolerance_;
};

}  // namespace photic
