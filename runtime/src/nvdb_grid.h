// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "runtime/src/bytes.h"
#include "runtime/src/volume_data.h"

namespace photic::runtime {

/// How a grid's values are stored; the numbers are NanoVDB's grid types.
enum class NvdbType : std::uint32_t { Float = 1, Vec3f = 6, Fp4 = 13, Fp8 = 14, Fp16 = 15, Vec4f = 17 };

/// 8^3 voxels that are active somewhere, as they lie in the file.
struct NvdbLeaf {
    Int3 origin;           ///< its first voxel; a multiple of 8
    std::uint64_t values;  ///< offset in the grid: of the leaf, or of the one value that a whole tile of 8^3 has
    enum class Kind : std::uint8_t { Leaf, Tile } kind;
};

/// One grid of a `.nvdb`, checked so that what it hands out can be read: its header on construction, its tree when it
/// is walked. Layout: NanoVDB.h 32.x (GridData, TreeData, RootData, InternalData, LeafData).
class NvdbGrid {
public:
    /// @param bytes  all of the grid
    /// @throws Failure{Format}
    explicit NvdbGrid(Bytes bytes);

    const std::string& name() const { return name_; }
    std::uint32_t typeNumber() const { return type_number_; }
    /// Whether typeNumber() is one of NvdbType; the rest of the functions need it.
    bool typeIsRead() const;
    NvdbType type() const { return static_cast<NvdbType>(type_number_); }
    int components() const;  ///< 1, 3 or 4 floats per voxel

    const VoxelTransform& transform() const { return transform_; }

    /// The text of the blind data called `name`; empty when there is none.
    std::string blindText(const std::string& name) const;

    /// The bytes of the blind data called `name`, which begin with `magic` (eight of them).
    /// @throws Failure{Format} where there is none such
    Bytes blindBytes(const std::string& name, const char* magic) const;

    /// All leaves and active tiles, in the file's order. Each node is met once, or the file is refused: the walk's
    /// length is bounded by the file's.
    /// @param largest_count  of leaves and tiles
    /// @throws Failure{Format}, Failure{Limit}
    std::vector<NvdbLeaf> leaves(std::uint64_t largest_count) const;

    /// The values of a leaf's 512 voxels, x fastest; those that are not active are 0.
    /// @param out  512 * components() floats
    void readLeaf(const NvdbLeaf& leaf, float* out) const;

private:
    struct Nodes;
    void readTransform();
    /// Where the record of a blind datum stands; 0: there is none.
    std::uint64_t blindRecord(const std::string& name) const;
    Nodes checkedNodes() const;

    Bytes bytes_;
    std::string name_;
    std::uint32_t type_number_ = 0;
    VoxelTransform transform_;
};

/// The grids of a file: segments of a header, a list and the grids, plain or packed by Blosc with LZ4, or grids alone.
/// @param largest_unpacked  bytes of all packed grids once they are unpacked
/// @throws Failure{Format} for anything else, Failure{Limit}
std::vector<NvdbGrid> readNvdbGrids(const Bytes& file, std::uint64_t largest_unpacked);

}  // namespace photic::runtime
