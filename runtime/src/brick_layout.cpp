// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/brick_layout.h"

#include <cmath>

namespace photic::runtime {
namespace {

constexpr double kDenseFill = 0.7;     // above it one dense texture is smaller and faster than bricks (measured)
constexpr int kMostBricksASide = 255;  // a byte in an entry

/// How many bricks lie along each axis of the atlas.
/// @param pitch  texels from one to the next along x and y
Int3 atlasShape(std::uint32_t bricks, int largest_side, int pitch) {
    const int most = std::clamp(largest_side / pitch, 1, kMostBricksASide);
    const auto count = static_cast<std::int64_t>(bricks);
    const auto side = static_cast<int>(std::ceil(std::cbrt(static_cast<double>(count))));
    const int x = std::min(side, most);
    const int y = std::min(static_cast<int>((count + x - 1) / x), std::min(side, most));
    return {x, y, static_cast<int>((count + std::int64_t{x} * y - 1) / (std::int64_t{x} * y))};
}

std::string tooLarge(const char* what, std::uint64_t size, std::uint64_t limit) {
    return std::string(what) + " would be " + std::to_string(size) + ", and the limit is " + std::to_string(limit);
}

/// Why a texture of this size is not to be had, or nothing.
std::string sideObstacle(const char* what, const Int3& size, int limit) {
    const int longest = *std::max_element(size.begin(), size.end());
    if (longest <= limit) return {};
    return tooLarge(what, static_cast<std::uint64_t>(longest), static_cast<std::uint64_t>(limit));
}

}  // namespace

BrickLayout::BrickLayout(const BrickPlan& plan, Layout layout, const Int3& period, int largest_side,
                         const BlockTexels* blocks)
    : plan_(plan), layout_(layout), blocks_(blocks) {
    if (layout == Layout::Dense && blocks) {
        size_ = blocks->texels;
    } else if (layout == Layout::Dense) {
        for (std::size_t a = 0; a < 3; ++a) {
            // One voxel more than cells on axes that end: the last cell reads the dark voxel beyond it.
            size_[a] = std::max(1, plan.cell_max[a] - plan.cell_min[a] + 1 + (period[a] == 0));
        }
    } else if (layout == Layout::Atlas) {
        const int pitch = blocks ? BlockTexels::kPitch : BrickPlan::kSide;
        atlas_ = atlasShape(plan.brickCount(), largest_side, pitch);
        size_ = {pitch * atlas_[0], pitch * atlas_[1], BrickPlan::kSide * atlas_[2]};
    }
}

LayoutNeed BrickLayout::need(std::uint64_t texel_bytes, const GpuLimits& limits) const {
    const std::uint64_t pages = plan_.entries.size() * sizeof(std::uint32_t);
    const std::string table = sideObstacle("the longest side of the page table", plan_.page_count, limits.texture_3d);
    if (!table.empty()) return {0, table};
    if (layout_ == Layout::Buffer) {
        const std::uint64_t bytes = std::uint64_t{plan_.brickCount()} * BrickPlan::kVoxels * texel_bytes;
        return {pages + bytes,
                bytes <= limits.storage_block ? "" : tooLarge("the bricks' bytes", bytes, limits.storage_block)};
    }
    std::string obstacle = sideObstacle("the longest side of the 3D texture", size_, limits.texture_3d);
    if (layout_ == Layout::Atlas && atlas_[2] > kMostBricksASide)
        obstacle = "there are more bricks than an atlas numbers";
    // Blocks hold whole groups of 4 x 4 texels.
    const std::uint64_t texels = blocks_ ? blockLayerBytes() * static_cast<std::uint64_t>(size_[2]) : texelsOf(size_);
    return {pages + texels * texel_bytes, std::move(obstacle)};
}

void BrickLayout::fillBlocks(int z, int count, const std::vector<unsigned char>& of, unsigned char* out) const {
    if (layout_ == Layout::Dense) {
        std::copy_n(of.data() + static_cast<std::size_t>(z) * blockLayerBytes(),
                    static_cast<std::size_t>(count) * blockLayerBytes(), out);
        return;
    }
    constexpr std::size_t kAcross = BlockTexels::kPitch / 4, kRow = kAcross * BlockTexels::kBlockBytes;
    constexpr std::size_t kLayer = kAcross * kRow;
    std::fill_n(out, static_cast<std::size_t>(count) * blockLayerBytes(), static_cast<unsigned char>(0));
    const auto nx = static_cast<std::size_t>(atlas_[0]), ny = static_cast<std::size_t>(atlas_[1]);
    const std::size_t first = nx * ny * static_cast<std::size_t>(z / BrickPlan::kSide);
    for (std::size_t number = std::max<std::size_t>(1, first); number < first + nx * ny && number < plan_.brickCount();
         ++number) {
        const BrickPlan::Brick& brick = plan_.bricks[number - 1];
        const std::size_t stored = blocks_->numbers.at({brick.page[0], brick.page[1], brick.page[2], brick.step});
        const std::size_t bx = (number - first) % nx, by = (number - first) / nx;
        for (std::size_t layer = 0; layer < static_cast<std::size_t>(count); ++layer) {
            const unsigned char* from = of.data() + (stored * BrickPlan::kSide + layer) * kLayer;
            unsigned char* to = out + layer * blockLayerBytes() + by * kLayer * nx + bx * kRow;
            for (std::size_t row = 0; row < kAcross; ++row) std::copy_n(from + row * kRow, kRow, to + row * nx * kRow);
        }
    }
}

std::vector<std::uint32_t> BrickLayout::pageEntries() const {
    std::vector<std::uint32_t> entries = plan_.entries;
    if (layout_ != Layout::Atlas) return entries;
    const auto nx = static_cast<std::uint32_t>(atlas_[0]), ny = static_cast<std::uint32_t>(atlas_[1]);
    for (std::uint32_t& entry : entries) {
        const std::uint32_t number = entry & BrickPlan::kNumberMask;
        const std::uint32_t coarse = entry & BrickPlan::kCoarse;
        if (number != 0) entry = coarse | number % nx | number / nx % ny << 8 | number / (nx * ny) << 16;
    }
    return entries;
}

std::vector<Layout> candidateLayouts(Layout wanted, const BrickPlan& plan) {
    if (wanted != Layout::Automatic) return {wanted};
    // What has two levels was made to fit in bricks.
    if (plan.fill() > kDenseFill && plan.coarse == 0) return {Layout::Dense, Layout::Atlas, Layout::Buffer};
    return {Layout::Atlas, Layout::Dense, Layout::Buffer};
}

const char* nameOf(Layout layout) {
    switch (layout) {
        case Layout::Atlas:
            return "atlas";
        case Layout::Dense:
            return "dense";
        case Layout::Buffer:
            return "buffer";
        case Layout::Automatic:
            break;
    }
    return "automatic";
}

}  // namespace photic::runtime
