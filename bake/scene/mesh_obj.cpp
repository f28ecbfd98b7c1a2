// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ: v, vn and f. What else shapes a surface (curves, patches) is refused by name; the rest of the format
// is about looks and is passed over. Read here because messages name the line that is wrong.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <unordered_map>

#include "bake/report/error.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/plain_text.h"

namespace photic {
namespace {

class ObjReader {
public:
    explicit ObjReader(const std::string& path) : path_(path) {}

    RawMesh read(std::string_view text) {
        std::string joined;
        while (!text.empty()) {
            std::string_view line = takeLine(text);
            ++line_;
            std::size_t taken = 0;
            // A backslash at its end goes on with the next line; in a comment it belongs to a Windows path.
            if (!line.empty() && line.back() == '\\' && line.front() != '#') {
                joined.clear();
                for (; !line.empty() && line.back() == '\\'; line = takeLine(text), ++taken)
                    joined.append(line.substr(0, line.size() - 1)) += ' ';
                line = joined.append(line);
            }
            readLine(line);
            line_ += taken;
        }
        mesh_.holds =
            fmt::format("{} vertices, {} lines and {} points, but no face", positions_.size(), lines_, points_);
        if (positions_.empty() && !first_line_.empty())
            mesh_.holds += fmt::format("; it begins with '{}'", excerpt(first_line_));
        return std::move(mesh_);
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw Error(ErrorCode::Input, fmt::format("'{}' line {}: {}", path_, line_, what));
    }

    static std::string_view nextWord(std::string_view& rest) {
        const std::size_t from = std::min(rest.find_first_not_of(" \t\r"), rest.size());
        const std::size_t to = std::min(rest.find_first_of(" \t\r", from), rest.size());
        const std::string_view word = rest.substr(from, to - from);
        rest.remove_prefix(to);
        return word;
    }

    double number(std::string_view& rest) const {
        std::string_view word = nextWord(rest);
        if (!word.empty() && word.front() == '+') word.remove_prefix(1);
        double value = 0;
        const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (status != std::errc() || end != word.data() + word.size())
            fail(fmt::format("'{}' is no number", excerpt(word)));
        return value;
    }

    glm::dvec3 vector(std::string_view& rest) const {
        const double x = number(rest), y = number(rest), z = number(rest);
        return {x, y, z};
    }

    /// A 1-based index, or one that counts back from the last, as 0-based.
    std::size_t index(std::string_view word, std::size_t count, const char* what) const {
        long long value = 0;
        const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (status != std::errc() || end != word.data() + word.size())
            fail(fmt::format("'{}' is no index", excerpt(word)));
        const long long limit = static_cast<long long>(count);
        if (value == 0 || value > limit || value < -limit)
            fail(fmt::format("{} {} is out of range; {} are defined so far", what, value, count));
        return static_cast<std::size_t>(value > 0 ? value - 1 : limit + value);
    }

    /// The mesh's vertex for a corner "v", "v/vt", "v//vn" or "v/vt/vn".
    std::uint32_t corner(std::string_view word) {
        const std::size_t slash = word.find('/'), second = slash == word.npos ? word.npos : word.find('/', slash + 1);
        const std::size_t v = index(word.substr(0, slash), positions_.size(), "vertex");
        const std::size_t n = second == word.npos || second + 1 == word.size()
                                  ? 0
                                  : index(word.substr(second + 1), normals_.size(), "normal") + 1;
        const auto [place, fresh] =
            corners_.try_emplace(std::uint64_t(v) << 32 | n, static_cast<std::uint32_t>(mesh_.positions.size()));
        if (fresh) {
            mesh_.positions.push_back(positions_[v]);
            mesh_.normals.push_back(n > 0 ? normals_[n - 1] : glm::dvec3(0));
        }
        return place->second;
    }

    void readLine(std::string_view rest) {
        if (first_line_.empty()) first_line_ = rest;
        const std::string_view key = nextWord(rest);
        if (key == "v") {
            positions_.push_back(vector(rest));
        } else if (key == "vn") {
            normals_.push_back(vector(rest));
        } else if (key == "f" || key == "fo") {  // "fo" is what its first version called a face
            std::vector<std::uint32_t> polygon;
            // A comment may end the line.
            for (std::string_view word = nextWord(rest); !word.empty() && word.front() != '#'; word = nextWord(rest))
                polygon.push_back(corner(word));
            if (polygon.size() < 3) fail(fmt::format("a face has {} corners; at least 3 are needed", polygon.size()));
            if (!addPolygon(mesh_, polygon))
                fail(fmt::format(
                    "a face of {} corners is too hollow to be cut into triangles; triangulate it before export",
                    polygon.size()));
        } else if (key == "l") {
            ++lines_;
        } else if (key == "p") {
            ++points_;
        } else if (std::find(kSmoothShapes.begin(), kSmoothShapes.end(), key) != kSmoothShapes.end()) {
            fail(fmt::format("'{}' belongs to a curve or a curved patch, which is not read; export triangles", key));
        } else if (key == "call") {
            fail(fmt::format("'call' takes in the file '{}', which is not read; export all in one file",
                             excerpt(nextWord(rest))));
        } else if (key.find('\0') != key.npos) {
            fail("it holds bytes that are no text; the file is damaged or no OBJ");
        }
    }

    // The free-form part of the format.
    static constexpr std::array<std::string_view, 9> kSmoothShapes{"curv", "curv2", "surf", "cstype", "bmat",
                                                                   "trim", "bzp",   "bsp",  "cdc"};

    const std::string& path_;
    std::size_t line_ = 0, lines_ = 0, points_ = 0;
    std::string first_line_;
    std::vector<glm::dvec3> positions_, normals_;
    std::unordered_map<std::uint64_t, std::uint32_t> corners_;
    RawMesh mesh_;
};

}  // namespace

RawMesh readObj(const std::string& bytes, const std::string& path) {
    return ObjReader(path).read(plainText(bytes, path));
}

}  // namespace photic
