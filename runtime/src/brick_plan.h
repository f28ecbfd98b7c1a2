// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/src/volume_data.h"

namespace photic::runtime {

/// How a volume is cut into bricks that a GPU can filter by itself: 8^3 voxels and one more on the far side of each
/// axis, so that the eight voxels around any point lie in one brick.
///
/// A cell is a voxel and the space up to the next one along each axis. Cells of a page (8^3 of them) read one brick.
/// Pages with nothing to read share brick 0, which is dark; pages of one value share a brick. A page whose own voxels
/// are dark still has a brick when a neighbour lights its far side: without it seams would show.
///
/// Pages of a block of 2^3 that the volume marks as smooth share one brick of every second voxel, whose light in
/// between is that of its own filter.
struct BrickPlan {
    static constexpr int kSide = 9, kVoxels = 729;

    /// What a brick is filled from: the voxels from 8 page on, every one, or every second.
    struct Brick {
        Int3 page;
        int step = 1;
    };

    Int3 page_min{0, 0, 0}, page_count{0, 0, 0};   ///< [pages], absolute
    Int3 cell_min{0, 0, 0}, cell_max{-1, -1, -1};  ///< cells that may be lit, both inside; others are dark
    /// x fastest: the brick's number, and kCoarse where that has every second voxel; for brick 0, how far the dark
    /// reaches is in the top byte: all pages less than so many steps away along every axis are dark too.
    std::vector<std::uint32_t> entries;
    std::vector<Brick> bricks;  ///< number 1, 2, ...
    std::uint32_t coarse = 0;   ///< of them, those of every second voxel

    static constexpr std::uint32_t kNumberMask = 0xffffffU;
    static constexpr int kDistanceShift = 24;
    static constexpr std::uint32_t kCoarse = 1U << 24;

    std::uint32_t brickCount() const { return static_cast<std::uint32_t>(bricks.size()) + 1; }
    /// Part of the box of cells whose pages have bricks of their own.
    double fill() const;
};

/// @param largest_table  of entries [bytes]
/// @throws Failure{Limit} when the box has more pages than fit that, or than entries can number
BrickPlan planBricks(const VolumeData& data, std::uint64_t largest_table = ~std::uint64_t{0});

/// The 9^3 voxels that begin at the first of `page`, x fastest.
/// @param rgb  null when the volume is not coloured; the fourth component is set to 0
void fillBrick(const VolumeData& data, const Int3& page, Half4* light, Half4* rgb);

enum class Repeats { Followed, Ignored };

/// One box of voxels, x fastest; of what is null nothing is written.
void fillBox(const VolumeData& data, const Int3& min, const Int3& size, Half4* light, Half4* rgb,
             Repeats repeats = Repeats::Followed);

/// The volume with voxels twice as wide, each the mean of eight.
/// @throws Failure{Limit} when the light repeats after an odd number of voxels, or from an odd one on
Volume halfResolution(const VolumeData& data);

}  // namespace photic::runtime
