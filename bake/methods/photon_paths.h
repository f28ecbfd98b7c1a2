// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "bake/deposit/track_deposit.h"
#include "bake/report/bake_report.h"

namespace photic {

/// What one repetition adds up beside the field. Powers are those of the repetition's own estimate.
struct PhotonTally {
    PowerLedger power;
    double path = 0;
    std::int64_t rays = 0, deposited = 0;

    void add(const PhotonTally& t) {
        for (const auto term : PowerLedger::kTerms) power.*term += t.power.*term;
        path += t.path, rays += t.rays, deposited += t.deposited;
    }
};

/// The paths of one light by one way into the scene, one for each point of the unit cube. Shared by all threads.
class PhotonPaths {
public:
    virtual ~PhotonPaths() = default;
    /// Of the points: 2 or 4.
    virtual int dimensions() const = 0;
    /// About the power of all paths, mean of the channels [W]: for sharing out paths.
    virtual double estimatedPower() const = 0;
    /// Follows a path to its end.
    /// @param share  of the power of all paths that this one stands for
    virtual void follow(const std::array<double, 4>& x, double share, TrackSink& field, PhotonTally& tally) const = 0;
};

}  // namespace photic
