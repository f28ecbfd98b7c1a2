// SPDX-License-Identifier: Apache-2.0
// A glTF as a mesh, and as a whole scene whose text is then read as a scene file is.
#include "bake/scene/config_tree.h"
#include "bake/scene/gltf_scene.h"
#include "bake/scene/mesh_file.h"
#include "tests/fuzz/fuzzed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string bytes(reinterpret_cast<const char*>(data), size);
    const auto ignore = [](std::string_view) {};
    photic::fuzz::refusedOrRead([&] {
        photic::Monitor monitor;
        photic::RawMesh raw = photic::readGltf(bytes, "a.glb", ignore);
        std::size_t covered = 0;
        for (const photic::MeshPart& part : raw.parts) covered += part.count;
        photic::fuzz::demand(covered == raw.triangles.size());
        (void)photic::buildMesh(std::move(raw), photic::UpAxis::Y, "a.glb", monitor);
    });
    photic::fuzz::refusedOrRead([&] {
        const photic::GltfScene scene = photic::sceneOfGltf(bytes, "a.glb", "a.glb", ignore);
        // What is made from a file must be a table at least, whatever names the file holds.
        (void)photic::parseConfig(scene.toml, "a.toml");
    });
    return 0;
}
