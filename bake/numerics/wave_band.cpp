// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/wave_band.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr std::size_t kChunkItems = 64;
constexpr std::align_val_t kAlignment{64};

struct Release {
    void operator()(float* p) const { ::operator delete[](p, kAlignment); }
};

}  // namespace

int WaveGrid::neighbour(int block, int side) const {
    glm::ivec3 b = place(block);
    const int axis = side >> 1;
    b[axis] += (side & 1) != 0 ? 1 : -1;
    if (b[axis] < 0 || b[axis] >= blocks[axis]) {
        if (!periodic[static_cast<std::size_t>(axis)]) return -1;
        b[axis] = (b[axis] + blocks[axis]) % blocks[axis];
    }
    const int other = index(b);
    return has(other) ? other : -1;
}

/// Items of one size from chunks that are kept until the end.
struct WaveBand::Pool {
    explicit Pool(int fields) : floats(static_cast<std::size_t>(fields) * kWaveCells) {}
    float* take() {
        if (free.empty()) {
            chunks.emplace_back(static_cast<float*>(::operator new[](floats* kChunkItems * sizeof(float), kAlignment)));
            for (std::size_t i = kChunkItems; i-- > 0;) free.push_back(chunks.back().get() + i * floats);
        }
        float* item = free.back();
        free.pop_back();
        ++used;
        return item;
    }
    void give(float* item) {
        free.push_back(item);
        --used;
    }
    std::size_t floats, used = 0;
    std::vector<std::unique_ptr<float[], Release>> chunks;
    std::vector<float*> free;
};

WaveBand::WaveBand(const WaveGrid& grid, int sum_channels, std::vector<std::uint8_t> wanted,
                   std::vector<std::uint8_t> memory_fields, std::function<void(int block, float* speed2)> speed2)
    : grid_(grid),
      wanted_(std::move(wanted)),
      memory_fields_(std::move(memory_fields)),
      speed2_(std::move(speed2)),
      number_(static_cast<std::size_t>(grid.count()), -1) {
    for (const int fields : {speed2_ ? 3 : 2, sum_channels, 2, 4, 6}) pools_.push_back(std::make_unique<Pool>(fields));
    if (sum_channels == 0) wanted_.clear();
}

WaveBand::~WaveBand() = default;

void WaveBand::become(const std::vector<int>& blocks, const std::function<void(const WaveActive&)>& retire) {
    const auto memoryPool = [&](int block) -> Pool* {
        if (memory_fields_.empty()) return nullptr;
        const std::size_t fields = memory_fields_[static_cast<std::size_t>(block)];
        return fields == 0 ? nullptr : pools_[1 + fields / 2].get();
    };
    // What goes.
    std::vector<WaveActive> old;
    old.swap(active_);
    for (const WaveActive& a : old) {
        if (std::binary_search(blocks.begin(), blocks.end(), a.block)) continue;
        retire(a);
        number_[static_cast<std::size_t>(a.block)] = -1;
        pools_[0]->give(a.field);
        if (a.sums) pools_[1]->give(a.sums);
        if (a.memory) memoryPool(a.block)->give(a.memory);
    }
    // What stays and what comes.
    std::vector<std::uint8_t> fresh(blocks.size());
    active_.resize(blocks.size());
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        const auto block = static_cast<std::size_t>(blocks[i]);
        if (number_[block] >= 0) {
            active_[i] = old[static_cast<std::size_t>(number_[block])];
        } else {
            WaveActive& a = active_[i] = {blocks[i]};
            a.field = pools_[0]->take();
            if (speed2_) a.speed2 = a.field + 2 * kWaveCells;
            if (!wanted_.empty() && wanted_[block]) a.sums = pools_[1]->take();
            if (Pool* pool = memoryPool(a.block)) a.memory = pool->take();
            fresh[i] = 1;
        }
        number_[block] = static_cast<std::int32_t>(i);
    }
    parallelFor(static_cast<std::int64_t>(blocks.size()), [&](std::int64_t n) {
        WaveActive& a = active_[static_cast<std::size_t>(n)];
        if (fresh[static_cast<std::size_t>(n)]) {
            std::memset(a.field, 0, 2 * kWaveCells * sizeof(float));
            if (a.speed2) speed2_(a.block, a.speed2);
            if (a.sums) std::memset(a.sums, 0, pools_[1]->floats * sizeof(float));
            if (a.memory) std::memset(a.memory, 0, memoryPool(a.block)->floats * sizeof(float));
        }
        for (int side = 0; side < 6; ++side) {
            const int other = grid_.neighbour(a.block, side);
            a.neighbour[static_cast<std::size_t>(side)] = other < 0 ? -1 : number_[static_cast<std::size_t>(other)];
        }
    });
    peak_bytes_ = std::max(peak_bytes_, bytes());
    peak_blocks_ = std::max(peak_blocks_, active_.size());
}

std::int64_t WaveBand::bytes() const {
    std::size_t total = 0;
    for (const auto& pool : pools_) total += pool->used * pool->floats * sizeof(float);
    return static_cast<std::int64_t>(total);
}

}  // namespace photic
