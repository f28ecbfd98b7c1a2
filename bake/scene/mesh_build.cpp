// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <numeric>

#include "bake/image/atomic_file.h"
#include "bake/report/error.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/plain_text.h"

namespace photic {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr double kWeldDistance = 1e-9;  // of the mesh's extent

/// For each vertex the lowest-numbered vertex in the same place.
std::vector<std::uint32_t> weldTargets(const std::vector<glm::dvec3>& positions) {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (const glm::dvec3& p : positions) low = glm::min(low, p), high = glm::max(high, p);
    const double near = kWeldDistance * glm::length(high - low);

    // Sorted along an irrational direction, vertices in the same place are neighbours and few others are.
    const glm::dvec3 axis(0.5773, 0.6180339887, 0.7548776662);
    std::vector<double> along(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) along[i] = glm::dot(axis, positions[i] - low);
    std::vector<std::uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return along[a] != along[b] ? along[a] < along[b] : a < b; });

    std::vector<std::uint32_t> target(positions.size());
    std::iota(target.begin(), target.end(), 0u);
    const auto root = [&](std::uint32_t i) {
        while (target[i] != i) i = target[i] = target[target[i]];
        return i;
    };
    const double reach = near * glm::length(axis);
    for (std::size_t i = 0; i < order.size(); ++i)
        for (std::size_t j = i + 1; j < order.size() && along[order[j]] - along[order[i]] <= reach; ++j) {
            if (glm::length(positions[order[j]] - positions[order[i]]) > near) continue;
            const std::uint32_t a = root(order[i]), b = root(order[j]);
            target[std::max(a, b)] = std::min(a, b);
        }
    for (std::uint32_t i = 0; i < target.size(); ++i) target[i] = root(i);
    return target;
}

glm::dvec3 doubleArea(const std::vector<glm::dvec3>& p, const std::array<std::uint32_t, 3>& t) {
    return glm::cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
}

/// Area within rounding of 0, or two corners in one.
bool degenerate(const std::vector<glm::dvec3>& p, const std::array<std::uint32_t, 3>& t) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return true;
    const double longest =
        std::max({glm::length(p[t[1]] - p[t[0]]), glm::length(p[t[2]] - p[t[1]]), glm::length(p[t[0]] - p[t[2]])});
    return glm::length(doubleArea(p, t)) <= 1e-14 * longest * longest;
}

std::string extensionOf(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

/// Whether any vertex leans away from the flat face that it is a corner of.
bool shadedSmooth(const RawMesh& raw) {
    constexpr double kLeaning = 0.9994;  // cosine of 2 degrees
    if (raw.normals.empty()) return false;
    return std::any_of(raw.triangles.begin(), raw.triangles.end(), [&](const std::array<std::uint32_t, 3>& triangle) {
        const glm::dvec3 face = doubleArea(raw.positions, triangle);
        const double area = glm::length(face);
        return area > 0 && std::any_of(triangle.begin(), triangle.end(), [&](std::uint32_t corner) {
                   const double length = glm::length(raw.normals[corner]);
                   return length > 0 && std::fabs(glm::dot(raw.normals[corner], face)) < kLeaning * length * area;
               });
    });
}

}  // namespace

bool addPolygon(RawMesh& mesh, const std::vector<std::uint32_t>& corners) {
    const std::size_t n = corners.size();
    const auto triangle = [&](std::size_t apex, std::size_t i) {
        return std::array{corners[apex], corners[(apex + i - 1) % n], corners[(apex + i) % n]};
    };
    // The polygon's own area vector is the same from every apex; no triangle of a fan that fits turns against it.
    glm::dvec3 area(0);
    for (std::size_t i = 2; i < n; ++i) area += doubleArea(mesh.positions, triangle(0, i));
    for (std::size_t apex = 0; apex < n; ++apex) {
        bool fits = true;
        // Rounding lets triangles in a line turn by a little.
        for (std::size_t i = 2; i < n && fits && n > 3; ++i)
            fits = !(glm::dot(doubleArea(mesh.positions, triangle(apex, i)), area) < -1e-12 * glm::dot(area, area));
        if (!fits) continue;
        for (std::size_t i = 2; i < n; ++i) mesh.triangles.push_back(triangle(apex, i));
        return true;
    }
    return false;
}

