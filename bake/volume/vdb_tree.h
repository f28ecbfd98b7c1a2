// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/volume/byte_cursor.h"
#include "bake/volume/vdb_bytes.h"

namespace photic {

/// Values of a tree by OpenVDB's name of their type.
struct VdbValueType {
    std::size_t bytes = 0;       ///< of a value; 0: not known
    std::size_t half_bytes = 0;  ///< as half floats; 0: never stored so
    int components = 0;          ///< of floats or vectors of floats, which are kept; 0: others
};
VdbValueType vdbValueType(const std::string& name);

/// Reads one tree, nodes and values. Memory follows the bytes that are there,
/// not what they claim.
class VdbTreeReader {
public:
    VdbTreeReader(ByteCursor& file, const char* data, VdbGrid& grid, std::uint32_t compression, bool half);
    /// @throws VolumeFault
    void read();

private:
    /// Where a node's values lie.
    struct Stored {
        std::size_t at = 0, count = 0,
                    size = 0;      // place, number of values, bytes once unpacked
        std::uint32_t packed = 0;  // bytes in the file; 0: not packed
    };
    struct Masks {
        const char *child, *value;
        bool isChild(std::size_t i) const { return child[i >> 3] >> (i & 7) & 1; }
        bool isActive(std::size_t i) const { return value[i >> 3] >> (i & 7) & 1; }
    };
    void readRoot();
    void readNode(int log2_side, int child_side, const glm::ivec3& origin);
    void readLeaf(const glm::ivec3& origin);
    void readLeafValues(VdbLeaf& leaf);
    void checkTiles() const;
    void addTiles(const Masks& masks, const Stored& stored, int log2_side, int child_side, const glm::ivec3& origin);
    Stored passValues(std::size_t node_values, const char* active);
    std::array<float, 3> valueAt(const char* values, std::size_t i) const;

    ByteCursor& file_;
    const char* data_;
    VdbGrid& grid_;
    std::uint32_t compression_;
    bool half_;
    VdbValueType type_;
    std::vector<char> unpacked_;
};

}  // namespace photic
