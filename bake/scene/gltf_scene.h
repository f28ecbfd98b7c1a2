// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace photic {

/// What a `.gltf` or `.glb` that stands for a whole scene is taken for.
struct GltfScene {
    std::string toml;                ///< the same scene as a scene file; it refers to the glTF for its shapes
    std::vector<std::string> notes;  ///< what was assumed, a sentence each
};

/// Reads lights (KHR_lights_punctual; a candela or a lux is 1/683 W), cameras, and the triangles of each node and
/// material, by their materials: what transmits light (KHR_materials_transmission, _ior, _volume, _dispersion) bends
/// it, smooth metal mirrors it, the rest receives it. What a file cannot say, `extras` do: a table `photic`, or keys
/// `photic_...`, of nodes, materials, lights and the scene (docs/scene.md).
///
/// @param name  that the scene file shall call the glTF by
/// @param use_bytes  sees the bytes of every file that was read besides `bytes`
/// @throws Error{Input}
GltfScene sceneOfGltf(const std::string& bytes, const std::string& path, const std::string& name,
                      const std::function<void(std::string_view)>& use_bytes);

}  // namespace photic
