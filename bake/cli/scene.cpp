// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>

#include "bake/cli/verbs.h"
#include "bake/file/output_set.h"
#include "bake/image/atomic_file.h"
#include "bake/report/error.h"
#include "bake/scene/gltf_scene.h"
#include "bake/scene/mesh_file.h"

namespace photic::cli {

int run(const SceneArguments& arguments, Terminal& terminal) {
    namespace fs = std::filesystem;
    if (!isGltf(arguments.gltf))
        throw Error(ErrorCode::Usage, fmt::format("'{}' is no glTF; give a .glb or .gltf", arguments.gltf));
    OutputSet outputs;
    outputs.reads("the glTF", arguments.gltf);
    outputs.writes("the scene file", arguments.output);
    const fs::path folder = fs::absolute(arguments.output).parent_path();
    const std::string name = fs::absolute(arguments.gltf).lexically_relative(folder).generic_string();
    const GltfScene scene = sceneOfGltf(readFileBytes(arguments.gltf), arguments.gltf, name, [](std::string_view) {});
    for (const std::string& note : scene.notes) terminal.note(fmt::format("{}: {}", arguments.gltf, note));
    outputs.write(arguments.output, scene.toml);
    outputs.commit();
    terminal.say(arguments.output + ": written");
    return 0;
}

}  // namespace photic::cli
