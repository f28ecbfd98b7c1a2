// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "bake/scene/load_parts.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/wave_field.h"

namespace photic {
namespace {

const std::vector<std::string> kMeshKeys{"up", "smooth"};
const std::vector<std::string> kFileKeys{"channel", "scale", "level", "displacement", "displacement_channels",
                                         "texels"};
const std::vector<std::string> kSources{"file", "waves", "bump", "sea", "flat"};
const std::vector<std::string> kHeightFieldKeys{
    "channel",    "scale",   "level",  "displacement", "displacement_channels",
    "waves",      "animate", "bump",   "sea",          "flat",
    "height",     "size",    "center", "outside",      "interpolation",
    "frame_rate", "texels"};

void refuse(const TableReader& table, const std::vector<std::string>& keys, const char* reason) {
    for (const std::string& key : keys)
        if (table.has(key)) table.fail(key, fmt::format("'{}' {}", key, reason));
}

/// Half the patch that covers the domain's footprint about `center`, on each axis.
glm::dvec2 footprintAround(const Domain& domain, glm::dvec2 center) {
    return glm::max(glm::abs(glm::dvec2(domain.min) - center), glm::abs(glm::dvec2(domain.max) - center));
}

void loadHeightField(const TableReader& table, const Domain* domain, Surface& surface, LoadContext& context) {
    refuse(table, kMeshKeys, "is for kind = \"mesh\"");
    HeightFieldPlace place;
    place.center = table.vector3("center", anyNumber("m")).value_or(glm::dvec3(0));
    place.size = table.vector2("size", positive("m")).value_or(glm::dvec2(0));
    place.outside_given = table.has("outside");
    place.outside = static_cast<Outside>(table.choice("outside", {"flat", "periodic", "none"}).value_or(0));
    place.frame_rate = table.number("frame_rate", positive("1/s")).value_or(context.frame_rate);

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
}

}  // namespace

std::shared_ptr<const TriangleMesh> loadMeshKeys(const TableReader& table, const std::string& file,
                                                 LoadContext& context, bool refuse_closed) {
    std::optional<UpAxis> up;
    if (const auto axis = table.choice("up", {"y", "z"})) up = static_cast<UpAxis>(*axis);
    const bool smooth = table.flag("smooth").value_or(true);
    return placed(table, "file", [&] {
        TriangleMesh mesh = loadMesh(context.path(file), up, context.monitor,
                                     [&](std::string_view bytes) { context.hashBytes(bytes); });
        if (refuse_closed && hasClosedPart(mesh))
            table.fail("file", fmt::format("'{}' is closed: glass with an inside is not built yet; leave the mesh "
                                           "open, as water seen from above is, or set event = \"reflect\"",
                                           file));
        return std::make_shared<TriangleMesh>(smooth ? std::move(mesh) : withFacetNormals(mesh));
    });
}

Surface loadSurface(const ConfigValue& value, std::size_t number, const Domain* domain, LoadContext& context) {
    std::vector<std::string> known{"name", "kind", "file", "event", "ior_above", "ior_below"};
    known.insert(known.end(), kHeightFieldKeys.begin(), kHeightFieldKeys.end());
    known.insert(known.end(), kMeshKeys.begin(), kMeshKeys.end());
    const TableReader table(value, "[[surface]]", known,
                            {"dispersion", "abbe", "cauchy", "roughness", "index", "thickness"});

    Surface surface;
    surface.name = table.text("name").value_or(fmt::format("surface {}", number));
    surface.where = table.where();
    surface.event = static_cast<SurfaceEvent>(table.choice("event", {"refract", "reflect", "both"}).value_or(0));
    surface.ior_above = table.number("ior_above", between(0.01, 100)).value_or(surface.ior_above);
    surface.ior_below = table.number("ior_below", between(0.01, 100)).value_or(surface.ior_below);

    if (table.choice("kind", {"height_field", "mesh"}).value_or(0) == 0) {
        loadHeightField(table, domain, surface, context);
    } else {
        refuse(table, kHeightFieldKeys, "is for kind = \"height_field\"");
        const auto file = table.text("file");
        if (!file) table.missing("file", "\"water.obj\"");
        surface.mesh = loadMeshKeys(table, *file, context, surface.event != SurfaceEvent::Reflect);
    }
    return surface;
}

}  // namespace photic
