// SPDX-License-Identifier: Apache-2.0
// OpenVDB's file format (versions 222 and later, all that was written since
// 2013), read without OpenVDB, which believes every size that a file names: a
// damaged one makes it write past its buffers or ask for all memory.
//
// A file is a header, metadata, and grids one after the other; a grid is its
// name and type, metadata, transform, its tree's nodes from the root down (32^3
// nodes of 16^3 nodes of leaves of 8^3 voxels; a bit per entry for children and
// one for active values), and then each leaf's values.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bake/volume/half_floats.h"

namespace photic {

using VdbMetadata = std::map<std::string, std::string>;

struct VdbTransform {
    glm::dmat3 world_from_index{1.0};
    glm::dvec3 origin_world{0};
};

/// 8^3 voxels that share a node; voxel (x, y, z) at x << 6 | y << 3 | z.
struct VdbLeaf {
    glm::ivec3 origin{0};  ///< a multiple of 8
    std::uint32_t packed = 0;
    std::size_t mask = 0;    ///< place of 64 bytes in the file, a bit a voxel: it is active
    std::size_t values = 0;  ///< place of its values
    enum class Kind : std::uint8_t { AllVoxels, ActiveVoxels, Tile } kind = Kind::AllVoxels;  ///< what is stored
};

/// A cube of one value, all of it active.
struct VdbTile {
    glm::ivec3 origin{0};
    int side = 8;  ///< 8, 128 or 4096
    std::array<float, 3> value{};
};

/// A grid of floats or of vectors of three floats; others are passed over, and
/// hold nothing but their name and type.
class VdbGrid {
public:
    using Mask = std::array<std::uint64_t, 8>;
    static constexpr int kVoxels = 512;

    std::string name;
    std::string type;    ///< of its values, as OpenVDB calls it: "float", "vec3s",
                         ///< "double" ...
    int components = 0;  ///< 1 or 3; 0: passed over
    VdbMetadata metadata;
    std::optional<VdbTransform> transform;  ///< none: not linear
    std::vector<VdbLeaf> leaves;            ///< no place twice
    std::vector<VdbTile> tiles;             ///< active ones

    /// Its values are rounded to 16 bits.
    bool storedAsHalf() const { return half_; }
    /// OpenVDB's flags: kPackedZip, kPackedActive, kPackedBlosc.
    std::uint32_t compression() const { return compression_; }
    Mask mask(const VdbLeaf& leaf) const;
    /// Bytes that a leaf (no tile) takes in the file, from `mask` on.
    std::size_t bytesOf(const VdbLeaf& leaf) const;
    /// Writes 512 x components floats: a voxel's components side by side; those
    /// of inactive voxels are 0 or what the file says. Thread-safe. @throws
    /// VolumeFault when what is packed does not unpack to them
    void values(const VdbLeaf& leaf, float* out) const;
    std::int64_t activeVoxels() const;
    /// Number of voxels in tiles.
    std::int64_t tileVoxels() const;
    /// Turns tiles into leaves.
    void expandTiles();
    /// The least box of all active voxels. @return false when there are none
    bool activeBox(glm::ivec3& min, glm::ivec3& max) const;

private:
    friend class VdbTreeReader;
    const char* file_ = nullptr;
    bool half_ = false;
    std::uint32_t compression_ = 0;
    HalfConversion convert_{};
    std::vector<std::array<float, 3>> leaf_tiles_;  // values of tiles that became leaves
};

/// Grows a box (min > max: empty) by the active voxels of a leaf.
void growByActive(const glm::ivec3& origin, const VdbGrid::Mask& mask, glm::ivec3& min, glm::ivec3& max);

struct VdbFile {
    VdbMetadata metadata;
    std::vector<VdbGrid> grids;  ///< they refer to the bytes
};

/// @param data  the whole file; it must outlive the result
/// @throws VolumeFault
VdbFile parseVdb(const char* data, std::size_t size);

}  // namespace photic
