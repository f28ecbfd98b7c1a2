// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "bake/scene/mesh_file.h"
#include "tests/fuzz/fuzzed.h"

namespace photic::fuzz {

/// Hands the bytes to a reader of meshes; what it reads must be whole once it is built.
inline void readMesh(RawMesh (*read)(const std::string&, const std::string&), const std::uint8_t* data,
                     std::size_t size) {
    refusedOrRead([&] {
        Monitor monitor;
        const std::string bytes(reinterpret_cast<const char*>(data), size), name = "mesh";
        const TriangleMesh mesh = buildMesh(read(bytes, name), UpAxis::Z, name, monitor);
        demand(!mesh.triangles.empty() && mesh.normals.size() == mesh.positions.size());
        for (const auto& triangle : mesh.triangles)
            for (const std::uint32_t corner : triangle) demand(corner < mesh.positions.size());
    });
}

}  // namespace photic::fuzz
