// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "bake/file/vdb.h"

namespace photic {

/// Light of one lobe at a point, interpolated: fluence rate per channel (all three equal when white) and flux [W/m2].
struct LookedUpLight {
    glm::dvec3 irradiance{0};
    glm::dvec3 flux{0};
    double meanIrradiance() const { return (irradiance.x + irradiance.y + irradiance.z) / 3; }
};

/// Trilinear look-ups of irradiance and flux among the eight voxels around a point; voxels that are not active count as
/// dark. Thread-safe; the volume must outlive it.
class VolumeLookup {
public:
    explicit VolumeLookup(const LightVolume& volume);

    /// Of the first lobe, or of the second (dark where there is none).
    LookedUpLight at(const glm::dvec3& position_world, int lobe = 0) const;
    /// Of all lobes.
    LookedUpLight allAt(const glm::dvec3& position_world) const;
    /// 1 or 2: how many lobes there are to add up.
    int lobes() const { return second_ ? 2 : 1; }

    /// What a receiver gets: E_c = irradiance_c * max(0, -normal . direction) [W/m2] per channel, summed over the
    /// lobes. A volume without `direction` gives its fluence rate.
    /// @param normal  unit, world
    glm::dvec3 receiverIrradiance(const glm::dvec3& position_world, const glm::dvec3& normal) const;

    /// How much of a look-up at a point is of voxels that are there: 1 well inside, 0 where all eight are dark.
    double covered(const glm::dvec3& position_world) const;

    /// One voxel, unfiltered.
    LookedUpLight voxel(const glm::ivec3& voxel, int lobe = 0) const;

    /// Of all lobes in one voxel, unfiltered, per channel [W/m2].
    glm::dvec3 irradiance(const glm::ivec3& at) const {
        return second_ ? voxel(at).irradiance + voxel(at, 1).irradiance : voxel(at).irradiance;
    }

    bool coloured() const { return channels_.irradiance == 3; }

private:
    /// Calls body(voxel, weight) for those of the eight voxels around a point that count.
    template <class Body>
    void forEachCorner(const glm::dvec3& position_world, const Body& body) const;
    static void add(const LightField& field, const glm::ivec3& voxel, double weight, std::array<double, 6>& sums);
    LookedUpLight sampleOf(const std::array<double, 6>& sums) const;

    const LightField& field_;
    const LightField* second_;
    FieldChannels channels_;
    bool has_direction_;
    glm::dmat3 index_from_world_;
    glm::dvec3 origin_world_;
};

}  // namespace photic
