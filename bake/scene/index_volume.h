// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bake/report/monitor.h"
#include "bake/scene/medium_volume.h"

namespace photic {

class GradedIndex;

/// How an object's faces send light back besides Fresnel's mirror. Eye rays see it; bakes leave faces as they are.
struct FaceReflection {
    glm::dvec3 albedo{0};  ///< share of the light that arrives which goes back evenly to all sides (Lambert), 0..1
    /// What is there instead of `albedo`; null where that is the same everywhere.
    std::shared_ptr<const MediumVolume> albedo_volume{};
    double roughness = 0;  ///< 0..1, of the highlights of baked light: alpha = roughness^2 of GGX; 0: none are drawn
    bool reflects() const { return albedo_volume || albedo != glm::dvec3(0) || roughness > 0; }
};

/// A medium whose index varies in space: a [[medium]] with `index`. An object by itself, in air; or, where surfaces
/// name it, what lies on their side, and then the scene's medium of the same name stands for it in Scene::media.
struct GradedObject {
    std::string name;
    std::string where;  ///< file:line of its table, for messages
    /// One, or three for red, green and blue.
    std::vector<std::shared_ptr<const GradedIndex>> index{};
    glm::dvec3 absorption{0}, scattering{0};  ///< per channel [1/m], where the object is
    double anisotropy = 0;                    ///< Henyey-Greenstein g, -1..1
    /// What absorbs instead of `absorption`; null where that is the same everywhere.
    std::shared_ptr<const MediumVolume> absorption_volume{};
    /// Surfaces name it: it is on their side of them and nowhere else, however far its index is known.
    bool enclosed = false;
    /// Of light by itself [W/(m3 sr)], where the object is. Eye rays see it; no bake lights a scene with it.
    glm::dvec3 emission{0};
    /// What is there instead of `emission` and `anisotropy`; null where those are the same everywhere.
    std::shared_ptr<const MediumVolume> emission_volume{}, anisotropy_volume{};
    FaceReflection face{};
    bool shines() const { return emission_volume || emission != glm::dvec3(0); }
    glm::dvec3 extinction() const { return absorption + scattering; }
    bool attenuates() const { return absorption_volume || extinction() != glm::dvec3(0); }
    bool coloured() const {
        const glm::dvec3 t = extinction();
        return index.size() > 1 || t.x != t.y || t.y != t.z || (absorption_volume && absorption_volume->coloured());
    }
};

inline constexpr double kLeastIndex = 0.01, kLargestIndex = 100;  ///< that scenes may have

/// A refractive index that varies in space: of the water, from samples on an affine grid, or of objects in air.
///
/// Between samples: cubic convolution [Keys 1981, a = -1/2], which goes through the samples with a continuous gradient
/// and is exact for polynomials of second degree; never beyond the least and largest sample. A trilinear index would
/// have a kink at every sample, and fronts show it.
/// Where the samples fill their box, the index goes on beyond a side as it is there, and an axis with one sample is
/// constant; where some are missing (not a number), those and all that is outside hold `medium`.
class IndexVolume {
public:
    struct Samples {
        glm::dmat3 world_from_index{1};
        glm::dvec3 origin_world{0};  ///< of sample (0, 0, 0) [m]
        glm::ivec3 size{0};
        std::vector<float> values;  ///< n, x fastest; NaN where none is given
    };
    /// @param medium  n where no sample is
    IndexVolume(Samples samples, double medium);
    /// Media whose index varies, without samples of the water's: at() and all below it are for those.
    explicit IndexVolume(std::vector<GradedObject> objects);
    const std::vector<GradedObject>& objects() const { return objects_; }

    /// n at a place in the world.
    double at(const glm::dvec3& world) const;
    double least() const { return least_; }
    double largest() const { return largest_; }
    /// A bound of |dn/dx|, |dn/dy| and |dn/dz|, from neighbouring samples [1/m].
    glm::dvec3 steepest() const { return steepest_; }
    /// Samples along each axis, and the place in the world of one, or between them.
    glm::ivec3 size() const { return samples_.size; }
    glm::dvec3 place(const glm::dvec3& sample) const {
        return samples_.origin_world + samples_.world_from_index * sample;
    }
    /// The samples fill their box.
    bool full() const { return full_; }
    /// Whether one of the eight samples around a place is given.
    bool holds(const glm::dvec3& sample) const;

private:
    float sample(int x, int y, int z) const;

    Samples samples_;
    std::vector<GradedObject> objects_;
    glm::dmat3 index_from_world_;
    double medium_, least_, largest_;
    glm::dvec3 steepest_{0};
    bool full_ = true;
    std::vector<bool> given_;  // per sample; empty where all are
};

/// n over height in layers, linear between them and constant beyond the first and last: an IndexVolume without file.
/// @param layers  (z [m], n), at least one, in any order, no z twice
IndexVolume layeredIndex(std::vector<std::pair<double, double>> layers);

/// The float grid `grid` of a .vdb file; the one that is called ior, index or n, or the only one, when `grid` is empty.
/// @param bytes    of the file at `path`
/// @param monitor  is warned of values that were saved as half floats
/// @throws Error{Input} for a damaged file, no such grid, a perspective transform, values out of 0.01 to 100 (with the
/// voxel) and boxes of more than 2^28 voxels
IndexVolume readIndexVolume(const std::string& path, const std::string& bytes, const std::string& grid, double medium,
                            Monitor& monitor);

}  // namespace photic
