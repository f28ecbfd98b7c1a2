// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/medium_volume.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include "bake/report/error.h"
#include "bake/scene/vdb_voxels.h"
#include "bake/volume/byte_cursor.h"

namespace photic {
namespace {

constexpr double kMostVoxels = 134217728.0;  // 2^27: 1.5 GiB of samples

std::size_t flat(const glm::ivec3& size, const glm::ivec3& p) {
    return (static_cast<std::size_t>(p.z) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(p.y)) *
               static_cast<std::size_t>(size.x) +
           static_cast<std::size_t>(p.x);
}

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
    throw Error(ErrorCode::Input, fmt::format("cannot read the volume '{}': {}", path, why));
}

const VdbGrid& gridNamed(const std::string& path, const std::vector<VdbGrid>& grids, const std::string& name) {
    std::vector<std::string> names;
    for (const VdbGrid& grid : grids) {
        if (grid.name == name && grid.components > 0) return grid;
        names.push_back(fmt::format("{} ({})", grid.name, grid.type));
    }
    refuse(path, fmt::format("it has no grid '{}' of floats or of three; it holds {}", name,
                             names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
}

}  // namespace

MediumVolume::MediumVolume(Samples samples)
    : samples_(std::move(samples)),
      index_from_world_(glm::inverse(samples_.world_from_index)),
      coloured_(std::any_of(samples_.values.begin(), samples_.values.end(),
                            [](const glm::vec3& v) { return v.x != v.y || v.y != v.z; })) {}

glm::dvec3 MediumVolume::at(const glm::dvec3& world) const {
    const glm::dvec3 p = index_from_world_ * (world - samples_.origin_world), low = glm::floor(p), t = p - low;
    for (int a = 0; a < 3; ++a)
        if (!(p[a] > -1 && p[a] < samples_.size[a])) return glm::dvec3(0);
    const glm::ivec3 first(low);
    glm::dvec3 sum(0);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 step(corner & 1, corner >> 1 & 1, corner >> 2), at = first + step;
        bool there = true;
        double weight = 1;
        for (int a = 0; a < 3; ++a)
            there = there && at[a] >= 0 && at[a] < samples_.size[a], weight *= step[a] ? t[a] : 1 - t[a];
        if (there) sum += weight * glm::dvec3(samples_.values[flat(samples_.size, at)]);
    }
    return sum;
}

MediumVolume MediumVolume::moved(const glm::dvec3& position, const glm::dmat3& axes) const {
    Samples samples = samples_;
    samples.world_from_index = axes * samples_.world_from_index;
    samples.origin_world = position + axes * samples_.origin_world;
    return MediumVolume(std::move(samples));
}

MediumVolume readMediumVolume(const std::string& path, const std::string& bytes, const std::string& name,
                              const MediumQuantity& quantity) {
    try {
        const VdbFile file = parseVdb(bytes.data(), bytes.size());
        const VdbGrid& grid = gridNamed(path, file.grids, name.empty() ? quantity.name : name);
        if (!grid.transform) refuse(path, "it has a perspective transform; resample it to a linear one");
        glm::ivec3 min, max;
        if (!grid.activeBox(min, max)) refuse(path, fmt::format("grid {} has no active voxel", grid.name));
        MediumVolume::Samples samples;
        samples.size = max - min + 1;
        if (double(samples.size.x) * samples.size.y * samples.size.z > kMostVoxels)
            refuse(path, fmt::format("grid {} spans {} x {} x {} voxels, more than 2^27; crop or coarsen it", grid.name,
                                     samples.size.x, samples.size.y, samples.size.z));
        samples.world_from_index = grid.transform->world_from_index;
        samples.origin_world = grid.transform->origin_world + samples.world_from_index * glm::dvec3(min);
        samples.values.assign(flat(samples.size, {0, 0, samples.size.z}), glm::vec3(0));
        forEachActiveVoxel(grid, [&](const glm::ivec3& voxel, const float* values) {
            glm::vec3 value;
            for (int c = 0; c < 3; ++c) {
                value[c] = values[grid.components == 3 ? c : 0];
                const double v = double(value[c]);
                if (!(v >= quantity.least && v <= quantity.most))
                    refuse(path, fmt::format("voxel ({}, {}, {}) of grid {} is {}; {} is {}", voxel.x, voxel.y, voxel.z,
                                             grid.name, value[c], quantity.name, quantity.limits));
            }
            samples.values[flat(samples.size, voxel - min)] = value;
        });
        return MediumVolume(std::move(samples));
    } catch (const VolumeFault& fault) {
        refuse(path, fault.what());
    } catch (const std::bad_alloc&) {
        refuse(path, "it is larger than memory");
    }
}

}  // namespace photic
