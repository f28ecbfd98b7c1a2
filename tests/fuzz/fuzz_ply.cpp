// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/mesh_file.h"
#include "tests/fuzz/fuzzed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    photic::fuzz::refusedOrRead([&] {
        photic::Monitor monitor;
        const std::string bytes(reinterpret_cast<const char*>(data), size);
        photic::RawMesh raw = photic::readPly(bytes, "a.ply");
        const photic::TriangleMesh mesh = photic::buildMesh(std::move(raw), photic::UpAxis::Z, "a.ply", monitor);
        photic::fuzz::demand(!mesh.triangles.empty() && mesh.normals.size() == mesh.positions.size());
        for (const auto& triangle : mesh.triangles)
            for (const std::uint32_t corner : triangle) photic::fuzz::demand(corner < mesh.positions.size());
    });
    return 0;
}
