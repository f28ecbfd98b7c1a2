// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/export_index.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <glm/common.hpp>

#include "bake/cli/json.h"
#include "bake/file/index_volume_file.h"
#include "bake/file/output_set.h"
#include "bake/graded/enclosed_bodies.h"
#include "bake/graded/object_samples.h"
#include "bake/graded/sharp_bodies.h"
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

IndexVolumeObject objectOf(SharpBody body) {
    IndexVolumeObject object;
    if (body.samples) object = objectOf(std::move(*body.samples), *body.filling);
    object.name = body.name;
    object.world_from_node = body.world_from_node, object.origin_world = body.origin_world;
    SharpShape& shape = object.shape.emplace();
    shape.faces = body.faces == SharpFaces::Glass    ? SharpShape::Faces::Glass
                  : body.faces == SharpFaces::Mirror ? SharpShape::Faces::Mirror
                                                     : SharpShape::Faces::Thin;
    shape.index = body.index, shape.absorption = body.absorption, shape.colour = body.colour;
    shape.rank = body.rank;
    if (body.ball) shape.ball = *body.ball;
    shape.positions = std::move(body.positions), shape.normals = std::move(body.normals);
    shape.triangles = std::move(body.triangles);
    return object;
}

std::string describe(const IndexVolumeObject& object) {
    const SharpShape& shape = *object.shape;
    std::string what = shape.triangles.empty() ? std::string("a ball")
                                               : fmt::format("{} triangles, {}", shape.triangles.size(),
                                                             shape.normals.empty() ? "flat" : "smooth");
    what += shape.faces == SharpShape::Faces::Mirror ? ", a mirror"
            : shape.faces == SharpShape::Faces::Thin ? ", a thin pane"
                                                     : ", with sharp faces";
    if (!object.spline.empty())
        what += fmt::format(", {} x {} x {} nodes in it", object.count.x, object.count.y, object.count.z);
    return fmt::format("  {}: {}", object.name, what);
}

/// The scene's media by their samples, and, of closed bodies, those of one index too where they are wanted so.
void addSamples(const std::vector<GradedObject>& objects, const ObjectSampling& sampling, Terminal& terminal,
                std::vector<IndexVolumeObject>& written) {
    for (std::size_t i = 0; i < objects.size(); ++i) {
        terminal.progress("sample", static_cast<double>(i) / static_cast<double>(objects.size()));
        ObjectSamples samples = sampleObject(objects, i, sampling, terminal);
        const auto faces = std::count(samples.faces.begin(), samples.faces.end(), 255);
        terminal.say(fmt::format("  {}: {} x {} x {} nodes, a spline {} its samples; {}", objects[i].name,
                                 samples.count.x, samples.count.y, samples.count.z,
                                 samples.fit == SplineFit::Plain ? "near" : "through",
                                 samples.sharp_sides ? "sharp sides"
                                 : faces > 0         ? fmt::format("faces at {} nodes", faces)
                                                     : std::string("no faces")));
        written.push_back(objectOf(std::move(samples), objects[i]));
    }
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
    const ObjectSampling sampling{arguments.voxel_size.value_or(scene.domain.voxel_size),
                                  {scene.domain.min, scene.domain.max}};
    std::vector<IndexVolumeObject> written;
    if (arguments.bodies == ExportBodies::Samples) {
        addSamples(bodiesOf(withSampledBodies(scene)), sampling, terminal, written);
    } else {
        SharpScene sharp = sharpBodiesOf(scene, sampling, terminal);
        for (SharpBody& body : sharp.bodies) {
            written.push_back(objectOf(std::move(body)));
            terminal.say(describe(written.back()));
        }
        addSamples(sharp.others, sampling, terminal, written);
        for (const std::string& note : sharp.notes) terminal.note(note);
    }
    if (written.empty())
        throw Error(ErrorCode::Input,
                    "it has no body of glass (a closed mesh, a sphere, a mirror or a thin pane) and no [[medium]] with "
                    "an 'index'; an .ivol holds those, for eye rays that bend",
                    path);
    if (written.size() > kMostObjectsDrawn)
        terminal.note(fmt::format("{} objects: the run-time library's pass draws up to {} at a time", written.size(),
                                  kMostObjectsDrawn));
    std::int64_t nodes = 0;
    glm::ivec3 largest(0);
    for (const IndexVolumeObject& object : written) {
        nodes += std::int64_t{object.count.x} * object.count.y * object.count.z;
        largest = glm::max(largest, object.count);
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
