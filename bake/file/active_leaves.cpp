// SPDX-License-Identifier: Apache-2.0
#include "bake/file/active_leaves.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <iterator>

#include "bake/field/needed_voxels.h"
#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

constexpr int kVoxels = LightField::kLeafVoxels;

// Voxels of a leaf with more than `threshold`, among those needed.
NeededVoxels::Mask above(const LightField& field, const LightField* second, int slot, float threshold) {
    NeededVoxels::Mask mask{};
    const bool two = second != nullptr && second->state(slot) != LeafState::Empty;
    if (!two && field.state(slot) == LeafState::Empty) return mask;
    std::array<float, kVoxels> mean{}, other;
    if (field.state(slot) != LeafState::Empty) meanIrradiance(field, slot, mean.data());
    if (two) {
        meanIrradiance(*second, slot, other.data());
        for (std::size_t i = 0; i < kVoxels; ++i) mean[i] += other[i];
    }
    const auto& needed = field.needed().mask(slot);
    for (std::size_t word = 0; word < 8; ++word) {
        std::uint64_t bits = 0;
        for (std::size_t i = 0; i < 64; ++i) bits |= std::uint64_t{mean[word * 64 + i] > threshold} << i;
        mask[word] = bits & needed[word];
    }
    return mask;
}

std::int64_t bitsIn(const NeededVoxels::Mask& mask) {
    std::int64_t n = 0;
    for (const auto word : mask) n += std::popcount(word);
    return n;
}

}  // namespace

std::int64_t ActiveLeaf::count() const { return bitsIn(mask); }

void meanIrradiance(const LightField& field, int slot, float* mean) {
    const int colours = field.channels().irradiance;
    if (field.state(slot) == LeafState::Constant) {
        float sum = 0;
        for (int c = 0; c < colours; ++c) sum += field.constant(slot)[static_cast<std::size_t>(c)];
        std::fill_n(mean, kVoxels, sum / static_cast<float>(colours));
    } else if (colours == 1) {
        std::memcpy(mean, field.dense(slot), kVoxels * sizeof(float));
    } else {
        const float *r = field.dense(slot), *g = r + kVoxels, *b = g + kVoxels;
        for (int i = 0; i < kVoxels; ++i) mean[i] = (r[i] + g[i] + b[i]) * (1.0f / 3);
    }
}

std::vector<ActiveLeaf> activeLeaves(const LightVolume& volume, ActiveBy by) {
    const LightField& field = volume.field;
    const LightField* second = volume.second ? &*volume.second : nullptr;
    std::vector<NeededVoxels::Mask> masks(static_cast<std::size_t>(field.leafCount()));
    const auto threshold = static_cast<float>(double(format::kActiveAbove) * volume.reference_irradiance);
    forEachLeaf(field.needed(),
                [&](int slot) { masks[static_cast<std::size_t>(slot)] = above(field, second, slot, threshold); });

    // Density may reach where no light does.
    std::vector<ActiveLeaf> leaves;
    if (const auto density = volume.scalars.find(format::kDensity);
        by == ActiveBy::LightOrMedium && density != volume.scalars.end()) {
        const LightField& medium = density->second;
        for (int slot = 0; slot < medium.leafCount(); ++slot) {
            if (!medium.needed().inTile(slot)) continue;
            const auto mask = above(medium, nullptr, slot, format::kActiveAbove);
            if (bitsIn(mask) == 0) continue;
            const int at = field.needed().slotOf(medium.needed().leafOrigin(slot));
            if (at < 0)
                leaves.push_back({medium.needed().leafOrigin(slot), -1, mask});
            else
                for (std::size_t w = 0; w < 8; ++w) masks[static_cast<std::size_t>(at)][w] |= mask[w];
        }
    }
    for (int slot = 0; slot < field.leafCount(); ++slot)
        if (field.needed().inTile(slot) && bitsIn(masks[static_cast<std::size_t>(slot)]) > 0)
            leaves.push_back({field.needed().leafOrigin(slot), slot, masks[static_cast<std::size_t>(slot)]});
    if (leaves.empty()) {
        const glm::ivec3 voxel = field.needed().tile().min;
        NeededVoxels::Mask one{};
        const int offset = NeededVoxels::offsetInLeaf(voxel);
        one[static_cast<std::size_t>(offset >> 6)] = std::uint64_t{1} << (offset & 63);
        leaves.push_back({glm::ivec3(voxel.x & ~7, voxel.y & ~7, voxel.z & ~7), field.needed().slotOf(voxel), one});
    }
    return leaves;
}

std::vector<ActiveLeaf> secondLobeLeaves(const LightVolume& volume, const std::vector<ActiveLeaf>& leaves) {
    std::vector<ActiveLeaf> second;
    if (volume.second)
        std::copy_if(leaves.begin(), leaves.end(), std::back_inserter(second), [&](const ActiveLeaf& leaf) {
            return leaf.slot >= 0 && volume.second->state(leaf.slot) != LeafState::Empty;
        });
    return second;
}

}  // namespace photic