namespace {

void checkRaw(const RawMesh& raw, const std::string& path) {
    for (std::size_t i = 0; i < raw.positions.size(); ++i) {
        const glm::dvec3& p = raw.positions[i];
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            throw Error(ErrorCode::Input, fmt::format("'{}': vertex {} is at ({}, {}, {}); positions must be finite",
                                                      path, i, p.x, p.y, p.z));
    }
    if (raw.triangles.empty())
        throw Error(ErrorCode::Input, fmt::format("'{}' has no triangles{}", path,
                                                  raw.holds.empty() ? "" : fmt::format("; it holds {}", raw.holds)));
}

/// Lets the triangles use welded vertices, and leaves out those without area.
/// @return the kept triangles with the file's own vertices
std::vector<std::array<std::uint32_t, 3>> weld(const std::vector<std::uint32_t>& target, const std::string& path,
                                               RawMesh& raw, Monitor& monitor) {
    std::size_t skipped = 0;
    std::vector<std::array<std::uint32_t, 3>> given;
    std::erase_if(raw.triangles, [&](std::array<std::uint32_t, 3>& triangle) {
        const std::array<std::uint32_t, 3> own = triangle;
        for (std::uint32_t& corner : triangle) corner = target[corner];
        const bool drop = degenerate(raw.positions, triangle);
        if (!drop) given.push_back(own);
        skipped += drop;
        return drop;
    });
    if (raw.triangles.empty())
        throw Error(ErrorCode::Input, fmt::format("'{}' has {} triangles, all without area", path, skipped));
    if (skipped > 0)
        monitor.warn(
            fmt::format("'{}': {} triangles without area were skipped, {} kept", path, skipped, raw.triangles.size()));
    return given;
}

/// Only vertices that a triangle uses live on, in their old order.
/// @return the new number of each old vertex, kNone where it has none
std::vector<std::uint32_t> keepUsed(const RawMesh& raw, TriangleMesh& mesh) {
    std::vector<std::uint32_t> renumbered(raw.positions.size(), kNone);
    for (const auto& triangle : raw.triangles)
        for (const std::uint32_t corner : triangle) renumbered[corner] = 0;
    for (std::size_t i = 0; i < renumbered.size(); ++i) {
        if (renumbered[i] == kNone) continue;
        renumbered[i] = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(raw.positions[i]);
    }
    for (const auto& t : raw.triangles)
        mesh.triangles.push_back({renumbered[t[0]], renumbered[t[1]], renumbered[t[2]]});
    return renumbered;
}

/// The file's normals, summed over welded vertices; area-weighted ones where it has none or they cancel.
/// @param vertex_of  the mesh's vertex of each of the file's normals, or kNone
void setNormals(const std::vector<glm::dvec3>& given, const std::vector<std::uint32_t>& vertex_of, TriangleMesh& mesh) {
    std::vector<glm::dvec3> faces(mesh.positions.size(), glm::dvec3(0));
    for (const auto& triangle : mesh.triangles)
        for (const std::uint32_t corner : triangle) faces[corner] += doubleArea(mesh.positions, triangle);
    mesh.normals.assign(mesh.positions.size(), glm::dvec3(0));
    for (std::size_t i = 0; i < given.size(); ++i) {
        const double length = glm::length(given[i]);
        if (vertex_of[i] != kNone && std::isfinite(length) && length > 0)
            mesh.normals[vertex_of[i]] += given[i] / length;
    }
    for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
        glm::dvec3& normal = mesh.normals[i];
        if (glm::length(normal) < 1e-6) normal = faces[i];
        normal = glm::length(normal) > 0 ? glm::normalize(normal) : glm::dvec3(0, 0, 1);
    }
}

}  // namespace

TriangleMesh buildMesh(RawMesh raw, UpAxis up, const std::string& path, Monitor& monitor) {
    checkRaw(raw, path);
    for (const std::string& warning : raw.warnings) monitor.warn(fmt::format("'{}': {}", path, warning));
    if (!raw.motion.empty()) monitor.warn(fmt::format("'{}': {}", path, raw.motion));
    if (up == UpAxis::Y) {
        const auto turn = [](glm::dvec3& v) { v = {v.x, -v.z, v.y}; };
        std::for_each(raw.positions.begin(), raw.positions.end(), turn);
        std::for_each(raw.normals.begin(), raw.normals.end(), turn);
    }

    TriangleMesh mesh;
    mesh.shaded_smooth = shadedSmooth(raw);
    std::vector<std::uint32_t> target = weldTargets(raw.positions);
    const std::vector<std::array<std::uint32_t, 3>> given = weld(target, path, raw, monitor);
    const std::vector<std::uint32_t> renumbered = keepUsed(raw, mesh);
    for (std::uint32_t& vertex : target) vertex = renumbered[vertex];
    setNormals(raw.normals, target, mesh);
    mesh.corner_normals = creasedNormals(mesh, raw.normals, given);
    return mesh;
}

TriangleMesh withFacetNormals(const TriangleMesh& mesh) {
    TriangleMesh out;
    for (const auto& triangle : mesh.triangles) {
        const auto first = static_cast<std::uint32_t>(out.positions.size());
        const glm::dvec3 normal = glm::normalize(doubleArea(mesh.positions, triangle));
        for (const std::uint32_t corner : triangle) {
            out.positions.push_back(mesh.positions[corner]);
            out.normals.push_back(normal);
        }
        out.triangles.push_back({first, first + 1, first + 2});
    }
    return out;
}

