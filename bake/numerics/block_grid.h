// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace photic {

/// A box of cells held in blocks of 8^3, of which only some exist. Cell (i, j, k) has 0 <= i < 8 * blocks.x ...; a
/// block's cells are ordered x fastest: (z & 7) << 6 | (y & 7) << 3 | (x & 7). Blocks that exist are numbered by slots,
/// x fastest. Memory: 4 bytes a block of the box, 36 a block that exists.
class BlockGrid {
public:
    static constexpr int kSide = 8, kCells = 512;

    /// @param blocks  of the box, along each axis
    /// @param exists  one flag a block of the box, x fastest; empty: all exist
    explicit BlockGrid(const glm::ivec3& blocks, std::span<const std::uint8_t> exists = {});

    /// Blocks along each axis that hold `cells` cells.
    static glm::ivec3 blocksFor(const glm::ivec3& cells) { return (cells + (kSide - 1)) / kSide; }

    glm::ivec3 blocks() const { return blocks_; }
    int blockCount() const { return static_cast<int>(origins_.size()); }
    /// Cells of the blocks that exist.
    std::size_t cellCount() const { return origins_.size() * kCells; }

    /// Slot of a block of the box, -1 when it does not exist or lies outside.
    int slotAt(const glm::ivec3& block) const {
        for (int a = 0; a < 3; ++a)
            if (block[a] < 0 || block[a] >= blocks_[a]) return -1;
        return slots_[(static_cast<std::size_t>(block.z) * static_cast<std::size_t>(blocks_.y) +
                       static_cast<std::size_t>(block.y)) *
                          static_cast<std::size_t>(blocks_.x) +
                      static_cast<std::size_t>(block.x)];
    }
    /// First cell of a block.
    glm::ivec3 origin(int slot) const { return origins_[static_cast<std::size_t>(slot)]; }
    /// Slots of the blocks at -x, +x, -y, +y, -z, +z; -1 where none exists.
    const std::array<int, 6>& neighbours(int slot) const { return neighbours_[static_cast<std::size_t>(slot)]; }

    /// Where a cell's value lies in an array over all slots; -1 when its block does not exist.
    std::int64_t cellIndex(const glm::ivec3& cell) const {
        const int slot = slotAt({cell.x >> 3, cell.y >> 3, cell.z >> 3});
        return slot < 0 ? -1 : std::int64_t(slot) * kCells + ((cell.z & 7) << 6 | (cell.y & 7) << 3 | (cell.x & 7));
    }
    glm::ivec3 cellAt(std::int64_t index) const {
        const int c = static_cast<int>(index & (kCells - 1));
        return origin(static_cast<int>(index / kCells)) + glm::ivec3(c & 7, c >> 3 & 7, c >> 6);
    }
    std::int64_t bytes() const;

private:
    glm::ivec3 blocks_;
    std::vector<std::int32_t> slots_;
    std::vector<glm::ivec3> origins_;
    std::vector<std::array<int, 6>> neighbours_;
};

/// A bit for each cell of a BlockGrid: one byte a row of eight cells along x.
class CellMask {
public:
    explicit CellMask(const BlockGrid& grid) : rows_(grid.cellCount() / 8) {}
    bool get(std::int64_t cell) const { return rows_[static_cast<std::size_t>(cell >> 3)] >> (cell & 7) & 1; }
    void set(std::int64_t cell) {
        rows_[static_cast<std::size_t>(cell >> 3)] |= static_cast<std::uint8_t>(1 << (cell & 7));
    }
    void clear(std::int64_t cell) {
        rows_[static_cast<std::size_t>(cell >> 3)] &= static_cast<std::uint8_t>(~(1 << (cell & 7)));
    }
    /// The 64 rows of a block.
    const std::uint8_t* block(int slot) const { return &rows_[static_cast<std::size_t>(slot) * 64]; }
    std::uint8_t* block(int slot) { return &rows_[static_cast<std::size_t>(slot) * 64]; }

private:
    std::vector<std::uint8_t> rows_;
};

}  // namespace photic
