// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "bake/scene/triangle_mesh.h"

namespace photic {

/// How the triangles of a welded mesh hang together. Parts are what edges join.
struct MeshShape {
    std::size_t parts = 0, closed_parts = 0;  ///< closed: each edge belongs to two triangles or more
    std::string a_closed_part;                ///< the first one: "4 vertices around (0, 0, 0.1)"
    std::size_t doubled = 0;                  ///< triangles whose three vertices another one before them has
    /// Triangles that are wound against most of their part, and their share of the area.
    std::size_t turned = 0;
    double turned_share = 0;
    double volume = 0;  ///< enclosed by the closed parts [m3]; negative where most of them is wound inwards

    bool faceted = false;  ///< some edges are sharper than 40 degrees, and all others lie in flat faces

    bool closed() const { return parts > 0 && closed_parts == parts; }
};

MeshShape shapeOf(const TriangleMesh& mesh);

}  // namespace photic
