// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/load_toml.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <glm/common.hpp>
#include <map>
#include <numbers>

#include "bake/image/atomic_file.h"
#include "bake/scene/config_meaning.h"
#include "bake/scene/gltf_scene.h"
#include "bake/scene/graded_index.h"
#include "bake/scene/kept_meshes.h"
#include "bake/scene/keyframes.h"
#include "bake/scene/load_parts.h"

namespace photic {
namespace {

constexpr int kSchema = 1;
constexpr std::size_t kMostTables = 10000;           // of one kind
constexpr std::uintmax_t kLargestScene = 16u << 20;  // [bytes]

void checkVersion(const ConfigValue& root, const std::string& name) {
    const ConfigValue* version = root.find("photic");
    if (!version)
        throw Error(
            ErrorCode::Input,
            fmt::format("'photic = {}', the version of the schema, is missing; make it the first line", kSchema),
            name + ":1:1");
    if (version->kind != ConfigValue::Kind::Integer || version->integer != kSchema)
        throw Error(ErrorCode::Input,
                    fmt::format("'photic' is {}; this program reads version {} of the schema",
                                version->kind == ConfigValue::Kind::Integer ? std::to_string(version->integer)
                                                                            : version->kindName(),
                                kSchema),
                    version->where);
}

/// Names tell things apart in messages and on the command line.
void refuseTwins(const std::string& name, const std::string& where, std::map<std::string, std::string>& seen) {
    const auto [first, fresh] = seen.emplace(name, where);
    if (!fresh)
        throw Error(ErrorCode::Input, fmt::format("the name '{}' is taken by {}; choose another", name, first->second),
                    where);
}

/// A sun whose disc touches the horizon, and one that the others drown.
void checkSuns(const Scene& scene, const std::vector<const ConfigValue*>& lights, const Surface* height_field) {
    constexpr double kLowest = 0.25;      // degrees; the sun's own radius
    constexpr double kLeastShare = 1e-6;  // of the brightest: half floats end at 6e-8 of it
    double brightest = 0;
    const auto peak = [](const Light& l) { return std::max({l.irradiance.x, l.irradiance.y, l.irradiance.z}); };
    for (const Light& light : scene.lights) brightest = std::max(brightest, peak(light));
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        if (peak(light) < kLeastShare * brightest)
            throw Error(
                ErrorCode::Input,
                fmt::format("the light '{}' has {:.3g} of the irradiance of the brightest one; below {:g} it is lost "
                            "in the volume's rounding: bake it alone, into a volume of its own",
                            light.name, peak(light) / brightest, kLeastShare),
                light.where);
        if (light.position || !height_field) continue;
        const double elevation = std::asin(-light.direction.z) * 180 / std::numbers::pi;
        const std::string& where = lights[i]->find("direction")->where;
        if (light.direction.z >= 0)
            throw Error(ErrorCode::Input,
                        fmt::format("the light '{}' travels upwards or level (direction.z is {:.3g}), but the height "
                                    "field '{}' is lit from above; direction.z must be below 0",
                                    light.name, light.direction.z, height_field->name),
                        where);
        if (elevation < kLowest)
            throw Error(
                ErrorCode::Input,
                fmt::format("the light '{}' stands {:.3g} degrees above the horizon; the limit is {} over the height "
                            "field '{}', whose waves would hide it: raise it, or use a mesh",
                            light.name, elevation, kLowest, height_field->name),
                where);
    }
}

/// What single tables cannot see.
void checkTogether(const Scene& scene, const std::vector<const ConfigValue*>& lights, const ConfigValue* medium,
                   const ConfigValue* bake) {
    const auto is_height_field = [](const Surface& s) { return s.height_field != nullptr; };
    const auto height_field = std::find_if(scene.surfaces.begin(), scene.surfaces.end(), is_height_field);
    checkSuns(scene, lights, height_field != scene.surfaces.end() ? &*height_field : nullptr);

    if (scene.medium.present()) {
        const Surface* first = nullptr;
        bool named = false;  // "water" by its name, with an index of its own
        for (const Surface& surface : scene.surfaces) {
            if (surface.event == SurfaceEvent::Reflect || surface.event == SurfaceEvent::Mirror) continue;
            for (const int side : {surface.medium_above, surface.medium_below})
                named = named || (side >= 0 && scene.media[static_cast<std::size_t>(side)].name == "water");
            if (surface.medium_below >= 0 || surface.closed) continue;
            if (first && first->ior_below != surface.ior_below)
                throw Error(ErrorCode::Input,
                            fmt::format("the one [medium] lies below '{}' (ior_below {}) and below '{}' (ior_below "
                                        "{}); give both the same",
                                        first->name, first->ior_below, surface.name, surface.ior_below),
                            surface.where);
            first = first ? first : &surface;
        }
        if (!first && !named)
            throw Error(
                ErrorCode::Input,
                "a [medium] is given, but no surface lets light into it: each reflects it all, or names another "
                "medium; remove one or the other",
                medium->where);
    }

    const auto where_place = [&] { return bake->find("where")->where; };
    if (scene.bake.where == Where::Media && !scene.medium.present())
        throw Error(ErrorCode::Input, "where = \"media\" needs a [medium] with absorption or scattering",
                    where_place());
    if (scene.bake.where == Where::Receivers &&
        std::none_of(scene.objects.begin(), scene.objects.end(), [](const Object& o) { return o.receives(); }))
        throw Error(ErrorCode::Input,
                    "where = \"receivers\" needs an [[object]] with role = \"receiver\" or \"movable\"", where_place());
}

}  // namespace

