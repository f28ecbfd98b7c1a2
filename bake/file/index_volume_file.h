// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <string>
#include <vector>

#include "runtime/format/index_volume_format.h"

namespace photic {

/// Objects that the run-time library draws at a time.
inline constexpr std::size_t kMostObjectsDrawn = format::kIndexMostDrawn;

/// A shape with sharp faces: a mesh whose triangles are counterclockwise from outside, or, without triangles, a ball.
/// In nodes of its object; of a shape without samples its object's matrix says how large a node is.
struct SharpShape {
    enum class Faces {
        Glass,   ///< refract and reflect by Fresnel's equations
        Clear,   ///< refract everything, a transmittance of 1; beyond the critical angle they reflect
        Mirror,  ///< reflect `colour`
        Thin     ///< a pane without thickness: light goes straight on, less what its two faces reflect
    };
    Faces faces = Faces::Glass;
    glm::dvec3 index{1};  ///< n inside for red, green and blue, where the object has no spline
    unsigned rank = 0;    ///< where several are, that of the highest rank is what is there
    glm::dvec3 absorption{0};
    glm::dvec3 colour{1};
    glm::vec4 ball{0, 0, 0, 1};        ///< centre and radius [nodes]
    std::vector<glm::vec3> positions;  ///< [nodes]
    std::vector<glm::vec3>
        normals;  ///< covectors: world normal = transpose(inverse(world_from_node)) * this; empty: flat
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// One object of a file of index volumes (docs/index_volumes.md). Node (i, j, k) is at
/// origin_world + world_from_node * (i, j, k); arrays have x fastest and a value for each node.
struct IndexVolumeObject {
    std::string name;  ///< cut to 63 bytes
    glm::dmat3 world_from_node{1};
    glm::dvec3 origin_world{0};              ///< [m]
    glm::ivec3 count{0};                     ///< nodes
    std::vector<std::vector<float>> spline;  ///< one, or red, green and blue: coefficients of (n^2 - 1) / 2
    std::vector<glm::vec4> attenuation;      ///< absorption [1/m], how much is there; may be empty
    std::vector<glm::vec4> glow;             ///< emission [W/(m3 sr)], g; may be empty
    std::vector<std::uint8_t> faces;         ///< 255 around faces; may be empty
    glm::dvec3 scattering{0};                ///< [1/m]
    double anisotropy = 0;                   ///< g
    glm::vec3 box_low{0}, box_high{0};       ///< where the object is, in nodes
    bool sharp_sides = false;
    glm::dvec3 albedo{0};         ///< of faces
    double roughness = 0;         ///< of highlights on faces; 0: none
    std::vector<glm::vec3> coat;  ///< albedo of each node's faces, 0 to 1; empty where it is `albedo` everywhere
    std::optional<SharpShape> shape{};
    bool reflects() const { return !coat.empty() || albedo != glm::dvec3(0) || roughness > 0; }
};

/// The file's bytes: of the first version that says all of it (1; 2 where a face reflects; 3 with shapes), so that
/// older readers know what they can. Halves are cut to 65504.
std::string indexVolumeBytes(const std::vector<IndexVolumeObject>& objects);

}  // namespace photic
