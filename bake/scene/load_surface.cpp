// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <limits>

#include "bake/image/atomic_file.h"
#include "bake/scene/config_meaning.h"
#include "bake/scene/kept_meshes.h"
#include "bake/scene/load_parts.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/placement.h"
#include "bake/scene/wave_field.h"

namespace photic {
namespace {

const std::vector<std::string> kMeshKeys{"up",   "smooth", "inside", "position", "rotation",
                                         "thin", "radius", "node",   "material"};
const std::vector<std::string> kFileKeys{"channel", "scale", "level", "displacement", "displacement_channels",
                                         "texels"};
const std::vector<std::string> kSources{"file", "waves", "bump", "sea", "flat"};
/// Of height fields alone; `scale` and `outside` mean something for meshes too.
const std::vector<std::string> kHeightFieldKeys{"channel", "level",      "displacement",  "displacement_channels",
                                                "waves",   "animate",    "bump",          "sea",
                                                "flat",    "height",     "size",          "center",
                                                "texels",  "frame_rate", "interpolation", "above",
                                                "below"};
constexpr int kSphereRings = 64;

void refuse(const TableReader& table, const std::vector<std::string>& keys, const char* reason) {
    for (const std::string& key : keys)
        if (table.has(key)) table.fail(key, fmt::format("'{}' {}", key, reason));
}

/// Half the patch that covers the domain's footprint about `center`, on each axis.
glm::dvec2 footprintAround(const Domain& domain, glm::dvec2 center) {
    return glm::max(glm::abs(glm::dvec2(domain.min) - center), glm::abs(glm::dvec2(domain.max) - center));
}

/// Numbers that are each allowed can still make a surface whose heights or slopes are none.
void refuseEndless(const TableReader& table, const Surface& surface) {
    const auto isFinite = [](const glm::dvec3& v) {
        return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    };
    constexpr int kPlaces = 5;  // a side
    for (int i = 0; i < kPlaces * kPlaces; ++i) {
        const glm::dvec2 part = (glm::dvec2(i % kPlaces, i / kPlaces) + 0.37) / double(kPlaces) - 0.5;
        const glm::dvec2 uv = glm::dvec2(surface.center) + surface.size * part;
        const SurfacePoint point = surface.height_field->at(uv);
        if (!isFinite(point.position) || !isFinite(point.normal))
            table.fail(
                fmt::format("the surface '{}' has no height or slope at ({:.4g}, {:.4g}), where its numbers are too "
                            "large to be added up; use smaller ones",
                            surface.name, uv.x, uv.y));
    }
}

void loadHeightField(const TableReader& table, const Domain* domain, Surface& surface, LoadContext& context) {
    refuse(table, {"up", "smooth"}, "is for kind = \"mesh\"");
    refuse(table, {"radius"}, "is for kind = \"sphere\"");
    refuse(table, {"inside"}, "is for closed shapes; a height field has a medium 'below' it and one 'above'");
    refuse(table, {"position"}, "is for meshes and spheres; a height field has 'center'");
    refuse(table, {"rotation", "thin"}, "is for meshes and spheres; a height field lies level");
    HeightFieldPlace place;
    place.center = table.vector3("center", anyNumber("m")).value_or(glm::dvec3(0));
    place.size = table.vector2("size", positive("m")).value_or(glm::dvec2(0));
    place.outside_given = table.has("outside");
    place.outside = static_cast<Outside>(table.choice("outside", {"flat", "periodic", "none"}).value_or(0));
    place.frame_rate = table.number("frame_rate", between(1e-6, 1e6, "1/s")).value_or(context.frame_rate);

    table.exclusive(kSources);
    const bool flat = table.flag("flat").value_or(false) || table.has("height");
    if (table.has("flat") && !flat) table.fail("flat", "'flat' is false; remove it and give file, waves, bump or sea");
    if (!table.has("file")) refuse(table, kFileKeys, "is for heights from a file");
    if (!table.has("waves")) refuse(table, {"animate"}, "is for waves");
    for (const char* source : {"file", "waves", "bump", "sea"})
        if (table.has(source) && table.has("height")) table.exclusive({source, "height"});
    if (flat || table.has("waves")) refuse(table, {"interpolation"}, "is for sampled surfaces");

    const bool sampled = table.has("file") || table.has("bump") || table.has("sea");
    if (sampled && place.size.x == 0) table.missing("size", "[4, 4] [m]");
    if (table.has("sea") && !place.outside_given) place.outside = Outside::Periodic;  // as the sea is

    if (table.has("file")) {
        surface.height_field = loadHeightMap(table, place, context);
    } else if (table.has("waves")) {
        surface.height_field = loadWaves(table, place, context);
    } else if (table.has("bump")) {
        surface.height_field = loadBump(table, place, context);
    } else if (table.has("sea")) {
        surface.height_field = loadSea(table, place, context);
    } else if (flat) {
        if (place.outside == Outside::None && place.size.x == 0)
            table.missing("size", "[4, 4] [m], where the surface ends");
        place.center.z += table.number("height", anyNumber("m")).value_or(0);
        surface.height_field = makeFlatField(place.center.z);
    } else {
        table.fail("the height field has no source; give file, waves, bump, sea or flat = true");
    }

    if (place.size.x == 0) {
        if (!domain) table.missing("size", "[4, 4] [m], or give [domain] min and max");
        place.size = 2.0 * footprintAround(*domain, glm::dvec2(place.center));
    }
    surface.size = place.size, surface.center = place.center, surface.outside = place.outside;
    refuseEndless(table, surface);
}

}  // namespace

namespace {

/// The file's triangles, or those of the parts that `node` and `material` name.
TriangleMesh loadTriangles(const TableReader& table, const std::string& path, std::optional<UpAxis> up,
                           LoadContext& context, Monitor& monitor,
                           const std::function<void(std::string_view)>& use_bytes) {
    const auto node = table.text("node"), material = table.text("material");
    if (!node && !material) return loadMesh(path, up, monitor, use_bytes);
    if (!isGltf(path))
        table.fail(node ? "node" : "material", "only of .gltf and .glb files parts are read; leave it out");
    std::shared_ptr<const RawMesh>& raw = context.gltf[path];
    if (!raw) {
        const std::string bytes = readFileBytes(path);
        use_bytes(bytes);
        raw = std::make_shared<const RawMesh>(readGltf(bytes, path, use_bytes));
    }
    return buildMesh(onlyParts(*raw, node.value_or(""), material.value_or(""), path), up.value_or(UpAxis::Y), path,
                     monitor);
}

/// All keys of a table that its mesh depends on, besides the file.
std::string meshKeys(const TableReader& table) {
    std::string keys;
    for (const char* key : {"up", "smooth", "node", "material", "position", "rotation", "scale"})
        if (const ConfigValue* value = table.find(key)) keys += fmt::format("{} {}\n", key, meaningOf(*value));
    return keys;
}

}  // namespace

std::shared_ptr<const TriangleMesh> loadMeshKeys(const TableReader& table, const std::string& file,
                                                 LoadContext& context, MeshShape* shape) {
    std::optional<UpAxis> up;
    if (const auto axis = table.choice("up", {"y", "z"})) up = static_cast<UpAxis>(*axis);
    const auto smooth = table.flag("smooth");
    const Placement placement = loadPlacement(table);
    const std::string path = context.path(file);
    const auto load = [&](Monitor& monitor, const std::function<void(std::string_view)>& use_bytes) {
        TriangleMesh mesh = loadTriangles(table, path, up, context, monitor, use_bytes);
        place(mesh, placement);
        LoadedMesh loaded;
        if (shape) loaded.shape = shapeOf(mesh);
        const bool flat = smooth ? !*smooth : shape && loaded.shape.faceted && !mesh.shaded_smooth;
        if (flat && !smooth)
            monitor.note(
                fmt::format("'{}': all of its edges are sharp, so its faces are flat; smooth = true "
                            "rounds them",
                            file));
        // Open sheets are water, whose crests are round.
        const bool creased = !flat && !smooth && shape && loaded.shape.closed() && !mesh.corner_normals.empty();
        if (creased)
            monitor.note(fmt::format("'{}': edges {} are creases; smooth = true rounds them", file,
                                     mesh.shaded_smooth ? "that the file shades sharp" : "sharper than 40 degrees"));
        TriangleMesh out = flat ? withFacetNormals(mesh) : creased ? withCreases(mesh) : std::move(mesh);
        if (!flat) out.corner_normals.clear();
        loaded.mesh = std::make_shared<TriangleMesh>(std::move(out));
        return loaded;
    };
    return placed(table, "file", [&] {
        // A surface's mesh has creases, an object's has not.
        const std::string keys = meshKeys(table) + (shape ? "surface" : "object");
        LoadedMesh loaded = keptMesh(
            path, keys, [&](std::string_view bytes) { context.hashBytes(bytes); }, context.monitor, load);
        if (shape) *shape = loaded.shape;
        return loaded.mesh;
    });
}

namespace {

/// Whether a surface's medium has an index that varies, of which the one at the surface stands for all wherever a
/// number has to.
bool encloses(Medium& medium, const Surface& surface, LoadContext& context) {
    GradedObject* object = gradedNamed(context, medium.name);
    if (!object) return false;
    if (!object->enclosed) medium.ior = indexAt(*object, surface.center);
    object->enclosed = true;
    return true;
}

/// What lies above and below: media by name, or indices as numbers.
void loadSides(const TableReader& table, const char* above, const char* below, Surface& surface, LoadContext& context) {
    table.exclusive({above, "ior_above"});
    table.exclusive({below, "ior_below"});
    surface.medium_above = mediumNamed(table, above, context);
    surface.medium_below = mediumNamed(table, below, context);
    const bool water_varies = surface.height_field && gradedNamed(context, "water"),
               water_disperses = context.water_index && context.water_index->disperses();
    if (!table.has(below) && !table.has("ior_below") && (context.water_index || water_varies)) {
        // The water says itself what its index is.
        if (context.water_index) surface.ior_below = context.water_index->mean();
        if (water_disperses || water_varies) {
            Medium water = context.water;
            water.name = "water";
            const auto found = std::find_if(context.media.begin(), context.media.end(),
                                            [](const Medium& m) { return m.name == "water"; });
            surface.medium_below = static_cast<int>(found - context.media.begin());
            if (found == context.media.end()) context.media.push_back(water);
        }
    }
    surface.ior_above = table.number("ior_above", between(0.01, 100)).value_or(surface.ior_above);
    surface.ior_below = table.number("ior_below", between(0.01, 100)).value_or(surface.ior_below);
    // The numbers hold what the names mean, and a name that says no more than a number is one.
    if (surface.medium_above >= 0) {
        Medium& medium = context.media[static_cast<std::size_t>(surface.medium_above)];
        const bool varies = encloses(medium, surface, context);
        surface.ior_above = medium.ior.mean();
        if (!varies && !medium.present() && !medium.ior.disperses() && medium.priority == 0) surface.medium_above = -1;
    }
    if (surface.medium_below >= 0) {
        Medium& medium = context.media[static_cast<std::size_t>(surface.medium_below)];
        const bool varies = encloses(medium, surface, context);
        surface.ior_below = medium.ior.mean();
        if (!varies && medium.name == "water" && !medium.ior.disperses() && medium.priority == 0 &&
            surface.height_field)
            surface.medium_below = -1;
    }
}

/// What a mesh that bends light must have, and what of it a user should know.
void checkMesh(const TableReader& table, const MeshShape& shape, Surface& surface, LoadContext& context) {
    surface.closed = shape.closed();
    if (shape.closed_parts > 0 && !surface.closed) surface.closed_part = shape.a_closed_part;
    if (surface.event == SurfaceEvent::Mirror) return;
    const std::string file = *table.text("file");
    const std::size_t triangles = surface.mesh->triangles.size();
    if (shape.doubled * 2 == triangles)
        table.fail("file",
                   fmt::format("'{}': each face is there twice, as front and back; keep one of them, wound so that "
                               "its normal is on the side of ior_above",
                               file));
    if (shape.doubled > 0)
        table.fail("file", fmt::format("'{}': {} of {} faces are there twice; remove the doubles", file, shape.doubled,
                                       triangles));
    if (shape.turned > 0)
        context.monitor.warn(
            fmt::format("{}: '{}': {} of {} faces, {:.2g} % of the area, are wound against their neighbours: light "
                        "meets them from the "
                        "wrong side; make the normals consistent before export",
                        table.where("file"), file, shape.turned, triangles, 100 * shape.turned_share));
    if (surface.event == SurfaceEvent::Reflect || surface.thin || !surface.closed) return;
    if (!table.has("inside") && !table.has("ior_below"))
        table.fail("file",
                   fmt::format("'{}' is closed: say what it is made of, with inside = \"glass\" (a [[medium]]) or "
                               "ior_below; water seen from above is left open, a mirror has event = \"mirror\"",
                               file));
    if (shape.volume < 0)
        context.monitor.warn(
            fmt::format("{}: '{}' is closed and wound inwards, so that its inside is what lies around it; "
                        "turn its normals outwards before export",
                        table.where("file"), file));
}

void loadSphere(const TableReader& table, Surface& surface) {
    refuse(table, {"file", "up", "smooth", "rotation", "scale", "node", "material"},
           "is for kind = \"mesh\"; a sphere has 'radius'");
    const auto radius = table.number("radius", positive("m"));
    if (!radius) table.missing("radius", "0.2 [m]");
    surface.sphere = Sphere{table.vector3("position", anyNumber("m")).value_or(glm::dvec3(0)), *radius};
    surface.mesh = std::make_shared<TriangleMesh>(sphereMesh(surface.sphere->center, *radius, kSphereRings));
    surface.closed = true;
    if (!table.has("inside") && !table.has("ior_below") && surface.event != SurfaceEvent::Mirror &&
        surface.event != SurfaceEvent::Reflect)
        table.missing("inside", "\"glass\" (a [[medium]]), or ior_below");
}

glm::dvec3 middleOf(const TriangleMesh& mesh) {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (const glm::dvec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
    return 0.5 * (low + high);
}

}  // namespace

Surface loadSurface(const ConfigValue& value, std::size_t number, const Domain* domain, LoadContext& context) {
    std::vector<std::string> known{"name",      "kind",   "file",  "event",  "ior_above",
                                   "ior_below", "colour", "scale", "outside"};
    known.insert(known.end(), kHeightFieldKeys.begin(), kHeightFieldKeys.end());
    known.insert(known.end(), kMeshKeys.begin(), kMeshKeys.end());
    const TableReader table(value, "[[surface]]", known,
                            {"dispersion", "abbe", "cauchy", "roughness", "index", "thickness"});

    Surface surface;
    surface.name = table.text("name").value_or(fmt::format("surface {}", number));
    surface.where = table.where();
    surface.event =
        static_cast<SurfaceEvent>(table.choice("event", {"refract", "reflect", "both", "mirror"}).value_or(0));
    const bool mirror = surface.event == SurfaceEvent::Mirror;
    if (!mirror) refuse(table, {"colour"}, "is for event = \"mirror\"; what light passes is coloured by its medium");
    if (mirror) refuse(table, {"thin"}, "is for what light passes, and event = \"mirror\" lets none through");
    surface.colour = table.colour("colour", between(0, 1)).value_or(glm::dvec3(1));

    const auto kind = table.choice("kind", {"height_field", "mesh", "sphere"}).value_or(0);
    if (kind == 0) {
        loadHeightField(table, domain, surface, context);
        loadSides(table, "above", "below", surface, context);
        return surface;
    }
    refuse(table, kHeightFieldKeys, "is for kind = \"height_field\"");
    surface.thin = table.flag("thin").value_or(false);
    if (kind == 1) {
        refuse(table, {"radius"}, "is for kind = \"sphere\"");
        const auto file = table.text("file");
        if (!file) table.missing("file", "\"water.obj\"");
        MeshShape shape;
        surface.mesh = loadMeshKeys(table, *file, context, &shape);
        surface.smooth = table.flag("smooth").value_or(!shape.faceted || surface.mesh->shaded_smooth);
        checkMesh(table, shape, surface, context);
    } else {
        loadSphere(table, surface);
    }
    surface.center = middleOf(*surface.mesh);
    loadSides(table, "outside", "inside", surface, context);
    return surface;
}

}  // namespace photic