std::string LoadContext::path(const std::string& file) const {
    // "water.####.exr" at frame 7 is "water.0007.exr".
    std::string out = file;
    if (const std::size_t from = file.find('#'); from != file.npos) {
        const std::size_t to = std::min(file.find_first_not_of('#', from), file.size());
        out = fmt::format("{}{:0{}}{}", file.substr(0, from), frame, to - from, file.substr(to));
    }
    const std::filesystem::path path(out);
    return path.is_absolute() || directory.empty() ? out : (std::filesystem::path(directory) / path).string();
}

std::vector<const ConfigValue*> tablesOf(const ConfigValue* value, const std::string& title) {
    std::vector<const ConfigValue*> out;
    if (!value) return out;
    if (value->kind != ConfigValue::Kind::Array)
        throw Error(ErrorCode::Input,
                    fmt::format("'{0}' is {1}; write [[{0}]], with two brackets, for each", title, value->kindName()),
                    value->where);
    if (value->items.size() > kMostTables)
        throw Error(ErrorCode::Input,
                    fmt::format("there are {} [[{}]]; up to {} are read: join them, for example into one mesh",
                                value->items.size(), title, kMostTables),
                    value->where);
    for (const ConfigValue& item : value->items) out.push_back(&item);
    return out;
}

namespace {

const std::vector<std::string> kSceneKeys = {"photic", "frame_rate", "domain", "light",  "surface",
                                             "medium", "index",      "object", "camera", "bake"};

double frameRateOf(const ConfigValue& root) {
    constexpr double kUsual = 24;
    return TableReader(root, "the scene", kSceneKeys, {"volume", "environment"})
        .number("frame_rate", between(1e-6, 1e6, "1/s"))
        .value_or(kUsual);
}

/// How far a lamp at least counts as being from a surface's middle [m]: those that stand in a body count as if they
/// stood half way out of it, since there is no irradiance where a lamp is.
double leastDistance(const Surface& surface) {
    if (!surface.mesh) return 0;
    glm::dvec3 low(1e300), high(-1e300);
    for (const glm::dvec3& p : surface.mesh->positions) low = glm::min(low, p), high = glm::max(high, p);
    const glm::dvec3 half = 0.5 * (high - low);
    return 0.5 * std::min({half.x, half.y, half.z});
}

/// Volumes of one sequence share their reference irradiance: lamps bring it to the middle of the first surface, and
/// both count as at their first keyframes.
void keepReference(const ConfigValue& moving, const LoadContext& context, Scene& scene) {
    const auto lights = tablesOf(moving.find("light"), "light"), surfaces = tablesOf(moving.find("surface"), "surface");
    const auto moves = [](const ConfigValue* table) { return table->find("keyframes") != nullptr; };
    const auto first = [&](const ConfigValue& table) { return atKeyframes(table, firstKeyframe(table, scene.frame)); };
    const bool target_moves = moves(surfaces.front());
    std::optional<Surface> target;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        Light& light = scene.lights[i];
        if (!light.position || !(moves(lights[i]) || target_moves)) continue;
        if (!target && target_moves) {
            Monitor quiet;  // what there is to say of the surface has been said
            LoadContext aside{context.name, context.directory, context.frame, context.frame_rate, quiet};
            aside.media = scene.media, aside.graded = context.graded, aside.gltf = context.gltf;
            aside.water = context.water, aside.water_index = context.water_index;
            target = loadSurface(first(*surfaces.front()), 1, nullptr, aside);
        }
        Light at_first = loadLight(first(*lights[i]), i + 1);
        const Surface& lit = target ? *target : scene.surfaces.front();
        aimLight(at_first, lit.center, lit.name, leastDistance(lit));
        light.irradiance = at_first.irradiance;
    }
}

