// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "bake/field/light_field.h"
#include "bake/graded/spline_index.h"
#include "bake/methods/wavefront_launch.h"
#include "bake/paths/optical_scene.h"
#include "bake/scene/graded_index.h"
#include "bake/scene/index_volume.h"

namespace photic {

/// Media whose index varies and that lie in one part of space, as one channel's light sees them: the scene's objects in
/// air, or the one that is on a side of surfaces. Where several hold a place, the first one is there.
struct GradedMedia {
    /// Those of a scene that no surface names.
    explicit GradedMedia(const Scene& scene);
    explicit GradedMedia(std::vector<GradedObject> which)
        : objects(std::move(which)), rims(objects.size() > 1 || !fillTheWorld()) {}
    std::vector<GradedObject> objects;
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
        int steps = 1;                                         ///< of a front's ray, a layer
        FrontIntegrator integrator = FrontIntegrator::Planes;  ///< of it
        double rim = 0;  ///< share of the largest difference of n^2 that counts as being in a medium; 0: by the fit
    };
    /// @throws Error{Input} for more than 255 media, and for more than 2^28 voxels that are next to empty
    GradedSpace(const Scene& scene, const GridFrame& frame, const Sampling& sampling);

    /// In air.
    const GradedMedia& media() const { return parts_.front().media; }
    /// Voxels that light has to cover where it comes in.
    const FrontBox& target() const { return target_; }
    /// What lies in air.
    const FrontSpace& space() const { return parts_.front().space; }
    /// What light goes through that is inside of these media.
    const FrontSpace& spaceOf(const MediumStack& inside) const { return parts_[partOf(inside)].space; }
    /// All that light may go through; the first is space().
    int spaces() const { return static_cast<int>(parts_.size()); }
    const FrontSpace& spaceNumbered(int number) const { return parts_[static_cast<std::size_t>(number)].space; }
    /// The number of spaceOf().
    std::size_t partOf(const MediumStack& inside) const;
    /// Of one of the optical scene's media.
    std::size_t partOf(int medium) const { return part_of_medium_[static_cast<std::size_t>(medium)]; }
    /// Null in a scene without surfaces.
    const OpticalScene* optics() const { return optics_.get(); }
    /// What becomes of light at a surface, with the indices that media have at the place.
    /// @param direction  unit, of travel
    OpticalScene::Event eventOn(int surface, const MediumStack& inside, const glm::dvec3& direction,
                                const Meeting& at) const;
    /// What light is inside of where it comes in.
    const MediumStack& startInside() const { return start_; }
    /// What a lamp stands inside of that stands among the media.
    MediumStack insideAt(const glm::dvec3& world) const;
    /// Whether light is in a medium whose index varies at a place where it comes in, or starts in a lamp.
    bool startsGraded(const MediumStack& inside, const glm::dvec3& world, int channel) const;
    /// How a light comes in, and what it has to cover.
    /// @param lamp  [m] where it stands; none for a sun
    FrontLaunch launch(const std::optional<glm::dvec3>& lamp, double spacing, int channel,
                       const RayCaster* caster) const;
    /// How often light may change the axis along which it is followed.
    void followTurns(int most) {
        for (Part& part : parts_) part.space.limits.turns = most;
    }
    /// What ends light in it, from now on. It must outlive the object.
    void standIn(const FrontObstacles& obstacles);
    /// 3 where the media disperse: each channel has an index of its own.
    int passes() const { return disperses_ ? 3 : 1; }

    /// Samples what a channel's light goes through; the spaces then hold it, until the next time.
    /// @throws Error{Input} where n^2 is no positive number; Error{Cancelled}
    void sample(int channel, Monitor& monitor);
    /// What was sampled last, of a space, to keep while other channels are sampled; null where its index is the same
    /// everywhere.
    std::shared_ptr<const SplineIndex> index(int number) const {
        return parts_[static_cast<std::size_t>(number)].index;
    }
    bool attenuate() const;

    /// Largest change of n^2 / 2 from a voxel to the next, of all channels so far.
    double jump() const { return jump_; }
    /// Of the index and the media, at most at a time.
    std::int64_t bytes() const { return bytes_; }
    /// What becomes of faces, for a report; empty where there are none.
    std::string faces() const;
    /// How the last index was fitted, for the volume's metadata.
    const char* splineName() const { return plain() ? "plain" : "through"; }

private:
    /// A part of space with one law of the index.
    struct Part {
        GradedMedia media;  // none where the index is the same everywhere
        FrontSpace space;
        std::optional<WorldBox> within{};  // of the surfaces that enclose it; nothing: it may be anywhere
        std::vector<double> even{};        // n of each channel, and of all light first, where there are no media
        std::shared_ptr<const SplineIndex> index{};
        bool enclosed = false;
    };
    void findParts(const Scene& scene);
    void addSurfaces(const Scene& scene);
    void addLampsNear(const Scene& scene);
    void widen(const Scene& scene, int disc_samples);
    double halfSquareAt(const Part& part, const glm::dvec3& world, const glm::dvec3& voxel, int channel) const;
    void sample(Part& part, int channel, Monitor& monitor);
    void layMedia(Part& part, int channel) const;
    bool plain() const;

    static constexpr int kMargin = 3;  // nodes, that a spline reaches and a little more
    GridFrame frame_;
    std::vector<Part> parts_;
    std::unique_ptr<OpticalScene> optics_;
    std::vector<std::size_t> part_of_medium_;  // of the optical scene's media
    MediumStack start_;
    bool over_water_ = false;  // light comes in from above
    bool disperses_ = false;
    FrontBox target_;
    FrontSpace box_, known_;  // that light crosses; known: before it was widened
    SplineFit fit_;
    double rim_;
    bool all_light_;  // counts, also beside the media
    double jump_ = 0;
    std::int64_t bytes_ = 0;
};

/// The `caustic` grid: irradiance over what the lights would give without media, mean of the channels; 0 where that is
/// dark.
LightField causticBesideMedia(const Scene& scene, const LightField& field);

}  // namespace photic