bool isGltf(const std::string& path) {
    const std::string extension = extensionOf(path);
    return extension == ".gltf" || extension == ".glb";
}

RawMesh onlyParts(const RawMesh& mesh, const std::string& node, const std::string& material, const std::string& path) {
    const auto is = [](const std::string& wanted, const std::string& name, std::int64_t number) {
        return wanted.empty() || wanted == name || wanted == fmt::format("#{}", number);
    };
    RawMesh out;
    out.warnings = mesh.warnings;
    if (node.empty()) out.motion = mesh.motion;  // who names a node moves it by keyframes
    std::vector<std::string> names;
    for (const MeshPart& part : mesh.parts) {
        const bool of_node = is(node, part.node_name, static_cast<std::int64_t>(part.node));
        const std::string& name = of_node ? part.material_name : part.node_name;
        if (names.size() < 8 && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
        if (!of_node || !is(material, part.material_name, part.material)) continue;
        const auto first = mesh.triangles.begin() + static_cast<std::ptrdiff_t>(part.first);
        out.triangles.insert(out.triangles.end(), first, first + static_cast<std::ptrdiff_t>(part.count));
    }
    if (out.triangles.empty())
        throw Error(ErrorCode::Input, fmt::format("'{}' has no triangle of the node '{}'{}; it has {}", path, node,
                                                  material.empty() ? "" : " with the material '" + material + "'",
                                                  visible(fmt::format("'{}'", fmt::join(names, "', '")))));
    // The vertices of a part follow one another: those of all others are left where they are.
    std::uint32_t first = kNone, last = 0;
    for (const auto& triangle : out.triangles)
        for (const std::uint32_t corner : triangle) first = std::min(first, corner), last = std::max(last, corner);
    for (auto& triangle : out.triangles)
        for (std::uint32_t& corner : triangle) corner -= first;
    const auto range = [&](const std::vector<glm::dvec3>& from, std::vector<glm::dvec3>& to) {
        if (!from.empty()) to.assign(from.begin() + first, from.begin() + last + 1);
    };
    range(mesh.positions, out.positions), range(mesh.normals, out.normals);
    return out;
}

TriangleMesh loadMesh(const std::string& path, std::optional<UpAxis> up, Monitor& monitor,
                      const std::function<void(std::string_view)>& use_bytes) {
    const std::string extension = extensionOf(path);
    const bool gltf = isGltf(path);
    if (!gltf && extension != ".obj" && extension != ".ply")
        throw Error(ErrorCode::Input,
                    fmt::format("'{}' is no mesh that can be read; .obj, .ply, .gltf and .glb can", path));
    const std::string bytes = readFileBytes(path);
    use_bytes(bytes);
    RawMesh raw = gltf                  ? readGltf(bytes, path, use_bytes)
                  : extension == ".obj" ? readObj(bytes, path)
                                        : readPly(bytes, path);
    return buildMesh(std::move(raw), up.value_or(gltf ? UpAxis::Y : UpAxis::Z), path, monitor);
}

TriangleMesh boxMesh(const glm::dvec3& min, const glm::dvec3& max) {
    TriangleMesh welded;
    for (int i = 0; i < 8; ++i)
        welded.positions.emplace_back(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z);
    welded.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                        {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return withFacetNormals(welded);
}

TriangleMesh sphereMesh(const glm::dvec3& center, double radius, int rings) {
    // Rings of latitude between two poles; 2 * rings columns of longitude.
    TriangleMesh mesh;
    const int columns = 2 * rings;
    const auto add = [&](const glm::dvec3& normal) {
        mesh.positions.push_back(center + radius * normal);
        mesh.normals.push_back(normal);
    };
    add({0, 0, 1});
    for (int r = 1; r < rings; ++r)
        for (int c = 0; c < columns; ++c) {
            const double polar = std::numbers::pi * r / rings, azimuth = 2 * std::numbers::pi * c / columns;
            add({std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)});
        }
    add({0, 0, -1});
    const auto at = [&](int r, int c) { return static_cast<std::uint32_t>(1 + (r - 1) * columns + c % columns); };
    const auto bottom = static_cast<std::uint32_t>(mesh.positions.size() - 1);
    for (int c = 0; c < columns; ++c) {
        mesh.triangles.push_back({0, at(1, c), at(1, c + 1)});
        for (int r = 1; r + 1 < rings; ++r) {
            mesh.triangles.push_back({at(r, c), at(r + 1, c), at(r + 1, c + 1)});
            mesh.triangles.push_back({at(r, c), at(r + 1, c + 1), at(r, c + 1)});
        }
        mesh.triangles.push_back({bottom, at(rings - 1, c + 1), at(rings - 1, c)});
    }
    return mesh;
}

}  // namespace photic
