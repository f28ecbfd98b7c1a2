// SPDX-License-Identifier: Apache-2.0
// `index` of a [[medium]]: an object whose index varies in space.
#include <fmt/format.h>

#include <array>

#include "bake/image/atomic_file.h"
#include "bake/scene/graded_index.h"
#include "bake/scene/index_volume.h"
#include "bake/scene/load_parts.h"
#include "bake/scene/placement.h"
#include "bake/scene/unit_vector.h"

namespace photic {
namespace {

using Graded = std::shared_ptr<const GradedIndex>;

Bounds anIndex() { return between(kLeastIndex, kLargestIndex); }

double required(const TableReader& table, const std::string& key, const Bounds& bounds, const std::string& example) {
    const auto value = table.number(key, bounds);
    if (!value) table.missing(key, example);
    return *value;
}

glm::dvec3 centerOf(const TableReader& table) {
    return table.vector3("center", withinReach("m")).value_or(glm::dvec3(0));
}

std::optional<WorldBox> boxOf(const TableReader& table) {
    const auto min = table.vector3("min", withinReach("m")), max = table.vector3("max", withinReach("m"));
    if (!min && !max) return {};
    if (!min) table.missing("min", "[-1, -1, -1]");
    if (!max) table.missing("max", "[1, 1, 1]");
    for (int a = 0; a < 3; ++a)
        if ((*min)[a] >= (*max)[a])
            table.fail("max", fmt::format("max.{0} is {1}, min.{0} is {2}: the box is empty; max must be greater",
                                          "xyz"[a], (*max)[a], (*min)[a]));
    return WorldBox{*min, *max};
}

Graded loadLuneburg(const TableReader& table) {
    return makeLuneburgLens(centerOf(table), required(table, "radius", positive("m"), "0.5 [m]"));
}

Graded loadFishEye(const TableReader& table) {
    return makeFishEye(centerOf(table), required(table, "n0", anIndex(), "2"),
                       required(table, "scale", positive("m"), "0.5 [m]"), table.number("radius", positive("m")));
}

Graded loadSelfoc(const TableReader& table) {
    SelfocRod rod;
    rod.center = centerOf(table);
    if (const auto axis = table.vector3("axis", {})) {
        if (*axis == glm::dvec3(0)) table.fail("axis", "'axis' has no length; give a direction, for example [0, 0, 1]");
        rod.axis = unitVector(*axis);
    }
    rod.n0 = required(table, "n0", anIndex(), "1.6");
    rod.g = required(table, "g", positive("1/m"), "0.5 [1/m]");
    rod.radius = table.number("radius", positive("m"));
    const auto length = table.number("length", positive("m"));
    if (rod.radius && !length) table.missing("length", "1.0 [m], of a rod with a radius");
    if (length && !rod.radius) table.missing("radius", "0.2 [m], of a rod with a length");
    rod.length = length.value_or(0);
    if (rod.radius && !(rod.g * *rod.radius < 1))
        table.fail("radius", fmt::format("n^2 = n0^2 (1 - g^2 r^2) is not above 0 at the rim: g r is {:.3g}; it must "
                                         "be less than 1",
                                         rod.g * *rod.radius));
    return makeSelfocRod(rod);
}

Graded loadLinear(const TableReader& table) {
    const auto slope = table.vector3("slope", between(-1e6, 1e6, "1/m"));
    if (!slope) table.missing("slope", "[0, 0, -0.5] [1/m], of n^2");
    return makeLinearSquare(centerOf(table), required(table, "n0", anIndex(), "1.5"), *slope, boxOf(table));
}

Graded loadHotAir(const TableReader& table) {
    HotAir air;
    air.ground = table.number("ground", withinReach("m")).value_or(air.ground);
    air.height = required(table, "height", positive("m"), "0.2 [m]");
    air.far_index = table.number("n", anIndex()).value_or(air.far_index);
    air.drop = required(table, "drop", between(-0.5, 0.5), "2e-5");
    return makeHotAir(air, boxOf(table));
}

Graded loadSalt(const TableReader& table) {
    SaltLayers salt;
    salt.n_above = table.number("n_above", anIndex()).value_or(salt.n_above);
    salt.n_below = table.number("n_below", anIndex()).value_or(salt.n_below);
    salt.level = table.number("level", withinReach("m")).value_or(salt.level);
    salt.thickness = required(table, "thickness", positive("m"), "0.05 [m]");
    salt.amplitude = table.number("amplitude", between(-1e6, 1e6, "m")).value_or(salt.amplitude);
    salt.wavelength = table.number("wavelength", positive("m")).value_or(salt.wavelength);
    return makeSaltLayers(salt, boxOf(table));
}

struct Procedure {
    const char* kind;
    std::vector<std::string> keys;
    Graded (*load)(const TableReader&);
};
const std::array<Procedure, 6>& procedures() {
    static const std::array<Procedure, 6> all{{
        {"luneburg", {"center", "radius"}, loadLuneburg},
        {"fish_eye", {"center", "n0", "scale", "radius"}, loadFishEye},
        {"selfoc", {"center", "axis", "n0", "g", "radius", "length"}, loadSelfoc},
        {"linear", {"center", "n0", "slope", "min", "max"}, loadLinear},
        {"hot_air", {"ground", "height", "n", "drop", "min", "max"}, loadHotAir},
        {"salt", {"n_above", "n_below", "level", "thickness", "amplitude", "wavelength", "min", "max"}, loadSalt},
    }};
    return all;
}

Graded loadProcedure(const ConfigValue& value) {
    const ConfigValue& kind = *value.find("kind");
    std::vector<std::string> kinds;
    for (const Procedure& procedure : procedures()) {
        kinds.emplace_back(procedure.kind);
        if (kind.kind != ConfigValue::Kind::String || kind.string != procedure.kind) continue;
        std::vector<std::string> keys = procedure.keys;
        keys.emplace_back("kind");
        const TableReader table(value, fmt::format("an index of the kind \"{}\"", procedure.kind), keys);
        return procedure.load(table);
    }
    // Says what there is, and what was nearly meant.
    const TableReader table(value, "'index'", [&] {
        std::vector<std::string> keys{"kind"};
        for (const ConfigEntry& entry : value.entries) keys.push_back(entry.key);
        return keys;
    }());
    (void)table.choice("kind", kinds);
    table.fail("kind", "'kind' must be a string");
}

glm::dmat3 axesOf(const Placement& placement) {
    glm::dmat3 axes = placement.rotation;
    for (int a = 0; a < 3; ++a) axes[a] *= placement.scale[a];
    return axes;
}

/// A file of samples with its place in the scene.
struct SampleFile {
    std::string where, path, grid;
    Placement placement{};
};

SampleFile sampleFile(const ConfigValue& value, const std::string& key, LoadContext& context) {
    if (value.kind == ConfigValue::Kind::String) return {value.where, context.path(value.string), ""};
    std::vector<std::string> known{"file", "grid"};
    known.insert(known.end(), placementKeys().begin(), placementKeys().end());
    const TableReader table(value, fmt::format("'{}'", key), known);
    const auto file = table.text("file");
    if (!file) table.missing("file", key == "index" ? "\"n.vdb\", or kind = \"luneburg\"" : "\"n.vdb\"");
    return {table.where("file"), context.path(*file), table.text("grid").value_or(""), loadPlacement(table)};
}

/// Reads a file and makes something of its bytes; errors without a place get that of its name.
template <class Make>
auto fromBytes(const SampleFile& file, LoadContext& context, const Make& make) {
    try {
        const std::string bytes = readFileBytes(file.path);
        context.hashBytes(bytes);
        return make(bytes);
    } catch (const Error& error) {
        if (error.code() == ErrorCode::Cancelled || !error.where().empty()) throw;
        throw Error(error.code(), error.what(), file.where);
    }
}

Graded loadSamples(const SampleFile& file, LoadContext& context) {
    return fromBytes(file, context, [&](const std::string& bytes) {
        auto volume = std::make_shared<IndexVolume>(readIndexVolume(file.path, bytes, file.grid, 1.0, context.monitor));
        return makeSampledIndex(std::move(volume), file.placement.position, axesOf(file.placement));
    });
}

Graded loadOne(const ConfigValue& value, LoadContext& context) {
    if (value.kind == ConfigValue::Kind::String) return loadSamples(sampleFile(value, "index", context), context);
    if (value.kind != ConfigValue::Kind::Table)
        throw Error(ErrorCode::Input,
                    fmt::format("'index' is {}; give a file, a table such as {{ kind = \"luneburg\", radius = 0.5 }}, "
                                "or three of either for red, green and blue",
                                value.kindName()),
                    value.where);
    if (value.find("kind")) return loadProcedure(value);
    return loadSamples(sampleFile(value, "index", context), context);
}

}  // namespace

std::vector<std::shared_ptr<const GradedIndex>> loadGradedIndex(const ConfigValue& value, LoadContext& context) {
    if (value.kind != ConfigValue::Kind::Array) return {loadOne(value, context)};
    if (value.items.size() != 3)
        throw Error(ErrorCode::Input,
                    fmt::format("'index' is an array of {}; give one index, or three for red, green and blue",
                                value.items.size()),
                    value.where);
    std::vector<Graded> out;
    for (const ConfigValue& item : value.items) out.push_back(loadOne(item, context));
    return out;
}

std::shared_ptr<const MediumVolume> loadMediumVolume(const TableReader& table, const MediumQuantity& quantity,
                                                     LoadContext& context) {
    const std::string key = fmt::format("{}_volume", quantity.name);
    if (!table.has(key)) return nullptr;
    const ConfigValue& value = *table.find(key);
    if (value.kind != ConfigValue::Kind::String && value.kind != ConfigValue::Kind::Table)
        throw Error(
            ErrorCode::Input,
            fmt::format("'{}' is {}; give a file, or a table such as {{ file = \"n.vdb\" }}", key, value.kindName()),
            value.where);
    const SampleFile file = sampleFile(value, key, context);
    return fromBytes(file, context, [&](const std::string& bytes) {
        return std::make_shared<const MediumVolume>(readMediumVolume(file.path, bytes, file.grid, quantity)
                                                        .moved(file.placement.position, axesOf(file.placement)));
    });
}

}  // namespace photic
