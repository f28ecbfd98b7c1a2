// SPDX-License-Identifier: Apache-2.0
#include "bake/volume/vdb_layout.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "bake/volume/pack.h"

namespace photic {
namespace {

constexpr std::int64_t kMagic = 0x56444220;
constexpr std::uint32_t kFormat = 224, kLibraryMajor = 10, kLibraryMinor = 0;

template <class Number>
void put(std::string& out, Number value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof(value));
}
void putText(std::string& out, const std::string& text) {
    put(out, static_cast<std::uint32_t>(text.size()));
    out += text;
}

struct PutValue {
    std::string& out;
    template <class Number>
    void typed(const char* type, Number value) {
        putText(out, type);
        put(out, static_cast<std::uint32_t>(sizeof(value)));
        put(out, value);
    }
    void operator()(bool v) { typed("bool", v); }
    void operator()(std::int32_t v) { typed("int32", v); }
    void operator()(std::int64_t v) { typed("int64", v); }
    void operator()(double v) { typed("double", v); }
    void operator()(const glm::ivec3& v) { typed("vec3i", v); }
    void operator()(const std::string& v) { putText(out, "string"), putText(out, v); }
};

void putValues(std::string& out, const VdbValues& values) {
    put(out, static_cast<std::uint32_t>(values.size()));
    for (const auto& [name, value] : values) {
        putText(out, name);
        std::visit(PutValue{out}, value);
    }
}

void putVector(std::string& out, const glm::dvec3& v) {
    for (int a = 0; a < 3; ++a) put(out, v[a]);
}

// The simplest map that there is for it, as OpenVDB's own are: programs know cubes from it.
void putTransform(std::string& out, const VdbTransform& t) {
    const glm::dvec3 scale(t.world_from_index[0].x, t.world_from_index[1].y, t.world_from_index[2].z);
    const glm::dmat3 along_axes(scale.x, 0, 0, 0, scale.y, 0, 0, 0, scale.z);
    if (t.world_from_index == along_axes && scale.x > 0 && scale.y > 0 && scale.z > 0) {
        putText(out, scale.x == scale.y && scale.x == scale.z ? "UniformScaleTranslateMap" : "ScaleTranslateMap");
        putVector(out, t.origin_world);
        putVector(out, scale);
        putVector(out, scale);  // of a voxel
        const glm::dvec3 inverse = 1.0 / scale;
        putVector(out, inverse);
        putVector(out, inverse * inverse);
        putVector(out, 0.5 * inverse);
        return;
    }
    putText(out, "AffineMap");
    for (int axis = 0; axis < 3; ++axis) {
        for (int a = 0; a < 3; ++a) put(out, t.world_from_index[axis][a]);
        put(out, 0.0);
    }
    for (int a = 0; a < 3; ++a) put(out, t.origin_world[a]);
    put(out, 1.0);
}

std::string compressionText(std::uint32_t flags) {
    std::string text;
    for (const auto& [flag, word] :
         {std::pair{kPackedZip, "zip"}, {kPackedBlosc, "blosc"}, {kPackedActive, "active values"}})
        if (flags & flag) text += (text.empty() ? "" : " + ") + std::string(word);
    return text.empty() ? "none" : text;
}

std::int64_t activeVoxels(const std::vector<VdbTopology>& leaves) {
    std::int64_t count = 0;
    for (const auto& leaf : leaves)
        for (const auto word : leaf.mask) count += std::popcount(word);
    return count;
}

/// A level of the tree: which leaves share a node, and which of its children a
/// leaf lies in.
struct Level {
    int log2_node, log2_child;  // of their sides in voxels
    bool same(const glm::ivec3& a, const glm::ivec3& b) const { return a >> log2_node == b >> log2_node; }
    std::size_t childOf(const glm::ivec3& voxel) const {
        const int log2 = log2_node - log2_child, low = (1 << log2) - 1;
        const glm::ivec3 c = (voxel >> log2_child) & low;
        return static_cast<std::size_t>((c.x << log2 | c.y) << log2 | c.z);
    }
    std::size_t children() const { return std::size_t{1} << (3 * (log2_node - log2_child)); }
};
constexpr Level kUpper{12, 7}, kLower{7, 3};

class TreeWriter {
public:
    TreeWriter(const VdbGridLayout& grid, const std::vector<VdbTopology>& leaves, std::string& out)
        : grid_(grid), leaves_(leaves), out_(out) {}

