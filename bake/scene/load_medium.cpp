// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "bake/scene/graded_index.h"
#include "bake/scene/index_volume.h"
#include "bake/scene/load_parts.h"
#include "bake/scene/load_toml.h"

namespace photic {
namespace {

const std::vector<std::string> kCoefficientKeys{"absorption", "scattering", "extinction", "albedo", "anisotropy"};
const std::vector<std::string> kIndexKeys{"ior", "abbe", "cauchy", "sellmeier"};

/// The numbers of an array that is one to `most` long.
std::vector<double> numbersOf(const TableReader& table, const std::string& key, std::size_t least, std::size_t most) {
    const ConfigValue& value = *table.find(key);
    const std::string wanted = least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most);
    if (value.kind != ConfigValue::Kind::Array || value.items.size() < least || value.items.size() > most)
        table.fail(key, fmt::format("'{}' must be an array of {} numbers", key, wanted));
    std::vector<double> out;
    for (const ConfigValue& item : value.items) {
        if ((item.kind != ConfigValue::Kind::Integer && item.kind != ConfigValue::Kind::Number) ||
            !std::isfinite(item.number))
            table.fail(key, fmt::format("'{}' must be an array of {} numbers", key, wanted));
        out.push_back(item.number);
    }
    return out;
}

/// @return nothing without any of the keys
std::optional<RefractiveIndex> loadRefractiveIndex(const TableReader& table) {
    table.exclusive(kIndexKeys);
    std::optional<RefractiveIndex> index;
    std::string key;
    if (const ConfigValue* ior = table.find("ior")) {
        key = "ior";
        const glm::dvec3 n = *table.colour("ior", between(kLeastIndex, kLargestIndex));
        index = ior->kind == ConfigValue::Kind::Array ? RefractiveIndex::channels(n) : RefractiveIndex(n.x);
    } else if (table.has("abbe")) {
        key = "abbe";
        const std::vector<double> given = numbersOf(table, key, 2, 2);
        if (given[1] <= 0)
            table.fail(key, fmt::format("'abbe' is [n, number] with a number of {}; it must be greater than 0, glasses "
                                        "have 20 to 85",
                                        given[1]));
        index = RefractiveIndex::abbe(given[0], given[1]);
    } else if (table.has("cauchy")) {
        key = "cauchy";
        index = RefractiveIndex::cauchy(numbersOf(table, key, 1, 6));
    } else if (table.has("sellmeier")) {
        key = "sellmeier";
        const std::vector<double> t = numbersOf(table, key, 6, 6);
        index = RefractiveIndex::sellmeier({t[0], t[1], t[2]}, {t[3], t[4], t[5]});
    }
    for (double nm = 380; index && nm <= 780; nm += 20) {
        const double n = index->at(nm);
        if (!(n >= kLeastIndex && n <= kLargestIndex))
            table.fail(key,
                       fmt::format("'{}' gives an index of {:.4g} at {} nm; it must be {} to {} from 380 to 780 nm "
                                   "(lengths in micrometres)",
                                   key, n, nm, kLeastIndex, kLargestIndex));
    }
    return index;
}

/// The keys that the water and named media share.
void loadCoefficients(const TableReader& table, Medium& medium, LoadContext& context) {
    // Either the two coefficients, or their sum and the share that is scattered.
    for (const char* pair : {"absorption", "scattering"})
        for (const char* total : {"extinction", "albedo"}) table.exclusive({pair, total});
    medium.absorption = table.colour("absorption", notNegative("1/m")).value_or(glm::dvec3(0));
    medium.scattering = table.colour("scattering", notNegative("1/m")).value_or(glm::dvec3(0));
    if (table.has("albedo") && !table.has("extinction")) table.missing("extinction", "0.2 [1/m]");
    if (const auto extinction = table.colour("extinction", notNegative("1/m"))) {
        medium.scattering = *extinction * table.colour("albedo", between(0, 1)).value_or(glm::dvec3(0));
        medium.absorption = *extinction - medium.scattering;
    }
    if (const auto g = table.number("anisotropy", {})) {
        if (!(*g > -1 && *g < 1))
            table.fail("anisotropy",
                       fmt::format("'anisotropy' is {}; it must lie between -1 and 1, both excluded", *g));
        medium.anisotropy = *g;
        if (medium.scattering == glm::dvec3(0))
            context.monitor.warn(
                fmt::format("{}: 'anisotropy' has no effect without scattering", table.where("anisotropy")));
    }
}

/// `face = { albedo = 0.4, roughness = 0.3 }`
FaceReflection loadFace(const ConfigValue& value, LoadContext& context) {
    if (value.kind != ConfigValue::Kind::Table)
        throw Error(
            ErrorCode::Input,
            fmt::format("'face' is {}; give a table such as {{ albedo = 0.4, roughness = 0.3 }}", value.kindName()),
            value.where);
    const TableReader table(value, "'face'", {"albedo", "albedo_volume", "roughness"});
    table.exclusive({"albedo", "albedo_volume"});
    FaceReflection face;
    face.albedo = table.colour("albedo", between(0, 1)).value_or(glm::dvec3(0));
    face.albedo_volume = loadMediumVolume(table, kAlbedo, context);
    face.roughness = table.number("roughness", between(0, 1)).value_or(0);
    if (!face.reflects())
        context.monitor.warn(
            fmt::format("{}: 'face' changes nothing; give it 'albedo', 'albedo_volume' or 'roughness'", value.where));
    return face;
}

/// A medium whose index varies.
void addGraded(const TableReader& table, Medium medium, LoadContext& context) {
    for (const std::string& key : kIndexKeys) table.exclusive({"index", key});
    for (const char* key : {"absorption", "extinction"}) table.exclusive({"absorption_volume", key});
    table.exclusive({"emission_volume", "emission"});
    table.exclusive({"anisotropy_volume", "anisotropy"});
    GradedObject object{
        medium.name,       medium.where,      loadGradedIndex(*table.find("index"), context), medium.absorption,
        medium.scattering, medium.anisotropy, loadMediumVolume(table, kAbsorption, context)};
    object.emission = table.colour("emission", notNegative("W/(m3 sr)")).value_or(glm::dvec3(0));
    object.emission_volume = loadMediumVolume(table, kEmission, context);
    object.anisotropy_volume = loadMediumVolume(table, kAnisotropy, context);
    if (const ConfigValue* face = table.find("face")) object.face = loadFace(*face, context);
    if (object.anisotropy_volume && medium.scattering == glm::dvec3(0))
        context.monitor.warn(
            fmt::format("{}: 'anisotropy_volume' has no effect without scattering", table.where("anisotropy_volume")));
    context.graded.push_back(std::move(object));
    // Surfaces that name it say where they stand; until then it has the index of its middle.
    const auto box = context.graded.back().index.front()->bounds().value_or(WorldBox{});
    medium.ior = indexAt(context.graded.back(), 0.5 * (box.min + box.max));
    context.media.push_back(std::move(medium));
}

void loadNamed(const ConfigValue& value, LoadContext& context) {
    std::vector<std::string> known{
        "name", "priority", "index", "absorption_volume", "emission", "emission_volume", "anisotropy_volume", "face"};
    known.insert(known.end(), kCoefficientKeys.begin(), kCoefficientKeys.end());
    known.insert(known.end(), kIndexKeys.begin(), kIndexKeys.end());
    const TableReader table(value, "[[medium]]", known, {"phase", "density"});
    Medium medium;
    const auto name = table.text("name");
    if (!name) table.missing("name", "\"glass\", or write [medium] for the water alone");
    medium.name = *name, medium.where = table.where();
    for (const Medium& other : context.media)
        if (other.name == medium.name)
            table.fail("name", fmt::format("the name '{}' is taken by {}; choose another", medium.name, other.where));
    loadCoefficients(table, medium, context);
    medium.priority = static_cast<int>(table.integer("priority", -1000000, 1000000).value_or(0));
    if (table.has("index")) return addGraded(table, std::move(medium), context);
    for (const char* key : {"absorption_volume", "anisotropy_volume"})
        if (table.has(key))
            table.fail(key,
                       fmt::format("'{0}_volume' is for a medium with an 'index' of its own; give '{0}' to what lies "
                                   "between surfaces",
                                   std::string(key).substr(0, std::string(key).find('_'))));
    for (const char* key : {"emission", "emission_volume"})
        if (table.has(key))
            table.fail(key, fmt::format("'{}' is for a medium with an 'index' of its own; what lies between surfaces "
                                        "does not shine",
                                        key));
    if (table.has("face"))
        table.fail("face",
                   "'face' is for a medium with an 'index' of its own, which eye rays in games see; faces between "
                   "surfaces reflect as Fresnel's equations say");
    const auto index = loadRefractiveIndex(table);
    if (!index) table.missing("ior", "1.5, or abbe = [1.52, 64], or index = { kind = \"luneburg\", radius = 0.5 }");
    medium.ior = *index;
    context.media.push_back(std::move(medium));
}

}  // namespace

