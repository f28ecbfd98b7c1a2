// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "bake/scene/load_parts.h"

namespace photic {

Medium loadMedium(const ConfigValue& value, LoadContext& context) {
    if (value.kind == ConfigValue::Kind::Array && value.items.size() > 1)
        throw Error(ErrorCode::Input,
                    fmt::format("{} media are given, but only the one below the surface is built; keep one [medium]",
                                value.items.size()),
                    value.items[1].where);
    if (value.kind == ConfigValue::Kind::Array && value.items.size() == 1)
        throw Error(ErrorCode::Input, "there is one medium: write [medium], not [[medium]]", value.items[0].where);
    const TableReader table(value, "[medium]", {"absorption", "scattering", "extinction", "albedo", "anisotropy"},
                            {"index", "emission", "phase", "density"});

    // Either the two coefficients, or their sum and the share that is scattered.
    for (const char* pair : {"absorption", "scattering"})
        for (const char* total : {"extinction", "albedo"}) table.exclusive({pair, total});
    Medium medium;
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
    return medium;
}

}  // namespace photic
