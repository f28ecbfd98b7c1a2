// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/nvdb_grid.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "runtime/src/nvdb_layout.h"

namespace photic::runtime {

using namespace nvdb;

namespace {

/// Nodes of one level: an array in the file, each of which the walk may enter once.
struct NodeArray {
    std::uint64_t start, count, size;
    std::vector<bool> entered;
};

/// The place in `array` of the node that `child` bytes from `parent` lead to.
std::uint64_t enter(NodeArray& array, std::uint64_t parent, std::int64_t child, const std::string& what) {
    const std::uint64_t offset = parent + static_cast<std::uint64_t>(child);  // wraps round when negative, as meant
    const std::uint64_t distance = offset - array.start;
    const std::uint64_t number = array.size == 0 ? 0 : distance / array.size;
    if (offset < array.start || number >= array.count || number * array.size != distance) {
        fail(ErrorCode::Format, what + ": a node's child is no node; the file is damaged");
    }
    if (array.entered[number]) fail(ErrorCode::Format, what + ": a node has two parents; the file is damaged");
    array.entered[number] = true;
    return offset;
}

/// Calls body(n, whether it is a child) for the entries of an upper or lower node of 2^(3 log2) entries that are a
/// child or an active tile: its value mask, then its child mask.
template <class Body>
void eachEntry(const Bytes& bytes, std::uint64_t node, int log2, const Body& body) {
    const std::uint64_t mask_size = (std::uint64_t{1} << 3 * log2) / 8;
    for (std::uint64_t word = 0; word < mask_size; word += 8) {
        const auto values = bytes.get<std::uint64_t>(node + kNodeValueMask + word);
        const auto children = bytes.get<std::uint64_t>(node + kNodeValueMask + mask_size + word);
        for (std::uint64_t rest = values | children; rest != 0; rest &= rest - 1) {
            const int n = std::countr_zero(rest);
            body(static_cast<std::uint32_t>(8 * word) + static_cast<std::uint32_t>(n), (children >> n & 1) != 0);
        }
    }
}

/// The first voxel of root tile `key`: 21 bits each of z, y and x, in units of 4096 voxels.
Int3 originOf(std::uint64_t key) {
    const auto part = [&](int shift) {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(key >> shift & 0x1fffffU) << 12);
    };
    return {part(42), part(21), part(0)};
}

/// The origin of child n among 2^(3 log2) of them, each `span` voxels wide.
Int3 childOrigin(const Int3& origin, std::uint32_t n, int log2, int span) {
    const std::uint32_t mask = (1U << log2) - 1;
    return {origin[0] + span * static_cast<int>(n >> (2 * log2)), origin[1] + span * static_cast<int>(n >> log2 & mask),
            origin[2] + span * static_cast<int>(n & mask)};
}

}  // namespace

struct NvdbGrid::Nodes {
    std::uint64_t root, root_tiles;
    NodeArray upper, lower, leaf;
};

NvdbGrid::NvdbGrid(Bytes bytes) : bytes_(std::move(bytes)) {
    bytes_.require(0, kGridHeaderSize, 1, "the grid's header");
    const auto magic = bytes_.get<std::uint64_t>(0);
    const auto version = bytes_.get<std::uint32_t>(kGridVersion);
    if (magic != kMagicOld && magic != kMagicGrid) {
        fail(ErrorCode::Format, bytes_.what() + " does not begin with NanoVDB's magic number; the file is damaged");
    }
    if (majorOf(version) != kMajorVersion) {
        fail(ErrorCode::Format, bytes_.what() + " is of NanoVDB " + std::to_string(majorOf(version)) +
                                    ".x; only 32.x is read: export it again");
    }
    if (bytes_.get<std::uint64_t>(kGridSize) != bytes_.size()) {
        fail(ErrorCode::Format, bytes_.what() + " says that it has " +
                                    std::to_string(bytes_.get<std::uint64_t>(kGridSize)) + " bytes and has " +
                                    std::to_string(bytes_.size()) + "; the file is cut short or damaged");
    }
    name_ = bytes_.text(kGridName, kGridNameSize, "the grid's name");
    type_number_ = bytes_.get<std::uint32_t>(kGridType);
    if (typeIsRead()) readTransform();
}

