// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "bake/graded/spline_index.h"
#include "bake/report/monitor.h"
#include "bake/scene/index_volume.h"

namespace photic {

/// A graded object by itself, on a grid of nodes of its own: what eye rays through it need.
/// Node (i, j, k) is at origin_world + world_from_node * (i, j, k); arrays have x fastest.
struct ObjectSamples {
    glm::dmat3 world_from_node{1};
    glm::dvec3 origin_world{0};  ///< [m]
    glm::ivec3 count{0};
    /// Of each index (one, or red, green and blue): coefficients of the cubic B-spline of (n^2 - 1) / 2.
    std::vector<std::vector<float>> spline;
    SplineFit fit = SplineFit::Plain;  ///< of the first
    /// Absorption per channel [1/m], and how much of the object is there, 0..1, which scattering goes with.
    /// Empty where the object neither absorbs nor scatters.
    std::vector<glm::vec4> attenuation;
    std::vector<glm::vec4> glow;      ///< emission per channel [W/(m3 sr)] and g; empty where nothing shines
    std::vector<glm::vec3> coat;      ///< albedo of faces; empty where it is the same everywhere
    std::vector<std::uint8_t> faces;  ///< 255 around faces, where Fresnel's reflection belongs; empty without faces
    /// Where the object is, in nodes; beyond it there is air.
    glm::vec3 box_low{0}, box_high{0};
    bool sharp_sides = false;  ///< the index jumps at the sides of that box, and is smooth within it
};

struct ObjectSampling {
    double voxel_size = 0;  ///< [m] of formulas; samples keep their own
    WorldBox domain{};      ///< that objects which fill the world are cut to
    std::size_t most_nodes = std::size_t{1} << 27;
};

/// Samples one of a scene's objects; where an earlier one is, it is not.
/// Formulas are sampled on an axis-aligned grid, a voxel that the rim goes through by its mean; samples stay what they
/// are. A face is where the index changes by more than 0.003 within four nodes, and there by more than 70 % of what it
/// changes within twelve; a node more on all sides belongs to it. Faces of formulas are made wider, by a deviation
/// of a node, so that they look the same way wherever they lie in the grid. A face has the largest albedo of a volume
/// within two nodes: what is painted on a body is on its face, and not half of it.
/// @throws Error{Input} for too many nodes, with what would do; Error{Cancelled}
ObjectSamples sampleObject(const std::vector<GradedObject>& objects, std::size_t number, const ObjectSampling& sampling,
                           Monitor& monitor);

}  // namespace photic
