// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "bake/field/light_field.h"
#include "bake/graded/spline_index.h"
#include "bake/methods/wavefront_launch.h"
#include "bake/scene/graded_index.h"
#include "bake/scene/index_volume.h"

namespace photic {

/// The media of a scene whose index varies, as one channel's light sees them. Where several hold a place, the first
/// one is there.
struct GradedMedia {
    explicit GradedMedia(const Scene& scene)
        : objects(scene.index->objects()), rims(objects.size() > 1 || !fillTheWorld()) {}
    const std::vector<GradedObject>& objects;
    bool rims;  ///< somewhere: not where one medium is everywhere

    bool disperses() const;
    bool fillTheWorld() const;
    bool attenuate() const;
    const GradedIndex& indexOf(const GradedObject& object, int channel) const {
        return *object.index[object.index.size() > 1 ? static_cast<std::size_t>(channel) : 0];
    }
    /// Which object is at a place; -1: none.
    int at(const glm::dvec3& world, int channel) const;
    double halfSquare(const glm::dvec3& world, int channel) const;
    /// Mean of n^2 / 2 over a voxel that a medium's rim goes through; elsewhere the middle serves.
    double halfSquareOfVoxel(const glm::dvec3& middle, const glm::dvec3& voxel, int channel) const;
    /// Range of n^2 over some places, for an estimate.
    double contrast(const GridFrame& frame) const;
};

/// How far straight on from a place a box is entered [m]; 0 within it, infinity where it is missed.
/// @param direction  unit
double distanceInto(const WorldBox& box, const glm::dvec3& from, const glm::dvec3& direction);

/// What holds all media, two voxels around them that a spline may blur them over, and the whole grid where one fills
/// the world.
FrontBox mediaBox(const GradedMedia& media, const GridFrame& frame);

/// The layers that light crosses: the target's and the grid's.
FrontSpace frontSpace(const FrontBox& target, const GridFrame& frame);

/// Why nothing can bake light through the media of a scene whose index varies, or "".
std::string gradedSpaceRefusal(const Scene& scene);

/// The index of refraction and what attenuates, sampled on a grid and a margin around it: what fronts and photons go
/// through alike.
class GradedSpace {
public:
    struct Sampling {
        int disc_samples = 1;  ///< directions on the sun's disc that light may come from
        SplineFit fit = SplineFit::Auto;
        int steps = 1;  ///< of a front's ray, a layer
    };
    /// @throws Error{Input} for more than 255 media
    GradedSpace(const Scene& scene, const GridFrame& frame, const Sampling& sampling);

    const GradedMedia& media() const { return media_; }
    /// Voxels that light has to cover where it comes in.
    const FrontBox& target() const { return target_; }
    const FrontSpace& space() const { return space_; }
    /// What ends light in it, from now on. It must outlive the object.
    void standIn(const FrontObstacles& obstacles) { space_.obstacles = &obstacles; }
    /// 3 where the media disperse: each channel has an index of its own.
    int passes() const { return media_.disperses() ? 3 : 1; }

    /// Samples what a channel's light goes through; space() then holds it, until the next time.
    /// @throws Error{Input} where n^2 is no positive number; Error{Cancelled}
    void sample(int channel, Monitor& monitor);
    /// What was sampled last, to keep while other channels are sampled.
    std::shared_ptr<const SplineIndex> index() const { return index_; }

    /// Largest change of n^2 / 2 from a voxel to the next, of all channels so far.
    double jump() const { return jump_; }
    /// Of the index and the media, at most at a time.
    std::int64_t bytes() const { return bytes_; }
    /// What becomes of faces, for a report; empty where there are none.
    std::string faces() const;
    /// How the last index was fitted, for the volume's metadata.
    const char* splineName() const { return index_ && index_->fit() == SplineFit::Plain ? "plain" : "through"; }

private:
    void widen(const Scene& scene, int disc_samples);
    double halfSquareAt(const glm::dvec3& world, const glm::dvec3& voxel, int channel) const;
    void layMedia(int channel);

    static constexpr int kMargin = 3;  // nodes, that a spline reaches and a little more
    GridFrame frame_;
    GradedMedia media_;
    FrontBox target_;
    FrontSpace space_, known_;  // known: before it was widened
    SplineFit fit_;
    bool all_light_;  // counts, also beside the media
    std::shared_ptr<const SplineIndex> index_;
    double jump_ = 0;
    std::int64_t bytes_ = 0;
};

/// The `caustic` grid: irradiance over what the lights would give without media, mean of the channels; 0 where that is
/// dark.
LightField causticBesideMedia(const Scene& scene, const LightField& field);

}  // namespace photic
