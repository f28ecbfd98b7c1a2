// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace photic {

/// Absorption that varies in space [1/m], from samples on an affine grid: trilinear between them, nothing around them.
class AbsorptionVolume {
public:
    struct Samples {
        glm::dmat3 world_from_index{1};
        glm::dvec3 origin_world{0};  ///< of sample (0, 0, 0) [m]
        glm::ivec3 size{0};
        std::vector<glm::vec3> values;  ///< per channel, x fastest
    };
    explicit AbsorptionVolume(Samples samples);

    glm::dvec3 at(const glm::dvec3& world) const;
    bool coloured() const { return coloured_; }
    /// Moved by world = position + axes * p.
    AbsorptionVolume moved(const glm::dvec3& position, const glm::dmat3& axes) const;

private:
    Samples samples_;
    glm::dmat3 index_from_world_;
    bool coloured_ = false;
};

/// The grid `grid` of a .vdb file, one value or three a voxel; the one that is called absorption when it is empty.
/// @throws Error{Input} for a damaged file, no such grid, and values below 0 or not finite, with the voxel
AbsorptionVolume readAbsorptionVolume(const std::string& path, const std::string& bytes, const std::string& grid);

}  // namespace photic
