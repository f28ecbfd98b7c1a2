// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bake/report/monitor.h"
#include "bake/scene/triangle_mesh.h"

namespace photic {

enum class UpAxis { Y, Z };

/// Triangles of a RawMesh that follow one another and that its file knows by a name: of a glTF, a node's of one
/// material.
struct MeshPart {
    std::size_t node = 0;
    std::string node_name;
    int material = -1;  ///< -1: none
    std::string material_name;
    std::size_t first = 0, count = 0;  ///< triangles
};

/// Triangles as a file gives them: any axes, split vertices, normals for all vertices or for none.
struct RawMesh {
    std::vector<glm::dvec3> positions;
    std::vector<glm::dvec3> normals;
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices into positions; checked by the readers
    std::vector<MeshPart> parts;                          ///< of glTF alone; they cover all triangles
    std::string holds;                  ///< what the file has where it has no triangles: "4 vertices, but no face"
    std::vector<std::string> warnings;  ///< what of the file was left out, and what would do
    std::string motion;                 ///< what of it moves, to be said where that is not read; or empty
};

/// Cuts a polygon of at least 3 corners into a fan of triangles from one of its corners, the first where it is convex.
/// @return false, with nothing added, for a hollow one that no fan covers
bool addPolygon(RawMesh& mesh, const std::vector<std::uint32_t>& corners);

/// Readers of one format each, from the file's bytes; `path` is for messages.
/// @throws Error{Input} with the line or element to blame
RawMesh readObj(const std::string& bytes, const std::string& path);
RawMesh readPly(const std::string& bytes, const std::string& path);
/// glTF 2.0, `.gltf` or `.glb`: the triangles of all nodes of the default scene in its world; images are not loaded.
/// External buffers are looked up beside `path`; `use_bytes` sees them.
RawMesh readGltf(const std::string& bytes, const std::string& path,
                 const std::function<void(std::string_view)>& use_bytes);

/// The triangles of some parts.
/// @param node, material  a name, or "#" and a number from 0; empty: all
/// @throws Error{Input} where there is none, with the names that there are
RawMesh onlyParts(const RawMesh& mesh, const std::string& node, const std::string& material, const std::string& path);

/// Turns to Z up ((x, y, z) -> (x, -z, y) from Y up), welds vertices nearer than 1e-9 of the extent, drops triangles
/// without area (one counted warning) and unused vertices, and gives normals: the file's, averaged over welded
/// vertices, or area-weighted ones.
/// @throws Error{Input} for positions that are not finite, with the vertex's number, and for meshes without area
TriangleMesh buildMesh(RawMesh raw, UpAxis up, const std::string& path, Monitor& monitor);

/// Every triangle with vertices and a normal of its own.
TriangleMesh withFacetNormals(const TriangleMesh& mesh);

/// Normals of each triangle's corners of a welded mesh, each the mean over the faces by their angle (or of the file's
/// normals) on its side of the creases. Where the file shades smoothly, these are the edges whose normals in the file
/// differ from side to side; otherwise edges of two triangles that meet at more than 40 degrees. Empty without creases.
/// @param given       the file's normals, or empty
/// @param vertex_of   the given normals of each triangle's corners
std::vector<std::array<glm::dvec3, 3>> creasedNormals(const TriangleMesh& mesh, const std::vector<glm::dvec3>& given,
                                                      const std::vector<std::array<std::uint32_t, 3>>& vertex_of);
/// The mesh with vertices of their own on either side of its creases.
TriangleMesh withCreases(const TriangleMesh& mesh);

/// Reads .obj, .ply, .gltf or .glb by the name's end.
/// @param up         Z up for OBJ and PLY and Y up for glTF where absent
/// @param use_bytes  sees the bytes of every file that was read
/// @throws Error{Input}
TriangleMesh loadMesh(const std::string& path, std::optional<UpAxis> up, Monitor& monitor,
                      const std::function<void(std::string_view)>& use_bytes);
/// Whether a file is glTF, by its name's end.
bool isGltf(const std::string& path);

/// A closed box with facet normals, outwards.
TriangleMesh boxMesh(const glm::dvec3& min, const glm::dvec3& max);
/// A closed sphere of 2 * rings * rings triangles with exact normals, outwards.
TriangleMesh sphereMesh(const glm::dvec3& center, double radius, int rings);

}  // namespace photic