bool NvdbGrid::typeIsRead() const {
    switch (type()) {
        case NvdbType::Float:
        case NvdbType::Vec3f:
        case NvdbType::Fp4:
        case NvdbType::Fp8:
        case NvdbType::Fp16:
        case NvdbType::Vec4f:
            return true;
    }
    return false;
}

int NvdbGrid::components() const { return type() == NvdbType::Vec4f ? 4 : type() == NvdbType::Vec3f ? 3 : 1; }

void NvdbGrid::readTransform() {
    for (std::size_t i = 0; i < 9; ++i)
        transform_.world_from_index[i] = bytes_.get<double>(kGridMap + kMapMatrix + 8 * i);
    for (std::size_t i = 0; i < 3; ++i) transform_.origin_world[i] = bytes_.get<double>(kGridMap + kMapVector + 8 * i);
    finishTransform(transform_, bytes_.what());
}

std::uint64_t NvdbGrid::blindRecord(const std::string& name) const {
    const auto count = bytes_.get<std::uint32_t>(kGridBlindCount);
    const auto start = static_cast<std::uint64_t>(bytes_.get<std::int64_t>(kGridBlindOffset));
    if (count == 0) return 0;
    bytes_.require(start, count, kBlindSize, "the list of blind data");
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t record = start + i * kBlindSize;
        if (bytes_.text(record + kBlindName, 256, "a blind datum's name") == name) return record;
    }
    return 0;
}

// NanoVDB's own reader counts a blind datum's place from its record, its comment and PNanoVDB from the grid: how the
// datum begins tells.

std::string NvdbGrid::blindText(const std::string& name) const {
    const std::uint64_t record = blindRecord(name);
    if (record == 0) return {};
    const auto offset = static_cast<std::uint64_t>(bytes_.get<std::int64_t>(record));
    constexpr std::uint64_t kLargestText = 1 << 20;
    for (const std::uint64_t at : {record + offset, offset}) {
        if (at >= bytes_.size() || *bytes_.characters(at) != '{') continue;
        return {bytes_.characters(at), static_cast<std::size_t>(std::min(bytes_.size() - at, kLargestText))};
    }
    fail(ErrorCode::Format, bytes_.what() + ": the blind data '" + name + "' is no JSON text");
}

Bytes NvdbGrid::blindBytes(const std::string& name, const char* magic) const {
    const std::uint64_t record = blindRecord(name);
    const std::size_t length = std::strlen(magic);
    for (const bool from_record : {true, false}) {
        if (record == 0) break;
        const auto offset = static_cast<std::uint64_t>(bytes_.get<std::int64_t>(record));
        const std::uint64_t at = from_record ? record + offset : offset;
        if (at > bytes_.size() || bytes_.size() - at < length || std::memcmp(bytes_.characters(at), magic, length) != 0)
            continue;
        return bytes_.part(at, bytes_.get<std::uint64_t>(record + kBlindCount), bytes_.what());
    }
    fail(ErrorCode::Format, bytes_.what() + ": there is no blind data '" + name + "' that begins with " + magic);
}

NvdbGrid::Nodes NvdbGrid::checkedNodes() const {
    const TypeLayout layout = layoutOf(type());
    bytes_.require(kTree, kTreeSize, 1, "the tree");
    const auto array = [&](std::uint64_t level, std::uint64_t size, const char* of) {
        NodeArray nodes;
        nodes.start = kTree + bytes_.get<std::uint64_t>(kTree + kTreeNodeOffset + 8 * level);
        nodes.count = bytes_.get<std::uint32_t>(kTree + kTreeNodeCount + 4 * level);
        nodes.size = size;
        if (nodes.count != 0) bytes_.require(nodes.start, nodes.count, size, of);
        nodes.entered.resize(static_cast<std::size_t>(nodes.count));
        return nodes;
    };
    Nodes nodes{0, 0, array(2, layout.upper_size, "upper nodes"), array(1, layout.lower_size, "lower nodes"),
                array(0, layout.leaf_size, "leaves")};
    nodes.root = kTree + bytes_.get<std::uint64_t>(kTree + kTreeNodeOffset + 8 * 3);
    bytes_.require(nodes.root, layout.root_size, 1, "the root");
    nodes.root_tiles = bytes_.get<std::uint32_t>(nodes.root + kRootTileCount);
    bytes_.require(nodes.root + layout.root_size, nodes.root_tiles, layout.root_tile_size, "the root's tiles");
    return nodes;
}

