// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "bake/deposit/track_deposit.h"
#include "bake/methods/photon_launch.h"
#include "bake/methods/photon_paths.h"
#include "bake/paths/optical_scene.h"
#include "bake/report/bake_report.h"
#include "bake/tubes/histories.h"

namespace photic {

/// Follows photons from their surface to their end, by the steps of the one tracer, and tells a sink what of their
/// paths lies inside the grid's box. Shared by all threads.
class PhotonTracer {
public:
    PhotonTracer(const Scene& scene, const GridFrame& frame, const std::vector<SpectralSample>& spectrum);

    /// @param power  of the photon, per channel [W], before anything blocks it
    void follow(int surface, const PhotonStart& start, const glm::dvec3& power, TrackSink& field,
                PhotonTally& tally) const;

private:
    struct Photon {
        glm::dvec3 direction{0}, power{0};
        MediumStack inside;
        double least = 0;  // [W] below which a branch is not followed
        int events = 0, wavelength = 0;
    };

    void meet(const Photon& photon, int surface, const Meeting& at, TrackSink& field, PhotonTally& tally) const;
    void runLeg(Photon photon, const glm::dvec3& origin, TrackSink& field, PhotonTally& tally) const;

    const std::vector<SpectralSample>& spectrum_;
    OpticalScene optics_;
    FollowLimits limits_;
};

}  // namespace photic