void loadMedia(const ConfigValue& value, LoadContext& context) {
    if (value.kind == ConfigValue::Kind::Array) {
        for (const ConfigValue* item : tablesOf(&value, "medium")) loadNamed(*item, context);
        // Of named media "water" is what lies below height fields.
        const auto water =
            std::find_if(context.media.begin(), context.media.end(), [](const Medium& m) { return m.name == "water"; });
        if (water != context.media.end() && !gradedNamed(context, "water"))
            context.water = *water, context.water_index = water->ior;
        return;
    }
    std::vector<std::string> known = kCoefficientKeys;
    known.insert(known.end(), kIndexKeys.begin(), kIndexKeys.end());
    const TableReader table(value, "[medium]", known, {"index", "emission", "phase", "density"});
    loadCoefficients(table, context.water, context);
    context.water.where = table.where();
    context.water_index = loadRefractiveIndex(table);
    if (context.water_index) context.water.ior = *context.water_index;
}

GradedObject* gradedNamed(LoadContext& context, const std::string& name) {
    const auto found = std::find_if(context.graded.begin(), context.graded.end(),
                                    [&](const GradedObject& object) { return object.name == name; });
    return found == context.graded.end() ? nullptr : &*found;
}

RefractiveIndex indexAt(const GradedObject& object, const glm::dvec3& world) {
    // Where a formula has no index that could be, the bake says so, with the place.
    const auto at = [&](std::size_t channel) {
        const double n = object.index[channel]->indexAt(world);
        return n >= kLeastIndex ? std::min(n, kLargestIndex) : 1.0;
    };
    return object.index.size() > 1 ? RefractiveIndex::channels({at(0), at(1), at(2)}) : RefractiveIndex(at(0));
}

