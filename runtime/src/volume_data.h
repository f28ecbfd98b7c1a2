// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "photic/runtime.h"
#include "runtime/src/block_texels.h"
#include "runtime/src/half_float.h"

namespace photic::runtime {

using Int3 = std::array<int, 3>;
using Double3 = std::array<double, 3>;
using Matrix3 = std::array<double, 9>;  ///< by rows

inline Double3 multiply(const Matrix3& m, const Double3& v) {
    return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
            m[6] * v[0] + m[7] * v[1] + m[8] * v[2]};
}

/// Index to world: world = matrix * index + origin; voxel (i, j, k) is centred at that of (i, j, k).
struct VoxelTransform {
    Matrix3 world_from_index{1, 0, 0, 0, 1, 0, 0, 0, 1}, index_from_world{1, 0, 0, 0, 1, 0, 0, 0, 1};
    Double3 origin_world{0, 0, 0};

    Double3 indexOf(const Double3& world) const {
        return multiply(index_from_world,
                        {world[0] - origin_world[0], world[1] - origin_world[1], world[2] - origin_world[2]});
    }
};

/// Checks `world_from_index` and `origin_world` and sets `index_from_world`.
/// @param what  names the file or the grid in errors
/// @throws Failure{Format} for a transform that is not finite, has no inverse, or has voxels too small to be any
void finishTransform(VoxelTransform& transform, const std::string& what);

/// Quotient rounded down; b > 0.
inline int floorDivide(int a, int b) { return a / b - (a % b < 0); }
inline int floorModulo(int a, int b) { return a - b * floorDivide(a, b); }

/// Which blocks of 16^3 voxels are smooth: Metadata::coarse_blocks.
struct CoarseBlocks {
    Int3 min{0, 0, 0}, count{0, 0, 0};  ///< [blocks]
    std::vector<bool> marks;            ///< x fastest; empty: none

    /// @throws Failure{Format}
    static CoarseBlocks of(const std::string& text);
    /// Takes the marks off blocks that read voxels below `first` or beyond `last` along an axis.
    void keepWithin(std::size_t axis, int first, int last);
    bool has(const Int3& block) const;
};

/// What a Volume holds. Values are in units of the reference irradiance.
struct VolumeData {
    static constexpr int kSide = 8;      ///< voxels along a brick's edge
    static constexpr int kVoxels = 512;  ///< of a brick

    VoxelTransform transform;
    Metadata metadata;
    bool coloured = false, has_direction = true;
    std::uint64_t repaired_values = 0;

    Int3 brick_min{0, 0, 0};               ///< the box of bricks begins at voxel 8 * brick_min
    Int3 brick_count{0, 0, 0};             ///< and has so many; pages.size() is their product
    std::vector<std::uint32_t> pages;      ///< x fastest: the brick's number; 0 is darkness
    std::vector<Half4> light;              ///< 512 per brick, x fastest, beginning with brick 0: flux.xyz, irradiance
    std::vector<std::array<Half, 3>> rgb;  ///< irradiance per channel, likewise; empty when not coloured

    std::shared_ptr<const BlockTexels> blocks;  ///< the same light as a GPU takes it compressed, or null

    /// Light that travels against the rest where light opposes itself: a volume of its own, or null. All light is the
    /// sum of both.
    std::shared_ptr<const VolumeData> second;

    Int3 lit_min{0, 0, 0}, lit_max{-1, -1, -1};  ///< voxels around all that is not dark
    std::uint64_t lit_voxels = 0;
    Int3 period{0, 0, 0};  ///< [voxels], from lit_min on; 0 along axes that do not repeat
    CoarseBlocks coarse;   ///< where the light repeats, those that read one period, its end included

    std::uint32_t brickCount() const { return static_cast<std::uint32_t>(light.size() / kVoxels); }

    /// Brick number of the page at (x, y, z) in bricks, absolute; 0 outside the box.
    std::uint32_t page(int x, int y, int z) const {
        x -= brick_min[0], y -= brick_min[1], z -= brick_min[2];
        if (static_cast<unsigned>(x) >= static_cast<unsigned>(brick_count[0]) ||
            static_cast<unsigned>(y) >= static_cast<unsigned>(brick_count[1]) ||
            static_cast<unsigned>(z) >= static_cast<unsigned>(brick_count[2])) {
            return 0;
        }
        const auto nx = static_cast<std::size_t>(brick_count[0]), ny = static_cast<std::size_t>(brick_count[1]);
        return pages[(static_cast<std::size_t>(z) * ny + static_cast<std::size_t>(y)) * nx +
                     static_cast<std::size_t>(x)];
    }

    /// The voxel along `axis` that stands for `v` when the light repeats.
    int wrapped(int v, int axis) const {
        const auto a = static_cast<std::size_t>(axis);
        return period[a] == 0 ? v : lit_min[a] + floorModulo(v - lit_min[a], period[a]);
    }

    /// Where voxel (x, y, z) lies in `light` and `rgb`, wrapped; inside brick 0 when it is dark.
    std::size_t slot(int x, int y, int z) const {
        x = wrapped(x, 0), y = wrapped(y, 1), z = wrapped(z, 2);
        const std::size_t brick = page(x >> 3, y >> 3, z >> 3);
        return brick * kVoxels + static_cast<std::size_t>((x & 7) + 8 * (y & 7) + 64 * (z & 7));
    }
};

/// What part of its fluence rate a surface gets: max(0, -normal . flux) / mean, the normal made unit.
inline double towards(const Vec3& normal, const Double3& flux, double mean) {
    const double length = std::sqrt(normal.x * normal.x + normal.y * normal.y + normal.z * normal.z);
    const double along = -(normal.x * flux[0] + normal.y * flux[1] + normal.z * flux[2]);
    return along > 0 && mean > 0 && length > 0 ? along / (mean * length) : 0;
}

/// Finds lit_min, lit_max and lit_voxels, the period in voxels from that of the metadata in metres, and the water's
/// surface where the metadata do not know it.
/// @throws Failure{Format} when the period is no whole number of voxels along one of the grid's axes
void finishVolume(VolumeData& data);

/// Largest index of a voxel, either side of 0: keeps sums of indices far from overflowing.
inline constexpr int kLargestIndex = 1 << 28;

}  // namespace photic::runtime
