// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <glm/geometric.hpp>

#include "bake/scene/load_parts.h"
#include "bake/scene/unit_vector.h"

namespace photic {

Light loadLight(const ConfigValue& value, std::size_t number) {
    const TableReader table(value, "[[light]]", {"name", "type", "direction", "irradiance", "angular_diameter"},
                            {"position", "power", "angle", "size", "temperature"});
    table.choice("type", {"sun"}, {"point", "spot", "rectangle"});
    if (!table.has("type")) table.missing("type", "\"sun\"");

    Light light;
    light.name = table.text("name").value_or(fmt::format("light {}", number));
    const auto direction = table.vector3("direction", {});
    if (!direction) table.missing("direction", "[0.4, 0.2, -0.9]");
    if (*direction == glm::dvec3(0))
        table.fail("direction",
                   "'direction' has no length; give the direction that the light travels in, for example [0, 0, -1]");
    light.direction = unitVector(*direction);
    light.irradiance = table.colour("irradiance", notNegative("W/m2")).value_or(glm::dvec3(1000));
    // Beyond these, single precision runs out of range on the way to the volume, whose values are relative anyway.
    constexpr double kDimmest = 1e-12, kBrightest = 1e12;
    const double brightest = std::max({light.irradiance.x, light.irradiance.y, light.irradiance.z});
    if (brightest > kBrightest || (brightest > 0 && brightest < kDimmest))
        table.fail("irradiance", fmt::format("'irradiance' is {:g} W/m2; give {:g} to {:g}, the sun has 1000", brightest, kDimmest, kBrightest));
    if (light.irradiance == glm::dvec3(0))
        table.fail("irradiance", "'irradiance' is 0; a light must shine in at least one channel");
    light.angular_diameter_deg = table.number("angular_diameter", between(0, 10, "degrees")).value_or(0.53);
    return light;
}

}  // namespace photic
