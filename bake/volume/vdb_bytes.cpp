// SPDX-License-Identifier: Apache-2.0
#include "bake/volume/vdb_bytes.h"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "bake/volume/byte_cursor.h"
#include "bake/volume/vdb_tree.h"

namespace photic {
namespace {

constexpr std::int64_t kMagic = 0x56444220;
constexpr std::uint32_t kOldest = 222;
constexpr char kSuffix = '\x1e';  // before the number that tells grids of one name apart
constexpr const char* kHalfSuffix = "_HalfFloat";
constexpr std::size_t kMostShared = std::size_t{1} << 24;  // 640 MB

template <class Number>
std::string numberText(const char* from, int count) {
    std::string text;
    for (int i = 0; i < count; ++i) {
        Number value;
        std::memcpy(&value, from + sizeof(Number) * static_cast<std::size_t>(i), sizeof(Number));
        text += fmt::format("{}{}", i == 0 ? "" : ", ", value);
    }
    return count == 1 ? text : "[" + text + "]";
}

// Numbers with all their digits, what is of an unknown type left out.
void putText(VdbMetadata& to, const std::string& name, const std::string& type, const char* data, std::size_t size) {
    struct Known {
        const char* type;
        std::size_t size;
        std::string (*text)(const char*, int);
        int count;
    };
    static constexpr Known known[] = {
        {"int32", 4, numberText<std::int32_t>, 1},  {"int64", 8, numberText<std::int64_t>, 1},
        {"float", 4, numberText<float>, 1},         {"double", 8, numberText<double>, 1},
        {"vec3i", 12, numberText<std::int32_t>, 3}, {"vec3s", 12, numberText<float>, 3},
        {"vec3d", 24, numberText<double>, 3}};
    if (type == "string") {
        to[name] = std::string(data, size);
    } else if (type == "bool" && size == 1) {
        to[name] = data[0] != 0 ? "true" : "false";
    } else {
        for (const Known& k : known)
            if (type == k.type && size == k.size) to[name] = k.text(data, k.count);
    }
}

VdbMetadata readMetadata(ByteCursor& file) {
    VdbMetadata metadata;
    const auto count = file.number<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::string name = file.text(), type = file.text();
        const auto size = file.number<std::uint32_t>();
        putText(metadata, name, type, file.take(size), size);
    }
    return metadata;
}

glm::dvec3 readVector(ByteCursor& file) {
    glm::dvec3 v;
    for (int a = 0; a < 3; ++a) v[a] = file.number<double>();
    return v;
}

// Row vectors in OpenVDB: a row for the image of each axis, and one for the
// origin.
VdbTransform readMatrix(ByteCursor& file) {
    double m[4][4];
    for (auto& row : m)
        for (double& value : row) value = file.number<double>();
    VdbTransform t;
    for (int axis = 0; axis < 3; ++axis) t.world_from_index[axis] = {m[axis][0], m[axis][1], m[axis][2]};
    t.origin_world = {m[3][0], m[3][1], m[3][2]};
    return t;
}

std::optional<VdbTransform> readTransform(ByteCursor& file) {
    const std::string map = file.text();
    if (map == "AffineMap" || map == "UnitaryMap") return readMatrix(file);
    VdbTransform t;
    const bool moves = map == "TranslationMap" || map == "ScaleTranslateMap" || map == "UniformScaleTranslateMap";
    if (moves) t.origin_world = readVector(file);
    if (map == "ScaleMap" || map == "UniformScaleMap" || (moves && map != "TranslationMap")) {
        const glm::dvec3 scale = readVector(file);
        for (int axis = 0; axis < 3; ++axis) t.world_from_index[axis][axis] = scale[axis];
        file.pass(4 * 3 * sizeof(double));  // what follows from it
        return t;
    }
    if (moves) return t;
    if (map != "NonlinearFrustumMap")
        throw VolumeFault(fmt::format("it is damaged, or its transform '{}' is of an unknown kind", map));
    file.pass(8 * sizeof(double));  // a box, the taper, the depth, and the map behind them
    readTransform(file);
    return std::nullopt;
}

// "Tree_float_5_4_3" -> "float", where the tree has the usual nodes.
std::string valueTypeOf(const std::string& tree) {
    const std::size_t from = tree.find('_'), to = tree.find('_', from + 1);
    return from == std::string::npos || to == std::string::npos ? tree : tree.substr(from + 1, to - from - 1);
}

struct Offsets {
    bool known = false;
    std::int64_t grid = 0, blocks = 0, end = 0;
};

// The tree of another grid of the file: the same leaves under another name and
// transform.
void shareTree(const std::vector<VdbGrid>& grids, const std::vector<std::string>& unique_names,
               const std::string& parent, VdbGrid& grid, std::size_t& shared_leaves) {
    for (std::size_t i = 0; i < grids.size(); ++i) {
        if (unique_names[i] != parent) continue;
        // Few bytes may name a large tree again and again.
        shared_leaves += grids[i].leaves.size() + grids[i].tiles.size();
        if (shared_leaves > kMostShared)
            throw VolumeFault(
                fmt::format("its grids share more than {} leaves; save them in several files", kMostShared));
        VdbGrid shared = grids[i];
        shared.name = grid.name, shared.metadata = grid.metadata, shared.transform = grid.transform;
        grid = std::move(shared);
        return;
    }
    throw VolumeFault(fmt::format("it is damaged: grid {} shares a tree that is not there", grid.name));
}

class FileReader {
public:
    FileReader(const char* data, std::size_t size) : data_(data), file_(data, size) {}

