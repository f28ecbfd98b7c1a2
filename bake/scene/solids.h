// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "bake/report/monitor.h"
#include "bake/scene/absorption_pattern.h"
#include "bake/scene/placement.h"
#include "bake/scene/triangle_mesh.h"

namespace photic {

/// A body of one index, to be made into samples.
struct Solid {
    std::string name;
    std::string where;  ///< for messages
    TriangleMesh mesh;  ///< closed, in the world
    double ior = 1.5;
    glm::dvec3 absorption{0};     ///< per channel [1/m]
    glm::dvec3 albedo{0};         ///< of its faces, for eye rays
    AbsorptionPattern pattern{};  ///< of its absorption, in its own axes
    Placement placement{};        ///< of those axes; the mesh is placed already
    bool absorbs() const { return absorption != glm::dvec3(0) || !pattern.painted.empty(); }
    /// [1/m], at a place in the world.
    glm::dvec3 absorptionAt(const glm::dvec3& world) const;
};

/// A closed mesh from a profile that turns about the z axis.
/// @param profile  (radius, height) [m], radii from 0 on, at least two; ends that are not on the axis are joined to it
TriangleMesh revolve(std::vector<glm::dvec2> profile);

/// What `photic voxelise` reads: a closed mesh, a profile (.csv: a radius and a height a line), or several bodies
/// (.toml, docs/scene.md).
struct SolidsFile {
    std::vector<Solid> solids;
    double voxel_size = 0;  ///< [m]; 0: not given
    double smooth = 0;      ///< [voxels]
    std::vector<std::string> files;
};
/// @param ior, absorption  of a mesh or a profile
/// @throws Error{Input} for what is no such file, and for meshes that are open, with their name
SolidsFile loadSolids(const std::string& path, double ior, const glm::dvec3& absorption, Monitor& monitor);

/// Samples of bodies on a grid of cubes: voxel (i, j, k) is centred at (i + 0.5, j + 0.5, k + 0.5) times its size.
struct SolidVolume {
    double voxel_size = 0;  ///< [m]
    glm::ivec3 min{0}, size{0};
    std::vector<float> index;       ///< n, x fastest; 1 outside
    std::vector<float> absorption;  ///< three a voxel [1/m]; empty: nothing absorbs
    std::vector<float> albedo;      ///< of faces, three a voxel: that of the body; empty: 0 everywhere
    std::vector<char> inside;       ///< some of a body is in the voxel
    std::size_t flat(int x, int y, int z) const {
        return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(y)) *
                   static_cast<std::size_t>(size.x) +
               static_cast<std::size_t>(x);
    }
};

/// Each voxel's mean over its volume: along z exactly, from 4 x 4 columns. Where bodies overlap, the last one is there.
/// @param margin  voxels around the bodies
/// @throws Error{Input} for more than 2^28 voxels; Error{Cancelled}
SolidVolume voxelise(const std::vector<Solid>& solids, double voxel_size, int margin, Monitor& monitor);

/// What smoothing did to n.
struct SmoothingEffect {
    double largest = 0, mean = 0;  ///< change of n; the mean of the voxels where it is more than 1e-4
    double face_voxels = 0;        ///< from 10 to 90 % of a flat face's jump
};
/// A Gaussian over n. @param sigma  [voxels]
SmoothingEffect smooth(SolidVolume& volume, double sigma);

}  // namespace photic
