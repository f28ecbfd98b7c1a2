// SPDX-License-Identifier: Apache-2.0
#include "bake/volume/vdb_tree.h"

#include <bit>
#include <set>

#include "bake/volume/pack.h"

namespace photic {
namespace {

// How a node stores its inactive values: OpenVDB's numbers.
enum Inactive : std::int8_t {
    Background = 0,
    MinusBackground = 1,
    OneValue = 2,
    MaskOfBackground = 3,
    MaskAndOneValue = 4,
    MaskAndTwoValues = 5,
    AllValues = 6
};

// Far beyond what a scene spans, and near enough that sizes of boxes do not
// overflow.
constexpr int kFarthest = 1 << 29;
// A bit in the file is a tile of 28 bytes in memory: 470 MB of them.
constexpr std::size_t kMostTiles = std::size_t{1} << 24;

[[noreturn]] void damaged(const char* what) {
    throw VolumeFault(std::string("it is damaged: ") + what + "; write or copy it again");
}

std::size_t countOf(const char* mask, std::size_t bits) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < bits / 64; ++i) {
        std::uint64_t word;
        std::memcpy(&word, mask + 8 * i, 8);
        count += static_cast<std::size_t>(std::popcount(word));
    }
    return count;
}

}  // namespace

VdbValueType vdbValueType(const std::string& name) {
    if (name == "float") return {4, 2, 1};
    if (name == "vec3s") return {12, 6, 3};
    if (name == "double") return {8, 2, 0};
    if (name == "vec3d") return {24, 6, 0};
    if (name == "int32") return {4, 0, 0};
    if (name == "int64") return {8, 0, 0};
    if (name == "vec3i") return {12, 0, 0};
    return {};
}

VdbTreeReader::VdbTreeReader(ByteCursor& file, const char* data, VdbGrid& grid, std::uint32_t compression, bool half)
    : file_(file), data_(data), grid_(grid), compression_(compression), half_(half), type_(vdbValueType(grid.type)) {
    half_ = half && type_.half_bytes != 0;
    grid_.file_ = data, grid_.half_ = half_, grid_.compression_ = compression, grid_.convert_ = halfConversion();
}

void VdbTreeReader::read() {
    if (file_.number<std::int32_t>() != 1) damaged("a tree of several buffers");
    readRoot();
    for (VdbLeaf& leaf : grid_.leaves) readLeafValues(leaf);
    if (type_.components == 0) grid_.leaves.clear(), grid_.tiles.clear();
}

void VdbTreeReader::readRoot() {
    file_.pass(type_.bytes);  // the value of all that is not there
    const auto tiles = file_.number<std::uint32_t>(), children = file_.number<std::uint32_t>();
    std::set<std::array<int, 3>> places;
    const auto place = [&] {
        glm::ivec3 origin;
        for (int a = 0; a < 3; ++a) origin[a] = file_.number<std::int32_t>();
        for (int a = 0; a < 3; ++a)
            if (origin[a] < -kFarthest || origin[a] > kFarthest)
                throw VolumeFault("it is damaged, or has blocks of voxels more than " + std::to_string(kFarthest) +
                                  " from the origin; crop it");
        if (origin.x % 4096 != 0 || origin.y % 4096 != 0 || origin.z % 4096 != 0)
            damaged("a node between the places of nodes");
        if (!places.insert({origin.x, origin.y, origin.z}).second) damaged("two nodes in one place");
        return origin;
    };
    for (std::uint32_t i = 0; i < tiles; ++i) {
        const glm::ivec3 origin = place();
        const std::size_t at = file_.pass(type_.bytes);
        if (file_.number<std::uint8_t>() == 0 || type_.components == 0) continue;
        checkTiles();
        VdbTile tile{origin, 4096, {}};
        std::memcpy(tile.value.data(), data_ + at, type_.bytes);
        grid_.tiles.push_back(tile);
    }
    for (std::uint32_t i = 0; i < children; ++i) readNode(5, 128, place());
}

void VdbTreeReader::readNode(int log2_side, int child_side, const glm::ivec3& origin) {
    const std::size_t count = std::size_t{1} << (3 * log2_side);
    const Masks masks{file_.take(count / 8), file_.take(count / 8)};
    const Stored stored = passValues(count, masks.value);
    addTiles(masks, stored, log2_side, child_side, origin);
    for (std::size_t i = 0; i < count; ++i) {
        if (i % 8 == 0 && masks.child[i / 8] == 0) {
            i += 7;
            continue;
        }
        if (!masks.isChild(i)) continue;
        const auto n = static_cast<int>(i), low = (1 << log2_side) - 1;
        const glm::ivec3 child(n >> (2 * log2_side), n >> log2_side & low, n & low);
        if (child_side == 8)
            readLeaf(origin + child * 8);
        else
            readNode(log2_side - 1, child_side / 16, origin + child * child_side);
    }
}

