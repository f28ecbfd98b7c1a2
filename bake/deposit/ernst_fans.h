// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "bake/tubes/tube_set.h"

namespace photic {

/// A caustic ray in index coordinates: x = start + t along.
struct FanRay {
    glm::dvec3 start, along;
};

/// One triangle of a fan: the rays at its corners, and the power between them [W].
struct FanTube {
    FanRay ray[3];
    double power = 0;
};

/// What crosses planes that are parallel to one plane, by the depth alpha behind it: some power, and an area that is a
/// quadratic of alpha [Ernst et al. 2005, section 3.4: A(alpha) = a + alpha b + alpha^2 c]. Signed by orientation, in
/// units of the plane's normal vector.
struct FanArea {
    double power = 0, a = 0, b = 0, c = 0;
    double at(double alpha) const { return a + alpha * (b + alpha * c); }
};

/// Flattens a fan [Ernst et al. 2005, section 3.4 and figure 5]: all its vertices are projected along their own rays
/// into the plane through `origin` with this normal, the fan then has one system of coordinates, and its triangles'
/// coefficients are summed. A fan that lies in that plane keeps its triangles' areas. Triangles whose rays run along
/// the plane or through it from behind, which have no place in it, are left out with their power.
/// @param normal  of any length; alpha = normal . (x - origin)
FanArea flattenedFan(std::span<const FanTube> fan, const glm::dvec3& origin, const glm::dvec3& normal);

/// A tube as the paper's shader has it: its rays in the coordinates of its own triangle, and of each corner's fan what
/// is flattened into that triangle's plane.
struct ErnstTube {
    glm::dvec3 origin{0}, normal{0};  ///< alpha = normal . (x - origin); the normal is 0 where nothing can be laid
    FanRay ray[3];                    ///< start: in the plane alpha = 0; along: alpha grows by 1
    double opens[3] = {0, 0, 0};      ///< alpha where the corner's ray begins: 0, but for tubes of the layers' plane
    FanArea fan[3];
};

/// The tubes of all sets of a deposit, with their fans, which go across sets: rays that leave the surface at one place
/// in one direction are one vertex.
///
/// The plane of a tube is that of the triangle between its corners. Where rays run along that plane, or on both sides
/// of it, which the paper doesn't speak of, the layers' plane stands for it. Cost: each tube flattens three fans, of
/// some six triangles each.
class ErnstFans {
public:
    explicit ErnstFans(std::span<const TubeSet> sets);
    const ErnstTube& tube(std::size_t set, std::size_t tube) const { return tubes_[first_[set] + tube]; }

private:
    std::vector<std::size_t> first_;  ///< of a set's tubes
    std::vector<ErnstTube> tubes_;
};

}  // namespace photic