    void write() {
        put(out_, std::int32_t{1});  // buffers
        out_.append(4 * static_cast<std::size_t>(grid_.components),
                    0);               // the value of what is not there
        put(out_, std::uint32_t{0});  // tiles
        const std::size_t count_at = out_.size();
        put(out_, std::uint32_t{0});
        std::uint32_t roots = 0;
        for (std::size_t first = 0, end = 0; first < leaves_.size(); first = end, ++roots) {
            end = endOf(kUpper, first, leaves_.size());
            const glm::ivec3 origin = (leaves_[first].origin >> kUpper.log2_node) << kUpper.log2_node;
            for (int a = 0; a < 3; ++a) put(out_, std::int32_t{origin[a]});
            writeNode(kUpper, first, end);
        }
        std::memcpy(out_.data() + count_at, &roots, sizeof(roots));
    }

private:
    std::size_t endOf(const Level& level, std::size_t first, std::size_t last) const {
        std::size_t end = first + 1;
        while (end < last && level.same(leaves_[first].origin, leaves_[end].origin)) ++end;
        return end;
    }

    void writeNode(const Level& level, std::size_t first, std::size_t end) {
        const std::size_t mask_at = out_.size();
        out_.append(2 * level.children() / 8,
                    0);  // children, and active values: there are none
        for (std::size_t i = first; i < end; ++i) {
            const std::size_t child = level.childOf(leaves_[i].origin);
            out_[mask_at + child / 8] = static_cast<char>(out_[mask_at + child / 8] | 1 << child % 8);
        }
        writeNoValues(level.children());
        for (std::size_t i = first; i < end;) {
            if (level.log2_child == 3) {
                out_.append(reinterpret_cast<const char*>(leaves_[i].mask.data()), 64);
                ++i;
            } else {
                const std::size_t next = endOf(kLower, i, end);
                writeNode(kLower, i, next);
                i = next;
            }
        }
    }

    void writeNoValues(std::size_t count) {
        if (!(grid_.compression & kPackedActive)) {
            put(out_, kAllValues);
            const std::string zeros(count * grid_.bytesOfValue(), 0);
            appendPacked(zeros.data(), zeros.size());
            return;
        }
        put(out_, kInactiveAreBackground);
        if (!grid_.half) appendPacked(nullptr, 0);
    }
    void appendPacked(const char* data, std::size_t size) {
        std::string packed(mostPackedBytes(size), 0);
        packed.resize(packBytes(grid_.compression, data, size, packed.data()));
        out_ += packed;
    }

    const VdbGridLayout& grid_;
    const std::vector<VdbTopology>& leaves_;
    std::string& out_;
};

// About what a tree of these leaves takes in memory.
std::int64_t memoryOf(const VdbGridLayout& grid, const std::vector<VdbTopology>& leaves) {
    constexpr std::int64_t kLeaf = 96, kLowerNode = 4096 * 8, kUpperNode = 32768 * 8;
    std::int64_t bytes = static_cast<std::int64_t>(leaves.size()) * (kLeaf + 512 * 4 * grid.components);
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const bool first = i == 0;
        if (first || !kLower.same(leaves[i - 1].origin, leaves[i].origin)) bytes += kLowerNode;
        if (first || !kUpper.same(leaves[i - 1].origin, leaves[i].origin)) bytes += kUpperNode;
    }
    return bytes;
}

}  // namespace

