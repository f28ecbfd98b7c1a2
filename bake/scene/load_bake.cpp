// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "bake/scene/load_parts.h"
#include "bake/scene/load_toml.h"
#include "bake/scene/setting_names.h"

namespace photic {
namespace {

GridSet loadGrids(const TableReader& table) {
    if (!table.find("grids")) return {};
    GridSet grids = kNoGrids;
    const std::vector<std::string> names = *table.texts("grids");
    if (names.empty()) table.fail("grids", "'grids' is empty; ask for at least \"irradiance\"");
    for (const std::string& name : names) {
        if (wantGrid(grids, name)) continue;
        const std::string near = nearestName(name, gridNames());
        table.fail("grids", fmt::format("unknown grid \"{}\"; {}", name,
                                        near.empty() ? fmt::format("known: {}", fmt::join(gridNames(), ", "))
                                                     : fmt::format("did you mean \"{}\"?", near)));
    }
    if (grids.direction && !grids.irradiance)
        table.fail("grids", "\"direction\" is weighted by \"irradiance\" and useless without it; ask for both");
    return grids;
}

GivenOptions loadOptions(const ConfigValue& table, const std::string& method) {
    GivenOptions options;
    for (const auto& [key, value] : table.entries) {
        GivenOption option{{}, value.where};
        switch (value.kind) {
            case ConfigValue::Kind::Boolean:
                option.value = value.boolean;
                break;
            case ConfigValue::Kind::Integer:
                option.value = value.integer;
                break;
            case ConfigValue::Kind::Number:
                option.value = value.number;
                break;
            case ConfigValue::Kind::String:
                option.value = value.string;
                break;
            default:
                throw Error(ErrorCode::Input,
                            fmt::format("'{}' in [bake.{}] is {}; an option is a number, a string, true or false", key,
                                        method, value.kindName()),
                            value.where);
        }
        options.emplace(key, std::move(option));
    }
    return options;
}

}  // namespace

BakeSettings loadBake(const ConfigValue& value) {
    std::vector<std::string> known{"method",    "grids", "where", "band",      "paths",   "quadrature", "tolerance",
                                   "prefilter", "lobes", "error", "lobe_axis", "bounces", "threshold"};
    // Any table in here holds a method's own options: which methods there are is the catalogue's to say.
    BakeSettings bake;
    if (value.kind == ConfigValue::Kind::Table)
        for (const auto& [key, entry] : value.entries)
            if (entry.kind == ConfigValue::Kind::Table) {
                bake.method_options[key] = loadOptions(entry, key);
                if (std::find(known.begin(), known.end(), key) == known.end()) known.push_back(key);
            }
    const TableReader table(value, "[bake]", known, {"budget_mb", "seconds"});

    bake.method = table.text("method").value_or(bake.method);
    bake.grids = loadGrids(table);
    bake.where = static_cast<Where>(table.choice("where", kWhereNames).value_or(0));
    bake.band = static_cast<int>(table.integer("band", 0, 1024).value_or(bake.band));
    bake.paths = static_cast<Paths>(table.choice("paths", kPathsNames).value_or(0));
    bake.quadrature = static_cast<int>(table.integer("quadrature", 1, 12).value_or(0));
    constexpr int kPoints[] = {0, 1, 2, 4, 6, 8, 12};
    if (std::find(std::begin(kPoints), std::end(kPoints), bake.quadrature) == std::end(kPoints))
        table.fail("quadrature", fmt::format("'quadrature' is {}; it must be 1, 2, 4, 6, 8 or 12", bake.quadrature));
    bake.tolerance = table.number("tolerance", {0, 100, true, "voxels"}).value_or(bake.tolerance);
    bake.prefilter = table.flag("prefilter").value_or(bake.prefilter);
    bake.error = table.number("error", {0, 1, true, ""});
    bake.lobes = static_cast<int>(table.integer("lobes", 1, 2).value_or(bake.lobes));
    if (const auto axis = table.vector3("lobe_axis", withinReach(""))) {
        if (!(glm::length(*axis) > 0)) table.fail("lobe_axis", "'lobe_axis' is [0, 0, 0]; it must have a direction");
        bake.lobe_axis = glm::normalize(*axis);
    }
    if (const auto bounces = table.integer("bounces", 1, 1000)) bake.bounces = static_cast<int>(*bounces);
    bake.threshold = table.number("threshold", {0, 1, true, ""});
    return bake;
}

}  // namespace photic
