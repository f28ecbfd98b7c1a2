// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "bake/file/output_set.h"

namespace photic {

/// Samples of a scene's media, to be written as a .vdb that scenes read: 32-bit floats, no light.
struct SampleVolume {
    struct Grid {
        std::string name;
        int components = 1;                          ///< 1 or 3
        const std::vector<float>* values = nullptr;  ///< a voxel's components side by side, x fastest
    };
    double voxel_size = 1;  ///< [m]; voxel (i, j, k) is centred at (i + 0.5, j + 0.5, k + 0.5) times it
    glm::ivec3 min{0}, size{0};
    std::vector<Grid> grids;
    std::function<bool(std::size_t voxel)> active;  ///< of all grids
};

/// A file of a set, which OutputSet::commit() renames. @return active voxels
std::int64_t writeSamples(OutputSet& outputs, const std::string& path, const SampleVolume& volume);

}  // namespace photic