/// Loads what has a name, of which no two may share one.
/// @param load  the i-th of them (from 1), from its table
template <class Thing, class Load>
void loadNamed(const ConfigValue* tables, const char* title, std::vector<Thing>& out, Load load) {
    std::map<std::string, std::string> names;
    const auto found = tablesOf(tables, title);
    for (std::size_t i = 0; i < found.size(); ++i) {
        out.push_back(load(*found[i], i + 1));
        refuseTwins(out.back().name, out.back().where, names);
    }
}

/// Surfaces, objects, media and cameras, in the order in which what the scene's hash holds is read.
void loadThings(const TableReader& table, const DomainRequest& domain, LoadContext& context, Scene& scene) {
    if (const ConfigValue* media = table.find("medium")) loadMedia(*media, context);
    loadNamed(table.find("surface"), "surface", scene.surfaces, [&](const ConfigValue& value, std::size_t number) {
        context.monitor.checkCancelled();
        return loadSurface(value, number, domain.has_box ? &domain.domain : nullptr, context);
    });
    loadNamed(table.find("object"), "object", scene.objects, [&](const ConfigValue& value, std::size_t number) {
        context.monitor.checkCancelled();
        return loadObject(value, number, context);
    });
    for (const GradedObject& object : context.graded) {
        const Medium& medium = *std::find_if(context.media.begin(), context.media.end(),
                                             [&](const Medium& m) { return m.name == object.name; });
        if (object.enclosed && object.name == "water") context.water = medium;
        if (!object.enclosed && medium.priority != 0)
            throw Error(ErrorCode::Input,
                        fmt::format("'priority' is for media between surfaces; no surface names '{}', which is an "
                                    "object by itself",
                                    object.name),
                        object.where);
    }
    scene.medium = context.water, scene.media = std::move(context.media);
    loadNamed(table.find("camera"), "camera", scene.cameras,
              [](const ConfigValue& value, std::size_t number) { return loadCamera(value, number); });
}

/// What a scene needs at least, and what of it excludes something else.
void checkParts(const Scene& scene, const std::vector<const ConfigValue*>& indices, bool graded) {
    if (scene.lights.empty())
        throw Error(ErrorCode::Input, "the scene has no light; add [[light]] with type = \"sun\" and a direction",
                    scene.file);
    if (scene.surfaces.empty() && !graded)
        throw Error(ErrorCode::Input, "the scene has no surface that bends light; add a [[surface]]", scene.file);
    if (!indices.empty() && (scene.surfaces.empty() || graded))
        throw Error(ErrorCode::Input,
                    "an [[index]] is of the water below a surface, and beside a medium with 'index' is not built; keep "
                    "one of the two",
                    indices.front()->where);
}

void refuseMoreIndices(const std::vector<const ConfigValue*>& indices) {
    if (indices.size() > 1)
        throw Error(
            ErrorCode::Input,
            fmt::format("{} index volumes are given, but only one below the surface is built; keep one [[index]]",
                        indices.size()),
            indices[1]->where);
}

/// Lights shine at the middle of the first surface.
void aimAtSurface(const Surface& surface, Scene& scene) {
    for (Light& light : scene.lights) aimLight(light, surface.center, surface.name, leastDistance(surface));
}

/// Lights shine at the middle of the object whose index bends them; those that stand in it count as if they stood half
/// way out, since there is no irradiance where a lamp is.
void aimAtGraded(const GradedObject& object, Scene& scene) {
    const auto box = object.index.front()->bounds().value_or(WorldBox{scene.domain.min, scene.domain.max});
    const glm::dvec3 half = 0.5 * (box.max - box.min);
    for (Light& light : scene.lights)
        aimLight(light, 0.5 * (box.min + box.max), object.name, 0.5 * std::min({half.x, half.y, half.z}));
}

}  // namespace

