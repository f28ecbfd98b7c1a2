// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/export_index.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "bake/cli/json.h"
#include "bake/file/index_volume_file.h"
#include "bake/file/output_set.h"
#include "bake/graded/enclosed_bodies.h"
#include "bake/graded/object_samples.h"
#include "bake/image/atomic_file.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"

namespace photic::cli {
namespace {

IndexVolumeObject objectOf(ObjectSamples samples, const GradedObject& object) {
    return {object.name,
            samples.world_from_node,
            samples.origin_world,
            samples.count,
            std::move(samples.spline),
            std::move(samples.attenuation),
            std::move(samples.glow),
            std::move(samples.faces),
            object.scattering,
            object.anisotropy,
            samples.box_low,
            samples.box_high,
            samples.sharp_sides,
            object.face.albedo,
            object.face.roughness,
            std::move(samples.coat)};
}

void check(const ExportArguments& arguments) {
    if (arguments.volumes.size() != 1 || std::filesystem::path(arguments.volumes.front()).extension() != ".toml")
        throw Error(ErrorCode::Usage, "an .ivol holds the media of one scene: give its .toml, and no light volume",
                    arguments.volumes.front());
    for (const auto& [given, name] : {std::pair{bool(arguments.precision), "--precision"},
                                      {bool(arguments.codec), "--codec"},
                                      {bool(arguments.budget_mb), "--budget"},
                                      {!arguments.scene.empty(), "--scene"},
                                      {!arguments.sequence.empty(), "--sequence"},
                                      {!arguments.box.empty(), "--box"}})
        if (given) throw Error(ErrorCode::Usage, "is for light volumes; an .ivol holds what a scene says", name);
}

}  // namespace

int exportIndex(const ExportArguments& arguments, Terminal& terminal) {
    check(arguments);
    const std::string& path = arguments.volumes.front();
    OutputSet outputs;
    outputs.reads("the scene", path);
    outputs.writes("the output", arguments.output);
    const FilesRead files;
    const Scene scene = loadScene(path, 0, terminal);
    outputs.reads("a file of the scene", files.paths());
    if (!scene.index || scene.index->objects().empty())
        throw Error(
            ErrorCode::Input,
            "no [[medium]] of it has an 'index'; an .ivol holds media whose index varies, for eye rays that bend",
            path);
    const std::vector<GradedObject> objects = bodiesOf(scene);
    const ObjectSampling sampling{arguments.voxel_size.value_or(scene.domain.voxel_size),
                                  {scene.domain.min, scene.domain.max}};
    std::vector<IndexVolumeObject> written;
    std::int64_t nodes = 0;
    glm::ivec3 largest(0);
    for (std::size_t i = 0; i < objects.size(); ++i) {
        terminal.progress("sample", static_cast<double>(i) / static_cast<double>(objects.size()));
        ObjectSamples samples = sampleObject(objects, i, sampling, terminal);
        const auto faces = std::count(samples.faces.begin(), samples.faces.end(), 255);
        nodes += std::int64_t{samples.count.x} * samples.count.y * samples.count.z;
        largest = glm::ivec3(std::max(largest.x, samples.count.x), std::max(largest.y, samples.count.y),
                             std::max(largest.z, samples.count.z));
        terminal.say(fmt::format("  {}: {} x {} x {} nodes, a spline {} its samples; {}", objects[i].name,
                                 samples.count.x, samples.count.y, samples.count.z,
                                 samples.fit == SplineFit::Plain ? "near" : "through",
                                 samples.sharp_sides ? "sharp sides"
                                 : faces > 0         ? fmt::format("faces at {} nodes", faces)
                                                     : std::string("no faces")));
        written.push_back(objectOf(std::move(samples), objects[i]));
    }
    const std::string bytes = indexVolumeBytes(written);
    outputs.write(arguments.output, bytes);
    outputs.commit();
    terminal.progress("sample", 1);
    terminal.say(fmt::format("{}: {} object{}, {:.2f} MB", arguments.output, written.size(),
                             written.size() == 1 ? "" : "s", static_cast<double>(bytes.size()) * 1e-6));
    if (arguments.json) {
        Json list = Json::array();
        list.push_back({{"volume", path},
                        {"files", Json::array({{{"path", arguments.output}, {"bytes", bytes.size()}}})},
                        {"bytes", bytes.size()},
                        {"voxels", nodes},
                        {"size", toJson(largest)},
                        {"cut_values", 0},
                        {"budget", nullptr}});
        print({{"schema", "photic-export-1"}, {"format", "ivol"}, {"precision", "float"}, {"frames", list}});
    }
    return 0;
}

}  // namespace photic::cli
