// SPDX-License-Identifier: Apache-2.0
// How a .vdb file is laid out, for writing it in parallel: what stands before
// the values of a grid, and each leaf's values as bytes of their own. The same
// bytes as OpenVDB's own writer's, but that it adds a table of leaf sizes to
// the metadata (file_delayed_load), which readers do without.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "bake/volume/half_floats.h"
#include "bake/volume/vdb_bytes.h"

namespace photic {

using VdbValue = std::variant<bool, std::int32_t, std::int64_t, double, std::string, glm::ivec3>;
using VdbValues = std::map<std::string, VdbValue>;

/// What all leaves of a grid have in common.
struct VdbGridLayout {
    std::string name;
    int components = 1;  ///< 1: float, 3: vec3s
    bool half = true;
    std::uint32_t compression = 2;  ///< kPackedZip, kPackedActive, kPackedBlosc
    VdbTransform transform;
    VdbValues metadata;  ///< besides what vdbGridHead() adds
    std::size_t bytesOfValue() const { return static_cast<std::size_t>(components) * (half ? 2 : 4); }
};

/// A leaf's place and its active voxels.
struct VdbTopology {
    glm::ivec3 origin{0};
    VdbGrid::Mask mask{};
};

/// Orders leaves as a tree has them: by 4096^3 root children, 128^3 nodes, 8^3
/// leaves, z fastest in each.
bool beforeInTree(const glm::ivec3& a, const glm::ivec3& b);

/// The file up to its first grid. `number` has 36 characters and tells files
/// apart; it stands at kVdbNumberAt.
std::string vdbFileHead(const std::string& number, const VdbValues& metadata, int grids);
inline constexpr std::size_t kVdbNumberAt = 21;

/// A grid up to its leaves' values.
struct VdbGridHead {
    std::string bytes;
    std::size_t offsets = 0;  ///< place of three 64-bit places in the file: where what follows them
                              ///< begins, where the leaves' values do, and where these end
};
/// @param leaves  in tree order
VdbGridHead vdbGridHead(const VdbGridLayout& grid, const std::vector<VdbTopology>& leaves);

/// The most bytes that a leaf takes.
std::size_t mostBytesOfLeaf(const VdbGridLayout& grid);
/// Writes a leaf's values as they stand in the file. Thread-safe.
/// @param values  512 x components, a voxel's components side by side; what is
/// not active is 0
/// @return bytes written to `out`
std::size_t encodeLeaf(const VdbGridLayout& grid, const HalfConversion& convert, const VdbGrid::Mask& mask,
                       const float* values, char* out);

}  // namespace photic