Scene parseScene(const std::string& text, const std::string& name, const std::string& directory, int frame,
                 Monitor& monitor) {
    beginSceneOfKeptMeshes();
    const ConfigValue moving = parseConfig(text, name);
    checkVersion(moving, name);
    // What moves stands still in a frame: nothing after this knows of keyframes, and frames in which nothing moves have
    // one hash.
    const ConfigValue root = atFrame(moving, frame);
    const TableReader table(root, "the scene", kSceneKeys, {"volume", "environment"});

    Scene scene;
    scene.file = name, scene.frame = frame;
    LoadContext context{name, directory, frame, frameRateOf(root), monitor};
    // What a bake uses of [bake] is hashed with its settings: another method's options change nothing.
    ConfigValue meant = root;
    std::erase_if(meant.entries, [](const ConfigEntry& entry) { return entry.key == "bake"; });
    context.hashBytes(meaningOf(meant));

    const DomainRequest domain = loadDomain(table.find("domain"), name);
    const auto lights = tablesOf(table.find("light"), "light");
    for (std::size_t i = 0; i < lights.size(); ++i) scene.lights.push_back(loadLight(*lights[i], i + 1));
    loadThings(table, domain, context, scene);
    const auto indices = tablesOf(table.find("index"), "index");
    refuseMoreIndices(indices);
    scene.bake.quadrature = 0;  // as loadBake: by the slant of the light
    if (const ConfigValue* bake = table.find("bake")) scene.bake = loadBake(*bake);
    if (scene.medium.present()) scene.bake.grids.density = true;

    checkParts(scene, indices, !context.graded.empty());
    if (!context.graded.empty()) scene.index = std::make_shared<IndexVolume>(context.graded);
    if (!scene.surfaces.empty()) {
        aimAtSurface(scene.surfaces.front(), scene);
        keepReference(moving, context, scene);
    }
    if (!indices.empty()) scene.index = loadIndex(*indices.front(), scene.surfaces.front().ior_below, context);
    checkTogether(scene, lights, table.find("medium"), table.find("bake"));
    finishDomain(domain, scene);
    scene.bake.sizes_itself = !domain.is_sized && !scene.bake.error;
    if (scene.surfaces.empty()) aimAtGraded(context.graded.front(), scene);

    if (context.animated)
        context.hashBytes(fmt::format("frame {}", context.loop_frames > 0 ? frame % context.loop_frames : frame));
    scene.hash = context.hash;
    return scene;
}

namespace {

Scene loadGltfScene(const std::string& path, int frame, Monitor& monitor) {
    monitor.progress("scene", 0);
    const std::filesystem::path file(path);
    const GltfScene taken = sceneOfGltf(readFileBytes(path), path, file.filename().string(), [](std::string_view) {});
    for (const std::string& note : taken.notes) monitor.note(fmt::format("{}: {}", path, note));
    Scene scene = parseScene(taken.toml, path + " as a scene file", file.parent_path().string(), frame, monitor);
    monitor.progress("scene", 1);
    return scene;
}

}  // namespace

double loadFrameRate(const std::string& path) {
    const std::string bytes = readFileBytes(path);
    const auto ignore = [](std::string_view) {};
    return frameRateOf(parseConfig(isGltf(path) ? sceneOfGltf(bytes, path, path, ignore).toml : bytes, path));
}

namespace {

/// What is given for a scene by mistake, told by its name; its bytes would make no sense as text.
void refuseOtherFiles(const std::string& path) {
    struct Kind {
        const char *extension, *words;
    };
    constexpr Kind kKinds[] = {{".vdb", "is a volume, which photic bake makes of a scene"},
                               {".nvdb", "is a volume for games, which photic export makes"},
                               {".blend", "is a file of Blender; export a .glb, or bake with the add-on"},
                               {".obj", "is a mesh; a scene names it as the file of a [[surface]] or [[object]]"},
                               {".ply", "is a mesh; a scene names it as the file of a [[surface]] or [[object]]"}};
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    for (const Kind& kind : kKinds)
        if (extension == kind.extension && std::filesystem::exists(path))
            throw Error(ErrorCode::Input,
                        fmt::format("'{}' {}; a scene (.toml, .glb or .gltf) is wanted", path, kind.words));
}

}  // namespace

Scene loadScene(const std::string& path, int frame, Monitor& monitor) {
    const std::filesystem::path file(path);
    if (isGltf(path)) return loadGltfScene(path, frame, monitor);
    refuseOtherFiles(path);
    std::error_code unknown;
    if (const auto size = std::filesystem::file_size(file, unknown); !unknown && size > kLargestScene)
        throw Error(
            ErrorCode::Input,
            fmt::format("'{}' has {} bytes; a scene may have up to {}: large meshes and maps are files of their own",
                        path, size, kLargestScene));
    monitor.progress("scene", 0);
    Scene scene = parseScene(readFileBytes(path), path, file.parent_path().string(), frame, monitor);
    monitor.progress("scene", 1);
    return scene;
}

}  // namespace photic
