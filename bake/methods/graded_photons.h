// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "bake/graded/flat_blocks.h"
#include "bake/methods/graded_space.h"
#include "bake/methods/photon_launch.h"
#include "bake/methods/photon_paths.h"
#include "bake/paths/light_end.h"
#include "bake/paths/ray_casting.h"

namespace photic {

/// Photons through media whose index varies: the reference of `wavefront`, which goes through the same samples of the
/// index. Each is followed by itself, step by step of Yoshida's integrator, at most half a voxel long and shorter where
/// the index bends it much, and straight through blocks of one index. Its light is laid along the chords of its steps,
/// exactly in power.
///
/// Objects that stand in the scene stop photons on any leg; at sharp surfaces each goes on along all its branches.
class GradedPhotons {
public:
    /// Samples the index for all channels. @throws Error{Input}, Error{Cancelled} as GradedSpace
    GradedPhotons(const Scene& scene, const GridFrame& frame, Monitor& monitor);

    /// Of a light; the object must outlive them. @throws Error{Input} for a lamp that is not outside, on one side
    std::unique_ptr<PhotonPaths> pathsOf(const Light& light) const;
    const GradedSpace& medium() const { return medium_; }
    /// Of the samples that are kept.
    std::int64_t bytes() const { return bytes_; }

private:
    struct Space;
    struct Pass;
    struct Photon;
    class Paths;

    void follow(const Pass& pass, const Photon& photon, TrackSink& field, PhotonTally& tally) const;
    void followLeg(const Pass& pass, Photon photon, std::vector<Photon>& waiting, TrackSink& field,
                   PhotonTally& tally) const;
    RayHit hitOn(const Photon& photon, const glm::dvec3& direction, double length, Meeting& meeting) const;
    RayHit layPiece(const Space& space, const glm::dvec3& to, Photon& photon, Meeting& meeting, TrackSink& field,
                    PhotonTally& tally) const;
    void meet(const Pass& pass, const Photon& photon, const glm::dvec3& direction, const RayHit& hit,
              const Meeting& meeting, std::vector<Photon>& waiting, PhotonTally& tally) const;
    double straightThrough(const Space& space, const Photon& photon, const glm::ivec3& block) const;
    double distanceToSpace(const Photon& photon) const;
    bool inside(const glm::dvec3& world) const;

    const Scene& scene_;
    GridFrame frame_;
    GradedSpace medium_;
    RayCaster caster_;
    LightEnd light_end_;
    std::vector<std::shared_ptr<const Pass>> passes_;
    glm::dvec3 low_world_{0}, high_world_{0};  // of the space
    glm::dvec3 voxel_{1};                      // [m]
    double longest_ = 0;                       // way of a photon [m]
    std::int64_t bytes_ = 0;
};

}  // namespace photic
