// SPDX-License-Identifier: Apache-2.0
// Stanford PLY, ascii and binary: vertex x y z (nx ny nz), face vertex_indices and tristrips, in any order; other
// elements and properties are stepped over.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <optional>

#include "bake/report/error.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/plain_text.h"

namespace photic {
namespace {

static_assert(std::endian::native == std::endian::little, "binary PLY is turned to the machine's order");

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
        for (const Element& element : elements_) {
            for (std::size_t i = 0; i < element.count; ++i) readItem(element, i);
            vertices_read_ = vertices_read_ || element.name == "vertex";
        }
        // Faces may stand before the vertices that they use.
        for (std::size_t i = 0; i < faces_.size(); ++i) addFace(faces_[i], i);
        for (std::size_t i = 0; i < strips_.size(); ++i) addStrip(strips_[i], i);
        if (!has_normals_) mesh_.normals.clear();
        for (const Element& element : elements_)
            mesh_.holds += fmt::format("{}{} of '{}'", mesh_.holds.empty() ? "" : ", ", element.count, element.name);
        if (mesh_.holds.empty()) mesh_.holds = "no element";
        if (has_other_lists_) mesh_.holds += "; the lists of 'face' are not called vertex_indices";
        return std::move(mesh_);
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw Error(ErrorCode::Input, fmt::format("'{}': {}", path_, what));
    }

    std::string_view headerLine() {
        const std::size_t end = rest_.find_first_of("\r\n");
        if (end == rest_.npos) fail("the PLY header has no end_header; the file is truncated or no PLY");
        const std::string_view line = rest_.substr(0, end);
        // Its first line tells how lines end: after the last one a binary file goes on with any byte.
        if (line_end_.empty()) line_end_ = rest_[end] == '\n' ? "\n" : rest_.substr(end, 2) == "\r\n" ? "\r\n" : "\r";
        rest_.remove_prefix(rest_.substr(end, line_end_.size()) == line_end_ ? end + line_end_.size() : end + 1);
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
                if (line[1] != "ascii" && line[1] != "binary_little_endian" && line[1] != "binary_big_endian")
                    fail(fmt::format("PLY format '{}' is not known; save as ascii or binary_little_endian",
                                     excerpt(line[1])));
                ascii_ = line[1] == "ascii", swapped_ = line[1] == "binary_big_endian";
            } else if (line[0] == "element" && line.size() == 3) {
                std::size_t count = 0;
                const auto [end, status] = std::from_chars(line[2].data(), line[2].data() + line[2].size(), count);
                if (status != std::errc() || *end != '\0') fail(fmt::format("'{}' is no number of elements", line[2]));
                for (const Element& element : elements_)
                    if (element.name == line[1]) fail(fmt::format("element '{}' is there twice", excerpt(line[1])));
                elements_.push_back({line[1], count, {}});
            } else if (line[0] == "property" && !elements_.empty() && line.size() == 3) {
                elements_.back().properties.push_back({line[2], scalar(line[1]), std::nullopt});
            } else if (line[0] == "property" && !elements_.empty() && line.size() == 5 && line[1] == "list") {
                elements_.back().properties.push_back({line[4], scalar(line[3]), scalar(line[2])});
            } else {
                fail(fmt::format("the PLY header line '{} ...' is not understood", excerpt(line[0])));
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
        char bytes[sizeof(T)];
        std::memcpy(bytes, rest_.data(), sizeof(T));
        if (swapped_) std::reverse(bytes, bytes + sizeof(T));
        T value;
        std::memcpy(&value, bytes, sizeof(T));
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
                fail(fmt::format("'{}' in {} {} is no number", excerpt(word), element, item));
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
        const bool vertex = element.name == "vertex", face = element.name == "face",
                   strips = element.name == "tristrips";
        glm::dvec3 position(0), normal(0);
        bool has_position[3] = {};
        for (const Property& property : element.properties) {
            if (property.list_count) {
                const double count = next(*property.list_count, element.name, item);
                const bool corners =
                    (face || strips) && (property.name == "vertex_indices" || property.name == "vertex_index");
                has_other_lists_ = has_other_lists_ || (face && !corners);
                if (!(count >= 0) || count > static_cast<double>(rest_.size()))
                    fail(fmt::format("{} {} claims a list of {}; the file is damaged or truncated", element.name, item,
                                     count));
                std::vector<double> list(static_cast<std::size_t>(count));
                for (double& value : list) value = next(property.type, element.name, item);
                if (corners && vertices_read_)
                    face ? addFace(list, item) : addStrip(list, item);
                else if (corners)
                    (face ? faces_ : strips_).push_back(std::move(list));
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

    std::uint32_t vertex(double index, const char* what, std::size_t item) const {
        if (!(index >= 0 && index < static_cast<double>(mesh_.positions.size())))
            fail(fmt::format("{} {} uses vertex {}, which is out of range; the file has {}", what, item, index,
                             mesh_.positions.size()));
        return static_cast<std::uint32_t>(index);
    }

    void addFace(const std::vector<double>& list, std::size_t item) {
        if (list.size() < 3) fail(fmt::format("face {} has {} corners; at least 3 are needed", item, list.size()));
        std::vector<std::uint32_t> corners;
        for (const double index : list) corners.push_back(vertex(index, "face", item));
        if (!addPolygon(mesh_, corners))
            fail(fmt::format(
                "face {} of {} corners is too hollow to be cut into triangles; triangulate it before export", item,
                corners.size()));
    }

    /// Every corner makes a triangle with the two before it, every other one turned about; -1 begins anew.
    void addStrip(const std::vector<double>& list, std::size_t item) {
        std::size_t begin = 0;
        for (std::size_t i = 0; i < list.size(); ++i) {
            if (list[i] == -1) begin = i + 1;
            if (i < begin + 2 || list[i] == -1) continue;
            std::array<std::uint32_t, 3> triangle{};
            for (std::size_t k = 0; k < 3; ++k) triangle[k] = vertex(list[i - 2 + k], "strip", item);
            if ((i - begin) % 2 == 1) std::swap(triangle[0], triangle[1]);
            mesh_.triangles.push_back(triangle);
        }
    }

    std::string_view rest_;
    const std::string& path_;
    std::string_view line_end_;
    bool ascii_ = true, swapped_ = false, has_normals_ = false, has_other_lists_ = false, vertices_read_ = false;
    std::vector<std::vector<double>> faces_, strips_;
    std::vector<Element> elements_;
    RawMesh mesh_;
};

}  // namespace

RawMesh readPly(const std::string& bytes, const std::string& path) {
    return PlyReader(plainText(bytes, path), path).read();
}

}  // namespace photic
