// SPDX-License-Identifier: Apache-2.0
#include "bake/file/voxel_box.h"

#include <glm/common.hpp>
#include <limits>
#include <vector>

#include "bake/field/needed_voxels.h"
#include "bake/field/resample.h"
#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

double threshold(const LightVolume& volume) { return double(format::kActiveAbove) * volume.reference_irradiance; }

// The box of voxels with light.
std::optional<VoxelBox> litBoxOf(const LightField& field, double threshold) {
    const VoxelBox none{glm::ivec3(std::numeric_limits<int>::max()), glm::ivec3(std::numeric_limits<int>::min())};
    std::vector<VoxelBox> boxes(static_cast<std::size_t>(field.leafCount()), none);
    forEachLeaf(field.needed(), [&](int slot) {
        if (field.state(slot) == LeafState::Empty) return;
        VoxelBox& box = boxes[static_cast<std::size_t>(slot)];
        const glm::ivec3 origin = field.needed().leafOrigin(slot);
        for (int i = 0; i < LightField::kLeafVoxels; ++i) {
            const glm::ivec3 v = origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            if (field.irradiance(v) > threshold) box.min = glm::min(box.min, v), box.max = glm::max(box.max, v);
        }
    });
    VoxelBox all = none;
    for (const VoxelBox& box : boxes) all.min = glm::min(all.min, box.min), all.max = glm::max(all.max, box.max);
    if (all.min.x > all.max.x) return {};
    return all;
}

}  // namespace

StraightField::StraightField(const LightVolume& volume) : volume_(volume) {
    if (volume.field.frame().axisAligned()) return;
    resampled_ = resampledToAxes(volume.field);
    if (volume.second) resampled_second_ = resampledToAxes(*volume.second);
}

VoxelBox StraightField::box(const std::optional<VoxelBox>& wanted) const {
    std::optional<VoxelBox> lit = wanted;
    if (!lit) lit = litBoxOf(field(), threshold(volume_));
    if (!wanted && second() != nullptr) lit = together(lit, litBoxOf(*second(), threshold(volume_)));
    const glm::ivec3 corner = field().frame().min;
    return lit.value_or(VoxelBox{corner, corner});
}

std::optional<VoxelBox> litBox(const LightVolume& volume) {
    const StraightField straight(volume);
    const std::optional<VoxelBox> lit = litBoxOf(straight.field(), threshold(volume));
    return straight.second() ? together(lit, litBoxOf(*straight.second(), threshold(volume))) : lit;
}

std::optional<VoxelBox> together(const std::optional<VoxelBox>& a, const std::optional<VoxelBox>& b) {
    if (!a || !b) return a ? a : b;
    return VoxelBox{glm::min(a->min, b->min), glm::max(a->max, b->max)};
}

}  // namespace photic