void VdbTreeReader::readLeaf(const glm::ivec3& origin) {
    VdbLeaf leaf;
    leaf.origin = origin;
    leaf.mask = file_.pass(64);
    grid_.leaves.push_back(leaf);
}

void VdbTreeReader::readLeafValues(VdbLeaf& leaf) {
    const std::size_t again = file_.pass(64);
    if (std::memcmp(data_ + leaf.mask, data_ + again, 64) != 0) damaged("a leaf whose two masks differ");
    leaf.mask = again;
    const Stored stored = passValues(VdbGrid::kVoxels, data_ + again);
    leaf.values = stored.at, leaf.packed = stored.packed;
    leaf.kind = stored.count == VdbGrid::kVoxels ? VdbLeaf::Kind::AllVoxels : VdbLeaf::Kind::ActiveVoxels;
}

VdbTreeReader::Stored VdbTreeReader::passValues(std::size_t node_values, const char* active) {
    const auto inactive = file_.number<std::int8_t>();
    if (inactive < Background || inactive > AllValues) damaged("a node of an unknown kind");
    if (inactive == OneValue || inactive == MaskAndOneValue || inactive == MaskAndTwoValues) file_.pass(type_.bytes);
    if (inactive == MaskAndTwoValues) file_.pass(type_.bytes);
    if (inactive == MaskOfBackground || inactive == MaskAndOneValue || inactive == MaskAndTwoValues)
        file_.pass(node_values / 8);

    Stored stored;
    stored.count = compression_ & kPackedActive && inactive != AllValues ? countOf(active, node_values) : node_values;
    stored.size = stored.count * (half_ ? type_.half_bytes : type_.bytes);
    if (!(compression_ & (kPackedBlosc | kPackedZip)) || (half_ && stored.count == 0)) {
        stored.at = file_.pass(stored.size);
        return stored;
    }
    // Negative: so many bytes as they are.
    const auto bytes = file_.number<std::int64_t>();
    if (bytes <= 0 ? -bytes != static_cast<std::int64_t>(stored.size) : bytes > std::int64_t{1} << 30)
        damaged("a node of another size than its values have");
    stored.packed = bytes > 0 ? static_cast<std::uint32_t>(bytes) : 0;
    stored.at = file_.pass(bytes > 0 ? stored.packed : stored.size);
    return stored;
}

void VdbTreeReader::checkTiles() const {
    if (grid_.tiles.size() >= kMostTiles)
        throw VolumeFault("a grid of it holds more than " + std::to_string(kMostTiles) + " active tiles; crop it");
}

void VdbTreeReader::addTiles(const Masks& masks, const Stored& stored, int log2_side, int child_side,
                             const glm::ivec3& origin) {
    if (type_.components == 0) return;
    const std::size_t count = std::size_t{1} << (3 * log2_side);
    const char* values = nullptr;
    std::size_t active = 0;  // those before i
    for (std::size_t i = 0; i < count; ++i) {
        if (i % 8 == 0 && masks.value[i / 8] == 0) {
            i += 7;
            continue;
        }
        if (!masks.isActive(i)) continue;
        const std::size_t place = stored.count == count ? i : active++;
        if (masks.isChild(i)) continue;
        if (values == nullptr) {
            values = data_ + stored.at;
            if (stored.packed != 0) {
                unpacked_.resize(stored.size);
                unpackBytes(compression_, data_ + stored.at, stored.packed, unpacked_.data(), stored.size);
                values = unpacked_.data();
            }
        }
        checkTiles();
        const auto n = static_cast<int>(i), low = (1 << log2_side) - 1;
        const glm::ivec3 at(n >> (2 * log2_side), n >> log2_side & low, n & low);
        grid_.tiles.push_back({origin + at * child_side, child_side, valueAt(values, place)});
    }
}

std::array<float, 3> VdbTreeReader::valueAt(const char* values, std::size_t i) const {
    std::array<float, 3> value{};
    if (half_)
        grid_.convert_.toFloat(values + i * type_.half_bytes, static_cast<std::size_t>(type_.components), value.data());
    else
        std::memcpy(value.data(), values + i * type_.bytes, type_.bytes);
    return value;
}

}  // namespace photic
