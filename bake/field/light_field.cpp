// SPDX-License-Identifier: Apache-2.0
#include "bake/field/light_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <new>

#include "bake/field/leaf_arena.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {

struct LightField::Arena {
    Arena(FieldChannels channels, std::int64_t max_leaves)
        : leaves(static_cast<std::size_t>(channels.count()) * kLeafVoxels * sizeof(float), max_leaves),
          constants((static_cast<std::size_t>(channels.count()) * sizeof(float) + 63) / 64 * 64,
                    std::min<std::int64_t>(max_leaves, 1024)) {}
    LeafArena leaves, constants;
};

LightField::LightField(std::shared_ptr<const NeededVoxels> needed, FieldChannels channels)
    : needed_(std::move(needed)), channels_(channels) {
    const auto count = static_cast<std::size_t>(needed_->leafCount());
    try {
        states_.assign(count, LeafState::Empty);
        data_.assign(count, nullptr);
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::Failed,
                    fmt::format("out of memory: the table of {} blocks of 8^3 voxels needs {} MiB; use larger "
                                "voxels or a smaller domain",
                                count, (count * 9) >> 20));
    }
    arena_ = std::make_unique<Arena>(channels, needed_->leafCount());
}

LightField::~LightField() = default;
LightField::LightField(LightField&&) noexcept = default;
LightField& LightField::operator=(LightField&&) noexcept = default;

float* LightField::makeDenseUninitialised(int slot, bool& was_empty) {
    const auto s = static_cast<std::size_t>(slot);
    was_empty = states_[s] == LeafState::Empty;
    if (!was_empty) return makeDense(slot);
    bool zeroed = false;
    data_[s] = static_cast<float*>(arena_->leaves.allocate(zeroed));
    states_[s] = LeafState::Dense;
    return data_[s];
}

float* LightField::makeDense(int slot) {
    const auto s = static_cast<std::size_t>(slot);
    if (states_[s] == LeafState::Dense) return data_[s];
    const auto count = static_cast<std::size_t>(channels_.count());
    bool zeroed = false;
    auto* leaf = static_cast<float*>(arena_->leaves.allocate(zeroed));
    if (states_[s] == LeafState::Constant) {
        for (std::size_t c = 0; c < count; ++c) std::fill_n(leaf + c * kLeafVoxels, kLeafVoxels, data_[s][c]);
        arena_->constants.release(data_[s]);
    } else if (!zeroed) {
        std::memset(leaf, 0, count * kLeafVoxels * sizeof(float));
    }
    data_[s] = leaf;
    states_[s] = LeafState::Dense;
    return leaf;
}

void LightField::setConstant(int slot, std::span<const float> values) {
    const auto s = static_cast<std::size_t>(slot);
    if (states_[s] != LeafState::Constant) {
        setEmpty(slot);
        bool zeroed = false;
        data_[s] = static_cast<float*>(arena_->constants.allocate(zeroed));
        states_[s] = LeafState::Constant;
    }
    std::copy_n(values.begin(), channels_.count(), data_[s]);
}

void LightField::setEmpty(int slot) {
    const auto s = static_cast<std::size_t>(slot);
    if (states_[s] == LeafState::Dense) arena_->leaves.release(data_[s]);
    if (states_[s] == LeafState::Constant) arena_->constants.release(data_[s]);
    data_[s] = nullptr;
    states_[s] = LeafState::Empty;
}

float LightField::value(const glm::ivec3& voxel, int channel) const {
    const int slot = needed_->slotOf(voxel);
    if (slot < 0) return 0;
    const int offset = NeededVoxels::offsetInLeaf(voxel);
    if (!NeededVoxels::maskBit(needed_->mask(slot), offset)) return 0;
    switch (state(slot)) {
        case LeafState::Empty:
            return 0;
        case LeafState::Constant:
            return data_[static_cast<std::size_t>(slot)][channel];
        case LeafState::Dense:
            break;
    }
    return data_[static_cast<std::size_t>(slot)][channel * kLeafVoxels + offset];
}

double LightField::irradiance(const glm::ivec3& voxel) const {
    double sum = 0;
    for (int c = 0; c < channels_.irradiance; ++c) sum += double(value(voxel, c));
    return sum / channels_.irradiance;
}

glm::dvec3 LightField::flux(const glm::ivec3& voxel) const {
    if (!channels_.flux) return glm::dvec3(0);
    const int c = channels_.irradiance;
    return {value(voxel, c), value(voxel, c + 1), value(voxel, c + 2)};
}

std::int64_t LightField::bytes() const {
    return arena_->leaves.bytes() + arena_->constants.bytes() + needed_->bytes() +
           static_cast<std::int64_t>(states_.capacity() * sizeof(LeafState) + data_.capacity() * sizeof(float*));
}

double LightField::sumOf(int channel, bool beside_tile) const {
    const auto leafSum = [&](int slot) {
        if (state(slot) == LeafState::Empty || needed_->inTile(slot) == beside_tile) return 0.0;
        const auto& mask = needed_->mask(slot);
        const float* data = data_[static_cast<std::size_t>(slot)];
        if (state(slot) == LeafState::Constant) {
            int bits = 0;
            for (const auto word : mask) bits += std::popcount(word);
            return double(data[channel]) * bits;
        }
        data += channel * kLeafVoxels;
        double sum = 0;
        if (needed_->leafFull(slot)) {
            // Eight partial sums in a fixed order: vectorises, and is the same everywhere.
            double part[8] = {};
            for (int i = 0; i < kLeafVoxels; i += 8)
                for (int k = 0; k < 8; ++k) part[k] += double(data[i + k]);
            for (const double p : part) sum += p;
        } else {
            for (int i = 0; i < kLeafVoxels; ++i)
                if (NeededVoxels::maskBit(mask, i)) sum += double(data[i]);
        }
        return sum;
    };
    // Blocks of leaves in parallel, then added in order: the same for any number of threads.
    constexpr int kBlock = 256;
    const int blocks = (leafCount() + kBlock - 1) / kBlock;
    std::vector<double> sums(static_cast<std::size_t>(blocks));
    parallelFor(blocks, [&](std::int64_t b) {
        double sum = 0;
        const int end = std::min<std::int64_t>((b + 1) * kBlock, leafCount());
        for (int slot = int(b) * kBlock; slot < end; ++slot) sum += leafSum(slot);
        sums[static_cast<std::size_t>(b)] = sum;
    });
    double total = 0;
    for (const double s : sums) total += s;
    return total;
}

}  // namespace photic
