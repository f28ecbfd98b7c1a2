// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bake/report/monitor.h"
#include "bake/scene/mesh_shape.h"
#include "bake/scene/triangle_mesh.h"

namespace photic {

/// While one lives, meshes that were read for a scene are handed to the next one that asks for the same file, of the
/// same bytes, with the same keys: frames of a sequence share them, and with them all that is built of their triangles.
class KeptMeshes {
public:
    KeptMeshes();
    ~KeptMeshes();
    KeptMeshes(const KeptMeshes&) = delete;
    KeptMeshes& operator=(const KeptMeshes&) = delete;
};

/// A mesh as a scene has it.
struct LoadedMesh {
    std::shared_ptr<const TriangleMesh> mesh;
    MeshShape shape;
};

/// The mesh of a file: kept, or loaded and kept. A kept one says again what was said when it was loaded.
/// @param keys       all that the mesh depends on besides the file's bytes
/// @param use_bytes  sees the bytes of every file that the mesh is made of
/// @param load       makes the mesh, and hands on the bytes of each file that it reads
LoadedMesh keptMesh(
    const std::string& path, const std::string& keys, const std::function<void(std::string_view)>& use_bytes,
    Monitor& monitor,
    const std::function<LoadedMesh(Monitor& monitor, const std::function<void(std::string_view)>& use_bytes)>& load);

/// Another scene is going to be read: what neither it nor the one before asks for goes.
void beginSceneOfKeptMeshes();

}  // namespace photic
