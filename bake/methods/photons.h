// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "bake/methods/catalogue.h"

namespace photic {

enum class PhotonSampling {
    Quasi,  ///< R sequence with independent random shifts
    Random  ///< independent points, for comparison
};

struct PhotonOptions {
    PhotonSampling sampling = PhotonSampling::Quasi;
    std::int64_t count = 4'000'000;  ///< paths in all, over every light, surface and shift
    int shifts = 16;                 ///< independent repetitions, whose spread gives the standard error
    std::int64_t seed = 1;
    int wavelengths = 12;  ///< at which light is traced where media disperse
};

/// The reference method: quasi-random paths of any number of events, with a track-length estimate of the
/// fluence rate in every needed voxel. Unbiased for voxel averages; the standard error per voxel comes from the spread
/// of the shifts.
///
/// Points follow the R sequence (Roberts 2018, the golden ratio's generalisation to 2 or 4 dimensions: place, and place
/// on the sun's disc), shifted at random (Cranley and Patterson 1976). Results are bitwise the same for any number of
/// threads. Memory: (channels + 1) x 8 bytes a lit voxel, and channels x 8 + 4 more for each thread.
///
/// @throws Error{Cancelled}
BakeResult bakePhotons(const Scene& scene, std::shared_ptr<const NeededVoxels> needed, const PhotonOptions& options,
                       Monitor& monitor);

/// The catalogue's row.
Method photonsMethod();

}  // namespace photic
