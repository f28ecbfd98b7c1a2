// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace photic {

/// What a medium may have in each place, by the name of its grid, and what its values may be.
struct MediumQuantity {
    const char* name;
    double least = 0, most = 1e30;
    const char* limits = "0 or more";
};
inline constexpr MediumQuantity kAbsorption{"absorption"};                                             ///< [1/m]
inline constexpr MediumQuantity kEmission{"emission"};                                                 ///< [W/(m3 sr)]
inline constexpr MediumQuantity kAnisotropy{"anisotropy", -0.999, 0.999, "between -0.999 and 0.999"};  ///< g
inline constexpr MediumQuantity kAlbedo{"albedo", 0, 1, "between 0 and 1"};                            ///< of faces

/// What of a medium varies in space, from samples on an affine grid: trilinear between them, nothing around them.
class MediumVolume {
public:
    struct Samples {
        glm::dmat3 world_from_index{1};
        glm::dvec3 origin_world{0};  ///< of sample (0, 0, 0) [m]
        glm::ivec3 size{0};
        std::vector<glm::vec3> values;  ///< per channel, x fastest
    };
    explicit MediumVolume(Samples samples);

    glm::dvec3 at(const glm::dvec3& world) const;
    bool coloured() const { return coloured_; }
    /// Moved by world = position + axes * p.
    MediumVolume moved(const glm::dvec3& position, const glm::dmat3& axes) const;

private:
    Samples samples_;
    glm::dmat3 index_from_world_;
    bool coloured_ = false;
};

/// The grid `grid` of a .vdb file, one value or three a voxel; the one that is called as the quantity when it is empty.
/// @throws Error{Input} for a damaged file, no such grid, and values that the quantity cannot have, with the voxel
MediumVolume readMediumVolume(const std::string& path, const std::string& bytes, const std::string& grid,
                              const MediumQuantity& quantity = kAbsorption);

}  // namespace photic
