// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <tuple>
#include <vector>

#include "bake/scene/mesh_file.h"

namespace photic {
namespace {

constexpr double kSharp = 0.766;  // cosine of 40 degrees, as of bodies whose edges are all sharp
constexpr double kAlike = 0.996;  // cosine of 5 degrees: normals on either side of an edge that a file shades smooth

using Corners = std::array<std::uint32_t, 3>;

glm::dvec3 doubleArea(const TriangleMesh& mesh, const Corners& t) {
    return glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
}

/// The face's unit normal times the angle at a corner: a quadrilateral counts alike however it is cut in two [Thuermer
/// and Wuethrich 1998].
glm::dvec3 weightedFace(const TriangleMesh& mesh, const Corners& t, std::uint32_t corner) {
    const glm::dvec3& at = mesh.positions[t[corner]];
    const glm::dvec3 a = glm::normalize(mesh.positions[t[(corner + 1) % 3]] - at),
                     b = glm::normalize(mesh.positions[t[(corner + 2) % 3]] - at);
    return glm::normalize(doubleArea(mesh, t)) * std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// A side of a triangle, from its lower to its higher vertex.
struct Side {
    std::uint32_t low = 0, high = 0;
    std::uint32_t low_corner = 0, high_corner = 0;  ///< 3 x triangle + corner
    bool upwards = false;                           ///< the triangle runs from the lower to the higher
};

std::vector<Side> sidesOf(const TriangleMesh& mesh) {
    std::vector<Side> sides;
    sides.reserve(3 * mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::uint32_t e = 0; e < 3; ++e) {
            const std::uint32_t next = (e + 1) % 3, a = mesh.triangles[t][e], b = mesh.triangles[t][next];
            const bool upwards = a < b;
            sides.push_back(
                {std::min(a, b), std::max(a, b), 3 * t + (upwards ? e : next), 3 * t + (upwards ? next : e), upwards});
        }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::tie(a.low, a.high, a.low_corner) < std::tie(b.low, b.high, b.low_corner);
    });
    return sides;
}

/// Corners that share a vertex and hang together over smooth edges.
class SmoothGroups {
public:
    explicit SmoothGroups(std::size_t corners) {
        for (std::size_t i = 0; i < corners; ++i) parent_.push_back(static_cast<std::uint32_t>(i));
    }
    std::uint32_t of(std::uint32_t corner) {
        while (parent_[corner] != corner) corner = parent_[corner] = parent_[parent_[corner]];
        return corner;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = of(a), b = of(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

private:
    std::vector<std::uint32_t> parent_;
};

}  // namespace

std::vector<std::array<glm::dvec3, 3>> creasedNormals(const TriangleMesh& mesh, const std::vector<glm::dvec3>& given,
                                                      const std::vector<Corners>& vertex_of) {
    const auto givenAt = [&](std::uint32_t corner) {
        if (given.empty()) return glm::dvec3(0);
        const glm::dvec3& normal = given[vertex_of[corner / 3][corner % 3]];
        const double length = glm::length(normal);
        return std::isfinite(length) && length > 0 ? normal / length : glm::dvec3(0);
    };
    const auto areSmooth = [&](const Side& a, const Side& b) {
        const glm::dvec3 n = doubleArea(mesh, mesh.triangles[a.low_corner / 3]),
                         m = doubleArea(mesh, mesh.triangles[b.low_corner / 3]);
        const double turn = glm::dot(n, m) / (glm::length(n) * glm::length(m)) * (a.upwards == b.upwards ? -1 : 1);
        // What a file shades smooth is meant to be round, however few its faces are; and what it parts is meant to be
        // sharp, unless it parts all: then it only says that its faces are flat.
        const auto isAlike = [&](std::uint32_t p, std::uint32_t q) {
            return glm::dot(givenAt(p), givenAt(q)) > kAlike;
        };
        const bool alike = isAlike(a.low_corner, b.low_corner) && isAlike(a.high_corner, b.high_corner);
        const auto isTold = [&](const Side& side) {
            return givenAt(side.low_corner) != glm::dvec3(0) && givenAt(side.high_corner) != glm::dvec3(0);
        };
        return alike || (turn >= kSharp && !(mesh.shaded_smooth && isTold(a) && isTold(b)));
    };
    const std::vector<Side> sides = sidesOf(mesh);
    SmoothGroups groups(3 * mesh.triangles.size());
    bool creases = false;
    for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
        for (end = i + 1; end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high;)
            ++end;
        if (end - i != 2) continue;  // a rim, or a junction of several sheets
        if (areSmooth(sides[i], sides[i + 1]))
            groups.join(sides[i].low_corner, sides[i + 1].low_corner),
                groups.join(sides[i].high_corner, sides[i + 1].high_corner);
        else
            creases = true;
    }
    if (!creases) return {};

    std::vector<glm::dvec3> faces(3 * mesh.triangles.size(), glm::dvec3(0)), of_file = faces;
    for (std::uint32_t corner = 0; corner < faces.size(); ++corner) {
        const std::uint32_t group = groups.of(corner);
        faces[group] += weightedFace(mesh, mesh.triangles[corner / 3], corner % 3);
        of_file[group] += givenAt(corner);
    }
    std::vector<std::array<glm::dvec3, 3>> out(mesh.triangles.size());
    for (std::uint32_t corner = 0; corner < faces.size(); ++corner) {
        const std::uint32_t group = groups.of(corner);
        const glm::dvec3 sum = glm::length(of_file[group]) < 1e-6 ? faces[group] : of_file[group];
        out[corner / 3][corner % 3] =
            glm::length(sum) > 0 ? glm::normalize(sum) : mesh.normals[mesh.triangles[corner / 3][corner % 3]];
    }
    return out;
}

TriangleMesh withCreases(const TriangleMesh& mesh) {
    if (mesh.corner_normals.empty()) return mesh;
    TriangleMesh out;
    out.shaded_smooth = mesh.shaded_smooth;
    std::map<std::tuple<std::uint32_t, double, double, double>, std::uint32_t> places;
    out.triangles = mesh.triangles;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t c = 0; c < 3; ++c) {
            const glm::dvec3& normal = mesh.corner_normals[t][c];
            const std::uint32_t vertex = mesh.triangles[t][c];
            const auto [at, fresh] = places.emplace(std::tuple{vertex, normal.x, normal.y, normal.z},
                                                    static_cast<std::uint32_t>(out.positions.size()));
            if (fresh) out.positions.push_back(mesh.positions[vertex]), out.normals.push_back(normal);
            out.triangles[t][c] = at->second;
        }
    return out;
}

}  // namespace photic