namespace {

/// Collects the leaves of a tree, and its tiles as leaves.
class LeafWalk {
public:
    LeafWalk(const Bytes& bytes, const TypeLayout& layout, std::uint64_t largest_count)
        : bytes_(bytes), layout_(layout), largest_count_(largest_count) {}

    void walkUpper(std::uint64_t node, const Int3& origin, NodeArray& lower, NodeArray& leaves) {
        eachEntry(bytes_, node, 5, [&](std::uint32_t n, bool child) {
            const Int3 at = childOrigin(origin, n, 5, 128);
            const std::uint64_t entry = node + layout_.upper_table + n * layout_.table_stride;
            if (child) {
                walkLower(enter(lower, node, bytes_.get<std::int64_t>(entry), bytes_.what()), at, leaves);
            } else {
                addTile(at, 16, entry);
            }
        });
    }
    void addTile(const Int3& origin, int leaves_a_side, std::uint64_t value) {
        for (int x = 0; x < leaves_a_side; ++x) {
            for (int y = 0; y < leaves_a_side; ++y) {
                for (int z = 0; z < leaves_a_side; ++z) {
                    add({origin[0] + 8 * x, origin[1] + 8 * y, origin[2] + 8 * z}, value, NvdbLeaf::Kind::Tile);
                }
            }
        }
    }
    std::vector<NvdbLeaf> take() { return std::move(out_); }

private:
    void walkLower(std::uint64_t node, const Int3& origin, NodeArray& leaves) {
        eachEntry(bytes_, node, 4, [&](std::uint32_t n, bool child) {
            const Int3 at = childOrigin(origin, n, 4, 8);
            const std::uint64_t entry = node + layout_.lower_table + n * layout_.table_stride;
            if (child) {
                add(at, enter(leaves, node, bytes_.get<std::int64_t>(entry), bytes_.what()), NvdbLeaf::Kind::Leaf);
            } else {
                add(at, entry, NvdbLeaf::Kind::Tile);
            }
        });
    }
    void add(const Int3& origin, std::uint64_t values, NvdbLeaf::Kind kind) {
        if (out_.size() >= largest_count_) {
            fail(ErrorCode::Limit,
                 bytes_.what() + " has more than the " + std::to_string(largest_count_) +
                     " blocks of 8^3 voxels that fit the memory limit; raise LoadOptions::largest_memory, or "
                     "export it with a --budget");
        }
        out_.push_back({origin, values, kind});
    }

    const Bytes& bytes_;
    const TypeLayout layout_;
    const std::uint64_t largest_count_;
    std::vector<NvdbLeaf> out_;
};

}  // namespace