int mediumNamed(const TableReader& table, const std::string& key, LoadContext& context) {
    const auto name = table.text(key);
    if (!name) return -1;
    const auto found = [&] {
        return std::find_if(context.media.begin(), context.media.end(),
                            [&](const Medium& m) { return m.name == *name; });
    };
    if (found() == context.media.end() && (*name == "air" || *name == "vacuum" || *name == "water")) {
        // Three that need no table.
        Medium medium;
        if (*name == "water") {
            constexpr double kWaterIndex = 1.333;
            medium = context.water;
            medium.ior = context.water_index.value_or(RefractiveIndex(kWaterIndex));
        }
        medium.name = *name;
        context.media.push_back(medium);
    }
    if (found() == context.media.end()) {
        std::vector<std::string> names{"air", "water"};
        for (const Medium& medium : context.media)
            if (std::find(names.begin(), names.end(), medium.name) == names.end()) names.push_back(medium.name);
        const std::string near = nearestName(*name, names);
        table.fail(key, fmt::format("there is no [[medium]] called '{}'; {}", *name,
                                    near.empty() ? fmt::format("there are {}", fmt::join(names, ", "))
                                                 : fmt::format("did you mean '{}'?", near)));
    }
    return static_cast<int>(found() - context.media.begin());
}

}  // namespace photic