bool beforeInTree(const glm::ivec3& a, const glm::ivec3& b) {
    for (const int log2 : {12, 7, 3})
        for (int axis = 0; axis < 3; ++axis)
            if (a[axis] >> log2 != b[axis] >> log2) return a[axis] >> log2 < b[axis] >> log2;
    return false;
}

std::string vdbFileHead(const std::string& number, const VdbValues& metadata, int grids) {
    std::string out;
    put(out, kMagic), put(out, kFormat), put(out, kLibraryMajor), put(out, kLibraryMinor);
    put(out, char{1});  // grids say where they end
    out += number;
    putValues(out, metadata);
    put(out, std::int32_t{grids});
    return out;
}

VdbGridHead vdbGridHead(const VdbGridLayout& grid, const std::vector<VdbTopology>& leaves) {
    VdbGridHead head;
    std::string& out = head.bytes;
    putText(out, grid.name);
    putText(out, std::string("Tree_") + (grid.components == 1 ? "float" : "vec3s") + "_5_4_3" +
                     (grid.half ? "_HalfFloat" : ""));
    putText(out, "");  // it shares no other grid's tree
    head.offsets = out.size();
    for (int i = 0; i < 3; ++i) put(out, std::int64_t{0});
    put(out, grid.compression);

    VdbValues metadata = grid.metadata;
    metadata["name"] = grid.name, metadata["class"] = std::string("fog volume");
    metadata["is_saved_as_half_float"] = grid.half;
    glm::ivec3 min(0), max(-1);
    if (!leaves.empty()) min = glm::ivec3(0x7fffffff), max = -min;
    for (const auto& leaf : leaves) growByActive(leaf.origin, leaf.mask, min, max);
    metadata["file_bbox_min"] = min, metadata["file_bbox_max"] = max;
    metadata["file_compression"] = compressionText(grid.compression);
    metadata["file_voxel_count"] = activeVoxels(leaves);
    metadata["file_mem_bytes"] = memoryOf(grid, leaves);
    putValues(out, metadata);
    putTransform(out, grid.transform);
    TreeWriter(grid, leaves, out).write();
    return head;
}

std::size_t mostBytesOfLeaf(const VdbGridLayout& grid) {
    return 64 + 1 + mostPackedBytes(VdbGrid::kVoxels * grid.bytesOfValue());
}

std::size_t encodeLeaf(const VdbGridLayout& grid, const HalfConversion& convert, const VdbGrid::Mask& mask,
                       const float* values, char* out) {
    const bool active_only = grid.compression & kPackedActive;
    std::memcpy(out, mask.data(), 64);
    out[64] = active_only ? kInactiveAreBackground : kAllValues;
    const auto width = static_cast<std::size_t>(grid.components);
    std::size_t count = VdbGrid::kVoxels * width;
    float active[3 * VdbGrid::kVoxels];
    if (active_only && std::any_of(mask.begin(), mask.end(), [](std::uint64_t word) { return word != ~0ull; })) {
        count = 0;
        for (std::size_t w = 0; w < 8; ++w)
            for (std::uint64_t rest = mask[w]; rest != 0; rest &= rest - 1) {
                const float* from = values + (w * 64 + static_cast<std::size_t>(std::countr_zero(rest))) * width;
                for (std::size_t c = 0; c < width; ++c) active[count++] = from[c];
            }
        values = active;
    }
    const bool packs = grid.compression & (kPackedBlosc | kPackedZip);
    const std::size_t bytes = count * (grid.half ? 2 : 4);
    std::uint16_t halves[3 * VdbGrid::kVoxels];
    if (grid.half) convert.toHalf(values, count, halves);
    const char* from = grid.half ? reinterpret_cast<const char*>(halves) : reinterpret_cast<const char*>(values);
    if (packs) return 65 + packBytes(grid.compression, from, bytes, out + 65);
    std::memcpy(out + 65, from, bytes);
    return 65 + bytes;
}

}  // namespace photic