std::vector<NvdbLeaf> NvdbGrid::leaves(std::uint64_t largest_count) const {
    const TypeLayout layout = layoutOf(type());
    Nodes nodes = checkedNodes();
    LeafWalk walk(bytes_, layout, largest_count);
    std::vector<std::uint64_t> keys;
    for (std::uint64_t i = 0; i < nodes.root_tiles; ++i) {
        const std::uint64_t tile = nodes.root + layout.root_size + i * layout.root_tile_size;
        keys.push_back(bytes_.get<std::uint64_t>(tile + kRootTileKey));
        const Int3 origin = originOf(keys.back());
        const auto child = bytes_.get<std::int64_t>(tile + kRootTileChild);
        const bool active = bytes_.get<std::uint32_t>(tile + kRootTileState) != 0;
        if (child == 0 && !active) continue;
        for (const int v : origin) {
            if (std::abs(static_cast<std::int64_t>(v)) > kLargestIndex - 4096) {
                fail(ErrorCode::Limit, bytes_.what() + ": voxels lie more than " + std::to_string(kLargestIndex) +
                                           " from the origin; move the volume or enlarge its voxels");
            }
        }
        if (child != 0) {
            walk.walkUpper(enter(nodes.upper, nodes.root, child, bytes_.what()), origin, nodes.lower, nodes.leaf);
        } else {
            walk.addTile(origin, 512, tile + layout.root_tile_value);
        }
    }
    std::sort(keys.begin(), keys.end());
    if (std::adjacent_find(keys.begin(), keys.end()) != keys.end()) {
        fail(ErrorCode::Format, bytes_.what() + ": two tiles of the root are at one place; the file is damaged");
    }
    return walk.take();
}

namespace {

/// Fills 512 voxels, x fastest, from values that are numbered with z fastest: value(number, channel) where the mask has
/// the number's bit, else 0.
template <std::size_t kChannels, class Value>
void fillLeaf(const Bytes& bytes, std::uint64_t mask, float* out, const Value& value) {
    for (std::uint32_t x = 0; x < 8; ++x) {
        const auto active = bytes.get<std::uint64_t>(mask + std::uint64_t{8} * x);
        for (std::uint32_t yz = 0; yz < 64; ++yz) {
            float* voxel = out + kChannels * (x + 8 * (yz >> 3) + 64 * (yz & 7));
            const bool lit = (active >> yz & 1) != 0;
            for (std::size_t c = 0; c < kChannels; ++c) voxel[c] = lit ? value(64 * x + yz, c) : 0.0F;
        }
    }
}

}  // namespace

void NvdbGrid::readLeaf(const NvdbLeaf& leaf, float* out) const {
    const auto channels = static_cast<std::size_t>(components());
    if (leaf.kind == NvdbLeaf::Kind::Tile) {
        for (std::size_t i = 0; i < 512 * channels; ++i) out[i] = bytes_.get<float>(leaf.values + 4 * (i % channels));
        return;
    }
    const std::uint64_t mask = leaf.values + kLeafValueMask, table = leaf.values + layoutOf(type()).leaf_table;
    const float minimum = bytes_.get<float>(leaf.values + kLeafMinimum),
                quantum = bytes_.get<float>(leaf.values + kLeafQuantum);
    const auto dequantised = [&](std::uint32_t code) { return static_cast<float>(code) * quantum + minimum; };
    switch (type()) {
        case NvdbType::Fp4:
            fillLeaf<1>(bytes_, mask, out, [&](std::uint32_t n, std::size_t) {
                return dequantised(bytes_.get<std::uint8_t>(table + n / 2) >> (4 * (n & 1)) & 15U);
            });
            return;
        case NvdbType::Fp8:
            fillLeaf<1>(bytes_, mask, out,
                        [&](std::uint32_t n, std::size_t) { return dequantised(bytes_.get<std::uint8_t>(table + n)); });
            return;
        case NvdbType::Fp16:
            fillLeaf<1>(bytes_, mask, out, [&](std::uint32_t n, std::size_t) {
                return dequantised(bytes_.get<std::uint16_t>(table + std::uint64_t{2} * n));
            });
            return;
        case NvdbType::Float:
            fillLeaf<1>(bytes_, mask, out,
                        [&](std::uint32_t n, std::size_t) { return bytes_.get<float>(table + std::uint64_t{4} * n); });
            return;
        case NvdbType::Vec3f:
            fillLeaf<3>(bytes_, mask, out,
                        [&](std::uint32_t n, std::size_t c) { return bytes_.get<float>(table + 4 * (3 * n + c)); });
            return;
        case NvdbType::Vec4f:
            fillLeaf<4>(bytes_, mask, out,
                        [&](std::uint32_t n, std::size_t c) { return bytes_.get<float>(table + 4 * (4 * n + c)); });
            return;
    }
}

}  // namespace photic::runtime
