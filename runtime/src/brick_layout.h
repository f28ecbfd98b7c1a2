// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "photic/volume_bytes.h"
#include "runtime/src/brick_plan.h"

namespace photic::runtime {

/// Largest sides and blocks of a GPU.
struct GpuLimits {
    int texture_3d = 2048;                                   ///< [texels]
    bool bc6h = true;                                        ///< reads such textures
    std::uint64_t storage_block = std::uint64_t{128} << 20;  ///< [bytes]
};

/// What one layout would take: its bytes, and why the GPU would not have it, or nothing.
struct LayoutNeed {
    std::uint64_t bytes = 0;
    std::string obstacle;
};

/// Where the voxels of a BrickPlan lie in a 3D texture, or one brick behind the other in a buffer. It knows nothing of
/// what a voxel holds: texels come from a `source`, called as source(first voxel, size of the box, out), which writes
/// those of a box of voxels, x fastest.
class BrickLayout {
public:
    /// @param layout  not Automatic
    /// @param blocks  to be laid out instead of voxels, which serve the plan; or null
    BrickLayout(const BrickPlan& plan, Layout layout, const Int3& period, int largest_side,
                const BlockTexels* blocks = nullptr);

    /// @param texel_bytes  of all textures together
    LayoutNeed need(std::uint64_t texel_bytes, const GpuLimits& limits) const;

    Layout layout() const { return layout_; }
    const Int3& textureSize() const { return size_; }
    /// So many layers of texels are filled at once.
    int slabDepth() const { return layout_ == Layout::Atlas ? BrickPlan::kSide : 8; }
    std::size_t slabTexels() const { return texelsOf({size_[0], size_[1], slabDepth()}); }

    /// Texels [z, z + count) of the texture; z is a multiple of slabDepth().
    template <class Texel, class Source>
    void fillSlab(int z, int count, const Source& source, Texel* out) const;

    /// Blocks of layers [z, z + count) of the texture; z is a multiple of slabDepth().
    /// @param of  those of the textures that a file has: BlockTexels::flux or colour
    void fillBlocks(int z, int count, const std::vector<unsigned char>& of, unsigned char* out) const;
    std::size_t blockLayerBytes() const {
        return BlockTexels::blocksIn(size_[0]) * BlockTexels::blocksIn(size_[1]) * BlockTexels::kBlockBytes;
    }

    /// The bricks of a buffer, brick 0 included: each texel `step` texels behind the one before, from `first` on.
    template <class Texel, class Source>
    void fillBuffer(std::size_t first, std::size_t step, const Source& source, Texel* out) const;

    /// The page table: for an atlas each brick's place, a byte an axis, instead of its number.
    std::vector<std::uint32_t> pageEntries() const;

    static std::size_t texelsOf(const Int3& v) {
        return static_cast<std::size_t>(v[0]) * static_cast<std::size_t>(v[1]) * static_cast<std::size_t>(v[2]);
    }

private:
    template <class Texel, class Source>
    static void fill(const BrickPlan::Brick& brick, const Source& source, Texel* out);

    const BrickPlan& plan_;
    Layout layout_;
    const BlockTexels* blocks_;
    Int3 atlas_{0, 0, 0};  ///< bricks along each axis
    Int3 size_{1, 1, 1};   ///< of the texture [texels]
};

template <class Texel, class Source>
void BrickLayout::fill(const BrickPlan::Brick& brick, const Source& source, Texel* out) {
    constexpr int kSide = BrickPlan::kSide;
    const Int3 first = {8 * brick.page[0], 8 * brick.page[1], 8 * brick.page[2]};
    if (brick.step == 1) return source(first, Int3{kSide, kSide, kSide}, out);
    constexpr std::size_t kWide = 2 * kSide - 1;
    std::vector<Texel> all(kWide * kWide * kWide);
    source(first, Int3{kWide, kWide, kWide}, all.data());
    for (std::size_t z = 0; z < kWide; z += 2) {
        for (std::size_t y = 0; y < kWide; y += 2) {
            for (std::size_t x = 0; x < kWide; x += 2) *out++ = all[(z * kWide + y) * kWide + x];
        }
    }
}

template <class Texel, class Source>
void BrickLayout::fillSlab(int z, int count, const Source& source, Texel* out) const {
    if (layout_ == Layout::Dense) {
        source(Int3{plan_.cell_min[0], plan_.cell_min[1], plan_.cell_min[2] + z}, Int3{size_[0], size_[1], count}, out);
        return;
    }
    constexpr int kSide = BrickPlan::kSide;
    std::fill_n(out, slabTexels(), Texel{});
    std::vector<Texel> brick(BrickPlan::kVoxels);
    for (int by = 0; by < atlas_[1]; ++by) {
        for (int bx = 0; bx < atlas_[0]; ++bx) {
            const std::size_t number = texelsOf({atlas_[0], atlas_[1], z / kSide}) +
                                       static_cast<std::size_t>(by) * static_cast<std::size_t>(atlas_[0]) +
                                       static_cast<std::size_t>(bx);
            if (number == 0 || number >= plan_.brickCount()) continue;
            fill(plan_.bricks[number - 1], source, brick.data());
            for (int row = 0; row < kSide * kSide; ++row) {
                const int layer = row / kSide, line = by * kSide + row % kSide;
                const std::size_t to = texelsOf({size_[0], size_[1], layer}) +
                                       static_cast<std::size_t>(line) * static_cast<std::size_t>(size_[0]) +
                                       static_cast<std::size_t>(bx * kSide);
                std::copy_n(brick.data() + row * kSide, kSide, out + to);
            }
        }
    }
}

template <class Texel, class Source>
void BrickLayout::fillBuffer(std::size_t first, std::size_t step, const Source& source, Texel* out) const {
    std::vector<Texel> brick(BrickPlan::kVoxels);
    for (std::size_t number = 1; number < plan_.brickCount(); ++number) {
        fill(plan_.bricks[number - 1], source, brick.data());
        Texel* to = out + number * BrickPlan::kVoxels * step + first;
        for (std::size_t v = 0; v < BrickPlan::kVoxels; ++v) to[v * step] = brick[v];
    }
}

/// The layouts to try, best first.
std::vector<Layout> candidateLayouts(Layout wanted, const BrickPlan& plan);
const char* nameOf(Layout layout);

}  // namespace photic::runtime
