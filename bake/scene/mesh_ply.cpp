// SPDX-License-Identifier: Apache-2.0
// Stanford PLY, ascii and binary little endian: vertex x y z (nx ny nz) and face vertex_indices; other elements and
// properties are stepped over.
#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstring>
#include <optional>

#include "bake/report/error.h"
#include "bake/scene/mesh_file.h"

namespace photic {
namespace {

static_assert(std::endian::native == std::endian::little, "binary PLY is read in place");

enum class Scalar { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float, Double };

std::optional<Scalar> scalarNamed(std::string_view name) {
    if (name == "char" || name == "int8") return Scalar::Int8;
    if (name == "uchar" || name == "uint8") return Scalar::Uint8;
    if (name == "short" || name == "int16") return Scalar::Int16;
    if (name == "ushort" || name == "uint16") return Scalar::Uint16;
    if (name == "int" || name == "int32") return Scalar::Int32;
    if (name == "uint" || name == "uint32") return Scalar::Uint32;
    if (name == "float" || name == "float32") return Scalar::Float;
    if (name == "double" || name == "float64") return Scalar::Double;
    return std::nullopt;
}

struct Property {
    std::string name;
    Scalar type = Scalar::Float;
    std::optional<Scalar> list_count;  // set: a list
};

struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
};

class PlyReader {
public:
    PlyReader(std::string_view bytes, const std::string& path) : rest_(bytes), path_(path) {}

    RawMesh read() {
        readHeader();
        for (const Element& element : elements_)
            for (std::size_t i = 0; i < element.count; ++i) readItem(element, i);
        if (!has_normals_) mesh_.normals.clear();
        return std::move(mesh_);
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw Error(ErrorCode::Input, fmt::format("'{}': {}", path_, what));
    }

    std::string_view headerLine() {
        const std::size_t end = rest_.find('\n');
        if (end == rest_.npos) fail("the PLY header has no end_header; the file is truncated or no PLY");
        std::string_view line = rest_.substr(0, end);
        rest_.remove_prefix(end + 1);
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        return line;
    }

    static std::vector<std::string> words(std::string_view line) {
        std::vector<std::string> out;
        for (std::size_t from = line.find_first_not_of(" \t"); from != line.npos;
             from = line.find_first_not_of(" \t", from)) {
            const std::size_t to = std::min(line.find_first_of(" \t", from), line.size());
            out.emplace_back(line.substr(from, to - from));
            from = to;
        }
        return out;
    }

    Scalar scalar(const std::string& name) const {
        const auto type = scalarNamed(name);
        if (!type) fail(fmt::format("unknown PLY type '{}'", name));
        return *type;
    }

    void readHeader() {
        if (headerLine() != "ply") fail("not a PLY file: its first line is not 'ply'");
        for (;;) {
            const std::vector<std::string> line = words(headerLine());
            if (line.empty() || line[0] == "comment" || line[0] == "obj_info") continue;
            if (line[0] == "end_header") break;
            if (line[0] == "format" && line.size() >= 2) {
                if (line[1] != "ascii" && line[1] != "binary_little_endian")
                    fail(fmt::format("PLY format '{}' is not read; save as ascii or binary_little_endian", line[1]));
                ascii_ = line[1] == "ascii";
            } else if (line[0] == "element" && line.size() == 3) {
                std::size_t count = 0;
                const auto [end, status] = std::from_chars(line[2].data(), line[2].data() + line[2].size(), count);
                if (status != std::errc() || *end != '\0') fail(fmt::format("'{}' is no number of elements", line[2]));
                elements_.push_back({line[1], count, {}});
            } else if (line[0] == "property" && !elements_.empty() && line.size() == 3) {
                elements_.back().properties.push_back({line[2], scalar(line[1]), std::nullopt});
            } else if (line[0] == "property" && !elements_.empty() && line.size() == 5 && line[1] == "list") {
                elements_.back().properties.push_back({line[4], scalar(line[3]), scalar(line[2])});
            } else {
                fail(fmt::format("the PLY header line '{} ...' is not understood", line[0]));
            }
        }
        for (const Element& element : elements_) {
            if (element.properties.empty() && element.count > 0)
                fail(fmt::format("element '{}' has no properties", element.name));
            // Every item takes a byte at least: a count beyond that is a damaged header, not a reason to allocate.
            if (element.count > rest_.size())
                fail(fmt::format("claims {} of '{}' in {} bytes; the file is truncated", element.count, element.name,
                                 rest_.size()));
        }
    }

