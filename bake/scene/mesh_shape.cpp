// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/mesh_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <numeric>
#include <vector>

namespace photic {
namespace {

/// A side of a triangle, from its lower to its higher vertex.
struct EdgeUse {
    std::uint64_t edge = 0;
    std::uint32_t triangle = 0;
    bool upwards = false;  ///< the triangle runs it from the lower vertex to the higher
};

std::vector<EdgeUse> edgeUses(const TriangleMesh& mesh) {
    std::vector<EdgeUse> uses;
    uses.reserve(3 * mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t e = 0; e < 3; ++e) {
            const std::uint32_t a = mesh.triangles[t][e], b = mesh.triangles[t][(e + 1) % 3];
            uses.push_back({std::uint64_t(std::min(a, b)) << 32 | std::max(a, b), t, a < b});
        }
    std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
        return a.edge != b.edge ? a.edge < b.edge : a.triangle < b.triangle;
    });
    return uses;
}

/// Whether all edges are those of flat faces: no low number of triangles stands for something round.
bool isFaceted(const TriangleMesh& mesh, const std::vector<EdgeUse>& uses) {
    constexpr double kFlat = 1 - 6e-8, kSharp = 0.766;  // cosines of 0.02 degrees, as of rounded positions, and of 40
    const auto normal = [&](std::uint32_t t) {
        const auto& c = mesh.triangles[t];
        const glm::dvec3 cross =
            glm::cross(mesh.positions[c[1]] - mesh.positions[c[0]], mesh.positions[c[2]] - mesh.positions[c[0]]);
        return glm::length(cross) > 0 ? glm::normalize(cross) : glm::dvec3(0);
    };
    bool sharp = false;
    for (std::size_t i = 0; i + 1 < uses.size(); ++i) {
        if (uses[i].edge != uses[i + 1].edge) continue;
        const double turn = glm::dot(normal(uses[i].triangle), normal(uses[i + 1].triangle)) *
                            (uses[i].upwards == uses[i + 1].upwards ? -1 : 1);
        if (turn > kFlat) continue;
        if (turn > kSharp) return false;
        sharp = true;
    }
    return sharp;
}

std::size_t countDoubled(const TriangleMesh& mesh) {
    std::vector<std::array<std::uint32_t, 3>> sorted = mesh.triangles;
    for (auto& t : sorted) std::sort(t.begin(), t.end());
    std::sort(sorted.begin(), sorted.end());
    return sorted.size() - static_cast<std::size_t>(std::unique(sorted.begin(), sorted.end()) - sorted.begin());
}

/// Triangles joined over edges, each with its winding against the one that stands for its part.
class Parts {
public:
    explicit Parts(std::size_t triangles) : parent_(triangles), turned_(triangles, 0) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }
    std::uint32_t root(std::uint32_t t) {
        std::uint32_t top = t;
        char turned = 0;
        for (; parent_[top] != top; top = parent_[top]) turned ^= turned_[top];
        // All on the way hang below the root from now on.
        while (parent_[t] != t) {
            const std::uint32_t next = parent_[t];
            const char own = turned_[t];
            parent_[t] = top, turned_[t] = turned;
            turned ^= own, t = next;
        }
        return top;
    }
    bool turned(std::uint32_t t) { return root(t) != t && turned_[t]; }
    /// `against`: the two run their common edge in the same direction.
    void join(std::uint32_t a, std::uint32_t b, bool against) {
        const std::uint32_t top_a = root(a), top_b = root(b);
        if (top_a == top_b) return;  // a strip that is twisted once has no winding to agree on
        const char relation = static_cast<char>((turned(a) ? 1 : 0) ^ (turned(b) ? 1 : 0) ^ (against ? 1 : 0));
        parent_[top_b] = top_a, turned_[top_b] = relation;
    }

private:
    std::vector<std::uint32_t> parent_;
    std::vector<char> turned_;  ///< against its parent
};

struct PartSums {
    std::size_t turned = 0, count = 0;
    double turned_area = 0, area = 0, volume = 0;
    bool open = false;
};

}  // namespace

MeshShape shapeOf(const TriangleMesh& mesh) {
    MeshShape shape;
    shape.doubled = countDoubled(mesh);
    const std::vector<EdgeUse> uses = edgeUses(mesh);
    shape.faceted = isFaceted(mesh, uses);
    Parts parts(mesh.triangles.size());
    std::vector<PartSums> sums(mesh.triangles.size());
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
        for (end = i + 1; end < uses.size() && uses[end].edge == uses[i].edge;) ++end;
        // Three at an edge are a junction, whose sheets may be wound in any way.
        for (std::size_t k = i + 1; k < end; ++k)
            parts.join(uses[i].triangle, uses[k].triangle, end - i == 2 && uses[i].upwards == uses[k].upwards);
    }
    for (std::size_t i = 0; i < uses.size(); ++i)
        if ((i == 0 || uses[i - 1].edge != uses[i].edge) && (i + 1 == uses.size() || uses[i + 1].edge != uses[i].edge))
            sums[parts.root(uses[i].triangle)].open = true;

    double area = 0, turned_area = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& corner = mesh.triangles[t];
        const glm::dvec3 &a = mesh.positions[corner[0]], &b = mesh.positions[corner[1]], &c = mesh.positions[corner[2]];
        PartSums& part = sums[parts.root(t)];
        const double size = 0.5 * glm::length(glm::cross(b - a, c - a));
        const bool turned = parts.turned(t);
        part.count += 1, part.area += size;
        if (turned) part.turned += 1, part.turned_area += size;
        // From a vertex of the mesh, so that a place far from the origin costs no digits.
        const glm::dvec3& o = mesh.positions.front();
        part.volume += glm::dot(a - o, glm::cross(b - o, c - o)) / 6;
    }
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (parts.root(t) != t) continue;
        const PartSums& part = sums[t];
        ++shape.parts;
        const bool most_turned = part.turned_area > 0.5 * part.area;
        shape.turned += most_turned ? part.count - part.turned : part.turned;
        turned_area += most_turned ? part.area - part.turned_area : part.turned_area, area += part.area;
        if (part.open) continue;
        ++shape.closed_parts, shape.volume += part.volume;
        if (shape.closed_parts > 1) continue;
        std::vector<std::uint32_t> vertices;
        for (std::uint32_t other = 0; other < mesh.triangles.size(); ++other)
            if (parts.root(other) == t)
                vertices.insert(vertices.end(), mesh.triangles[other].begin(), mesh.triangles[other].end());
        std::sort(vertices.begin(), vertices.end());
        vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
        glm::dvec3 middle(0);
        for (const std::uint32_t v : vertices) middle += mesh.positions[v] / static_cast<double>(vertices.size());
        shape.a_closed_part =
            fmt::format("{} vertices around ({:.4g}, {:.4g}, {:.4g})", vertices.size(), middle.x, middle.y, middle.z);
    }
    shape.turned_share = area > 0 ? turned_area / area : 0;
    return shape;
}

}  // namespace photic
