// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bake/graded/object_samples.h"
#include "bake/scene/scene.h"

namespace photic {

enum class SharpFaces { Glass, Mirror, Thin };

/// A surface of a scene as the body that eye rays see, with its own faces: a mesh or a ball, in nodes of its own or of
/// the samples of what fills it. A node is at origin_world + world_from_node * (i, j, k).
struct SharpBody {
    std::string name;
    SharpFaces faces = SharpFaces::Glass;
    glm::dmat3 world_from_node{1};
    glm::dvec3 origin_world{0};       ///< [m]
    glm::dvec3 index{1};              ///< n inside for red, green and blue, where nothing fills it; within a pane
    glm::dvec3 absorption{0};         ///< per channel [1/m], where nothing fills it
    glm::dvec3 colour{1};             ///< of a mirror
    unsigned rank = 0;                ///< where bodies overlap, that of the highest is what is there
    std::optional<glm::vec4> ball{};  ///< centre and radius [nodes]; absent: triangles
    std::vector<glm::vec3> positions, normals;  ///< [nodes], and covectors of nodes; no normals: flat faces
    std::vector<std::array<std::uint32_t, 3>> triangles;
    /// What fills it, where its index varies or it scatters: samples that go on beyond its faces.
    std::optional<ObjectSamples> samples{};
    std::optional<GradedObject> filling{};  ///< what was sampled
};

/// A scene's bodies, and what is left of its media whose index varies: those that end at something else than closed
/// meshes and spheres. `notes` says what eye rays will see otherwise than the bake, a line each.
struct SharpScene {
    std::vector<SharpBody> bodies;
    std::vector<GradedObject> others;
    std::vector<std::string> notes;
};

/// Each closed mesh, sphere, mirror and thin pane of a scene is a body; height fields and open meshes are not.
/// @param sampling  of what fills them; samples keep their spacing where it is less
/// @throws Error{Input} for too many nodes; Error{Cancelled}
SharpScene sharpBodiesOf(const Scene& scene, const ObjectSampling& sampling, Monitor& monitor);

/// The scene with its bodies of one index as media whose index varies, for bodiesOf(): what a file has that knows
/// samples alone.
Scene withSampledBodies(const Scene& scene);

}  // namespace photic