    VdbFile read() {
        readHeader();
        VdbFile out;
        out.metadata = readMetadata(file_);
        const auto count = file_.number<std::int32_t>();
        for (std::int32_t i = 0; i < count; ++i) readGrid(out.grids, i + 1 == count);
        return out;
    }

private:
    void readHeader() {
        if (file_.left() < sizeof(kMagic) || file_.number<std::int64_t>() != kMagic)
            throw VolumeFault("it is no .vdb file");
        const auto version = file_.number<std::uint32_t>();
        if (version < kOldest)
            throw VolumeFault(
                fmt::format("it is damaged, or its format {} is older "
                            "than {} (OpenVDB 2.0, 2013); open "
                            "and save it with a program of today",
                            version, kOldest));
        file_.pass(2 * sizeof(std::uint32_t));  // the library's version
        has_offsets_ = file_.number<std::uint8_t>() != 0;
        file_.pass(36);  // a number that tells files apart
    }

    void readGrid(std::vector<VdbGrid>& grids, bool last) {
        const std::string unique_name = file_.text();
        std::string tree = file_.text();
        if (tree.ends_with(kHalfSuffix)) tree.resize(tree.size() - std::strlen(kHalfSuffix));
        const std::string parent = file_.text();
        Offsets offsets;
        offsets.known = has_offsets_;
        for (std::int64_t* o : {&offsets.grid, &offsets.blocks, &offsets.end}) *o = file_.number<std::int64_t>();

        const auto compression = file_.number<std::uint32_t>();
        VdbGrid grid;
        grid.metadata = readMetadata(file_);
        const auto named = grid.metadata.find("name");
        grid.name = named != grid.metadata.end() ? named->second : unique_name.substr(0, unique_name.find(kSuffix));
        grid.type = valueTypeOf(tree);
        grid.transform = readTransform(file_);
        const VdbValueType type = vdbValueType(grid.type);
        if (!parent.empty()) {
            shareTree(grids, unique_names_, parent, grid, shared_leaves_);
        } else if (type.bytes != 0 && tree == "Tree_" + grid.type + "_5_4_3") {
            const auto half = grid.metadata.find("is_saved_as_half_float");
            VdbTreeReader(file_, data_, grid, compression, half != grid.metadata.end() && half->second == "true")
                .read();
            grid.components = type.components;
        } else if (!last) {
            passOver(grid, offsets);
        }
        grids.push_back(std::move(grid));
        unique_names_.push_back(unique_name);
    }

    // A grid whose values nobody here knows.
    void passOver(const VdbGrid& grid, const Offsets& offsets) {
        if (!offsets.known)
            throw VolumeFault(
                fmt::format("its grid {} holds {} and stands before "
                            "others without saying where it ends; "
                            "save the file without it",
                            grid.name, grid.type));
        if (offsets.end < static_cast<std::int64_t>(file_.position()))
            throw VolumeFault(
                "it is damaged: a grid ends before it begins; write or "
                "copy it again");
        file_.seek(static_cast<std::size_t>(offsets.end));
    }

    const char* data_;
    ByteCursor file_;
    bool has_offsets_ = false;
    std::vector<std::string> unique_names_;
    std::size_t shared_leaves_ = 0;  // copies of leaves and tiles for grids that share a tree
};

}  // namespace

VdbFile parseVdb(const char* data, std::size_t size) { return FileReader(data, size).read(); }

}  // namespace photic
