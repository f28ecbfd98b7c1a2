// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "bake/field/light_field.h"

namespace photic {

class LeafArena;

/// A straight piece of a photon's path.
struct Track {
    glm::dvec3 origin{0};       ///< world [m]
    glm::dvec3 direction{0};    ///< unit, world
    glm::dvec3 power{0};        ///< at `origin`, per channel [W]; white light uses the first
    glm::dvec3 extinction{0};   ///< of the medium, per channel [1/m]; from `origin` on
    double begin = 0, end = 0;  ///< of the deposit, along the track [m]
    /// A piece of a bent path, which goes on from the one before: the path was counted in its first voxel.
    bool continues = false;
};

/// What a track left in the grid.
struct DepositedTrack {
    bool touched = false;  ///< at least one needed voxel was crossed, of the whole where it is a part
    double path = 0;  ///< integral of power along the track through needed voxels [W m], mean of the channels; found
                      ///< from the track's ends alone where every voxel of the grid is needed
};

/// Takes the straight pieces of photons' paths.
class TrackSink {
public:
    virtual ~TrackSink() = default;
    virtual DepositedTrack deposit(const Track& track) = 0;
};

/// Sums photon tracks on needed voxels: per voxel the integral of power along the tracks inside it [W m] (which is
/// fluence rate x volume), the same times direction, and the number of tracks. Memory follows the leaves that are
/// crossed. One thread at a time.
///
/// @tparam Real  of the sums: float is faster, but n equal deposits in a voxel may be off by n x 3e-8
template <class Real>
class TrackAccumulator {
public:
    TrackAccumulator(const NeededVoxels& needed, FieldChannels channels);
    ~TrackAccumulator();
    TrackAccumulator(TrackAccumulator&&) noexcept;

    /// Clips the track to the grid and walks its voxels (Amanatides and Woo 1987), on sheared grids too.
    DepositedTrack deposit(const Track& track);

    FieldChannels channels() const { return channels_; }
    const NeededVoxels& needed() const { return *needed_; }

    /// 512 x channels().count() sums, channels together, then the counts; null where no track went.
    const Real* sums(int slot) const { return leaves_[static_cast<std::size_t>(slot)]; }
    const std::uint32_t* counts(int slot) const;
    /// Sets a leaf back to zero, keeping its memory.
    void clear(int slot);

private:
    struct Ray;
    template <int Channels, bool Flux, bool Medium>
    DepositedTrack walk(const Track& track, const Ray& ray, double begin, double end);
    bool clipTo(const Ray& ray, const glm::dvec3& low, const glm::dvec3& high, double& begin, double& end) const;
    Real* leafAt(int slot);

    const NeededVoxels* needed_;
    FieldChannels channels_;
    glm::dmat3 index_from_world_;
    glm::dvec3 origin_world_;
    glm::dvec3 box_low_, box_high_;        // of the grid, in index space with voxel (i,j,k) at [i, i+1)
    glm::dvec3 needed_low_, needed_high_;  // of the needed leaves
    std::size_t leaf_bytes_;
    std::unique_ptr<LeafArena> arena_;
    std::vector<Real*> leaves_;
    std::vector<std::uint8_t> full_;  // NeededVoxels::leafFull, which is too slow to ask at every leaf
};

extern template class TrackAccumulator<float>;
extern template class TrackAccumulator<double>;

}  // namespace photic