    template <typename T>
    double binary(const std::string& element, std::size_t item) {
        if (rest_.size() < sizeof(T)) fail(fmt::format("ends within {} {}; the file is truncated", element, item));
        T value;
        std::memcpy(&value, rest_.data(), sizeof(T));
        rest_.remove_prefix(sizeof(T));
        return static_cast<double>(value);
    }

    double next(Scalar type, const std::string& element, std::size_t item) {
        if (ascii_) {
            const std::size_t from = rest_.find_first_not_of(" \t\r\n");
            if (from == rest_.npos) fail(fmt::format("ends within {} {}; the file is truncated", element, item));
            const std::size_t to = std::min(rest_.find_first_of(" \t\r\n", from), rest_.size());
            std::string_view word = rest_.substr(from, to - from);
            rest_.remove_prefix(to);
            if (word.front() == '+') word.remove_prefix(1);
            double value = 0;
            const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
            if (status != std::errc() || end != word.data() + word.size())
                fail(fmt::format("'{}' in {} {} is no number", word, element, item));
            return value;
        }
        switch (type) {
            case Scalar::Int8:
                return binary<std::int8_t>(element, item);
            case Scalar::Uint8:
                return binary<std::uint8_t>(element, item);
            case Scalar::Int16:
                return binary<std::int16_t>(element, item);
            case Scalar::Uint16:
                return binary<std::uint16_t>(element, item);
            case Scalar::Int32:
                return binary<std::int32_t>(element, item);
            case Scalar::Uint32:
                return binary<std::uint32_t>(element, item);
            case Scalar::Float:
                return binary<float>(element, item);
            case Scalar::Double:
                return binary<double>(element, item);
        }
        return 0;
    }

    void readItem(const Element& element, std::size_t item) {
        const bool vertex = element.name == "vertex", face = element.name == "face";
        glm::dvec3 position(0), normal(0);
        bool has_position[3] = {};
        for (const Property& property : element.properties) {
            if (property.list_count) {
                const double count = next(*property.list_count, element.name, item);
                const bool corners = face && (property.name == "vertex_indices" || property.name == "vertex_index");
                if (!(count >= 0) || count > static_cast<double>(rest_.size()))
                    fail(fmt::format("{} {} claims a list of {}; the file is damaged or truncated", element.name, item,
                                     count));
                std::vector<double> list(static_cast<std::size_t>(count));
                for (double& value : list) value = next(property.type, element.name, item);
                if (corners) addFace(list, item);
                continue;
            }
            const double value = next(property.type, element.name, item);
            if (!vertex) continue;
            for (int axis = 0; axis < 3; ++axis) {
                const char letter = static_cast<char>('x' + axis);
                if (property.name == std::string(1, letter)) position[axis] = value, has_position[axis] = true;
                if (property.name == std::string("n") + letter) normal[axis] = value, has_normals_ = true;
            }
        }
        if (!vertex) return;
        if (!has_position[0] || !has_position[1] || !has_position[2]) fail("its vertices have no x, y and z");
        mesh_.positions.push_back(position);
        mesh_.normals.push_back(normal);
    }

    void addFace(const std::vector<double>& list, std::size_t item) {
        if (list.size() < 3) fail(fmt::format("face {} has {} corners; at least 3 are needed", item, list.size()));
        std::vector<std::uint32_t> corners;
        for (const double index : list) {
            if (!(index >= 0 && index < static_cast<double>(mesh_.positions.size())))
                fail(fmt::format("face {} uses vertex {}, which is out of range; the file has {}", item, index,
                                 mesh_.positions.size()));
            corners.push_back(static_cast<std::uint32_t>(index));
        }
        for (std::size_t i = 2; i < corners.size(); ++i)
            mesh_.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }

    std::string_view rest_;
    const std::string& path_;
    bool ascii_ = true, has_normals_ = false;
    std::vector<Element> elements_;
    RawMesh mesh_;
};

}  // namespace

RawMesh readPly(const std::string& bytes, const std::string& path) { return PlyReader(bytes, path).read(); }

}  // namespace photic
