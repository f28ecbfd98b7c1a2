// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "bake/scene/mesh_file.h"

namespace photic {

/// A `.gltf` or `.glb` opened as far as its shell goes, before anything of its scene is believed.
struct GltfContainer {
    /// The JSON, without looks (images, animations; of materials only their names are left), and with the URI of buffer
    /// i made "photic-buffer-i".
    std::string json;
    std::string looks;                  ///< the JSON as it came, less its buffers and images: for what a scene shows
    std::vector<std::string> buffers;   ///< the bytes of each, as many as it claims
    std::vector<std::string> warnings;  ///< what of the file is left out
    std::string motion;                 ///< what of it moves, for who takes it as it stands; or empty
};

/// Reads the shell and the buffers: of the file itself, from data URIs, and from files beside it.
///
/// @param use_bytes  sees the bytes of every file that was read besides `bytes`
/// @throws Error{Input} for a damaged shell, for extensions that change the shape and are not read, for compressed
/// buffers, for URIs that lead elsewhere, and for JSON that is nested more than 64 deep; each by name
GltfContainer openGltf(const std::string& bytes, const std::string& path,
                       const std::function<void(std::string_view)>& use_bytes);

}  // namespace photic
