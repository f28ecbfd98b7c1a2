// SPDX-License-Identifier: Apache-2.0
// What `photic voxelise` reads: meshes, profiles, and tables of several bodies.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "bake/image/atomic_file.h"
#include "bake/report/error.h"
#include "bake/scene/index_volume.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/mesh_shape.h"
#include "bake/scene/placement.h"
#include "bake/scene/solids.h"
#include "bake/scene/table_reader.h"

namespace photic {
namespace {

namespace fs = std::filesystem;

bool endsWith(const std::string& path, const std::string& end) { return fs::path(path).extension() == end; }

void checkProfile(const std::vector<glm::dvec2>& profile, const std::string& where) {
    if (profile.size() < 2)
        throw Error(ErrorCode::Input, fmt::format("the profile has {} points; a body needs 2 or more", profile.size()),
                    where);
    double reach = 0;
    for (const glm::dvec2& p : profile) {
        if (!(p.x >= 0) || !std::isfinite(p.x) || !std::isfinite(p.y))
            throw Error(ErrorCode::Input,
                        fmt::format("the profile has the point ({}, {}); a radius is 0 or more", p.x, p.y), where);
        reach = std::max(reach, p.x);
    }
    if (!(reach > 0)) throw Error(ErrorCode::Input, "the profile never leaves its axis; give radii above 0", where);
}

std::vector<glm::dvec2> readProfile(const std::string& path) {
    std::istringstream lines(readFileBytes(path));
    std::vector<glm::dvec2> profile;
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        if (const auto comment = line.find('#'); comment != std::string::npos) line.resize(comment);
        if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream values(line);
        glm::dvec2 p;
        std::string rest;
        if (!(values >> p.x >> p.y) || values >> rest) {
            if (profile.empty() && number == 1) continue;  // names of columns
            throw Error(ErrorCode::Input, "a line of a profile is a radius and a height [m], such as 0.02, 0.1",
                        fmt::format("{}:{}", path, number));
        }
        profile.push_back(p);
    }
    checkProfile(profile, path);
    return profile;
}

TriangleMesh readBody(const std::string& path, const Placement& placement, const std::string& where, Monitor& monitor) {
    TriangleMesh mesh = endsWith(path, ".csv") ? revolve(readProfile(path))
                                               : loadMesh(path, std::nullopt, monitor, [](std::string_view) {});
    if (!endsWith(path, ".csv") && !shapeOf(mesh).closed())
        throw Error(ErrorCode::Input,
                    fmt::format("the mesh '{}' is open, and has no inside to fill with samples; close it", path),
                    where);
    if (placement.moves()) {
        mesh.normals.resize(mesh.positions.size(), {0, 0, 1});
        place(mesh, placement);
    }
    return mesh;
}

bool isNumber(const ConfigValue& value) {
    return value.kind == ConfigValue::Kind::Integer || value.kind == ConfigValue::Kind::Number;
}

std::vector<glm::dvec2> profileOf(const TableReader& table) {
    const ConfigValue& value = *table.find("profile");
    std::vector<glm::dvec2> profile;
    if (value.kind == ConfigValue::Kind::Array)
        for (const ConfigValue& point : value.items) {
            if (point.kind != ConfigValue::Kind::Array || point.items.size() != 2 || !isNumber(point.items[0]) ||
                !isNumber(point.items[1]))
                table.fail("profile", "'profile' is an array of [radius, height] in metres, or a file's name");
            profile.emplace_back(point.items[0].number, point.items[1].number);
        }
    checkProfile(profile, table.where("profile"));
    return profile;
}

/// `painted` and `noise`: how the absorption varies.
AbsorptionPattern loadPattern(const TableReader& table) {
    AbsorptionPattern pattern;
    if (const ConfigValue* painted = table.find("painted")) {
        const auto fail = [&] {
            table.fail("painted",
                       "'painted' is an array of [height, r, g, b], metres and 1/m, 0 or more, the lowest "
                       "height first, such as [[0, 0, 0, 0], [0.1, 6, 55, 50]]");
        };
        if (painted->kind != ConfigValue::Kind::Array || painted->items.empty()) fail();
        for (const ConfigValue& layer : painted->items) {
            if (layer.kind != ConfigValue::Kind::Array || layer.items.size() != 4 ||
                !std::all_of(layer.items.begin(), layer.items.end(), isNumber))
                fail();
            const double height = layer.items[0].number;
            glm::dvec3 absorption;
            for (int c = 0; c < 3; ++c) {
                absorption[c] = layer.items[static_cast<std::size_t>(c) + 1].number;
                if (!std::isfinite(absorption[c]) || absorption[c] < 0) fail();
            }
            if (!std::isfinite(height) || (!pattern.painted.empty() && !(height > pattern.painted.back().first)))
                fail();
            pattern.painted.emplace_back(height, absorption);
        }
    }
    if (const ConfigValue* value = table.find("noise")) {
        const TableReader noise(*value, "noise", {"amount", "size", "octaves", "seed"});
        const auto size = noise.number("size", positive("m"));
        if (!size) noise.missing("size", "0.01");
        pattern.noise_size = *size;
        pattern.noise = noise.number("amount", between(0, 1)).value_or(0.5);
        pattern.octaves = static_cast<int>(noise.integer("octaves", 1, 8).value_or(3));
        pattern.seed = static_cast<std::uint32_t>(noise.integer("seed", 0, 1000000).value_or(1));
    }
    return pattern;
}

Solid loadSolid(const ConfigValue& value, std::size_t number, const std::string& directory, SolidsFile& out,
                Monitor& monitor) {
    std::vector<std::string> known{"name", "file", "profile", "ior", "absorption", "painted", "noise", "albedo"};
    known.insert(known.end(), placementKeys().begin(), placementKeys().end());
    const TableReader table(value, "[[solid]]", known);
    table.exclusive({"file", "profile"});
    Solid solid;
    solid.name = table.text("name").value_or(fmt::format("solid {}", number));
    solid.where = table.where();
    const auto ior = table.number("ior", between(kLeastIndex, kLargestIndex));
    if (!ior) table.missing("ior", "1.5");
    solid.ior = *ior;
    solid.absorption = table.colour("absorption", notNegative("1/m")).value_or(glm::dvec3(0));
    solid.albedo = table.colour("albedo", between(0, 1)).value_or(glm::dvec3(0));
    const Placement placement = loadPlacement(table);
    solid.pattern = loadPattern(table), solid.placement = placement;
    if (solid.pattern.noise > 0 && !solid.absorbs())
        table.fail("noise", "'noise' varies absorption, and the body has none; give 'absorption' or 'painted'");
    if (const auto file = table.text("file")) {
        out.files.push_back((fs::path(directory) / *file).string());
        solid.mesh = readBody(out.files.back(), placement, table.where("file"), monitor);
    } else if (table.has("profile")) {
        solid.mesh = revolve(profileOf(table));
        if (placement.moves()) {
            solid.mesh.normals.resize(solid.mesh.positions.size(), {0, 0, 1});
            place(solid.mesh, placement);
        }
    } else {
        table.missing("file", "\"body.ply\", or profile = [[0, 0], [0.1, 0], [0.1, 0.2], [0, 0.2]]");
    }
    return solid;
}

}  // namespace

SolidsFile loadSolids(const std::string& path, double ior, const glm::dvec3& absorption, Monitor& monitor) {
    SolidsFile out;
    out.files = {path};
    if (!endsWith(path, ".toml")) {
        out.solids.push_back(
            {fs::path(path).stem().string(), path, readBody(path, {}, path, monitor), ior, absorption});
        return out;
    }
    const ConfigValue root = parseConfig(readFileBytes(path), path);
    const TableReader table(root, "the file", {"voxel_size", "smooth", "solid"});
    out.voxel_size = table.number("voxel_size", positive("m")).value_or(0);
    out.smooth = table.number("smooth", between(0, 100, "voxels")).value_or(0);
    const ConfigValue* solids = table.find("solid");
    if (!solids || solids->kind != ConfigValue::Kind::Array || solids->items.empty())
        throw Error(ErrorCode::Input, "the file has no [[solid]]; add one with 'file' or 'profile' and 'ior'", path);
    for (const ConfigValue& item : solids->items)
        out.solids.push_back(
            loadSolid(item, out.solids.size() + 1, fs::path(path).parent_path().string(), out, monitor));
    return out;
}

}  // namespace photic
