// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <glm/geometric.hpp>
#include <numbers>

#include "bake/scene/load_parts.h"
#include "bake/scene/unit_vector.h"

namespace photic {

namespace {

/// The keys of a point light; `irradiance` holds its radiant intensity [W/sr] until it is aimed.
Light loadPoint(const TableReader& table, Light light) {
    for (const char* key : {"direction", "irradiance", "angular_diameter"})
        if (table.has(key))
            table.fail(key, fmt::format("'{}' is a sun's; a point light has 'position' [m] and 'power' [W]", key));
    light.position = table.vector3("position", anyNumber("m"));
    if (!light.position) table.missing("position", "[0, 0, 2.5]");
    const auto power = table.colour("power", notNegative("W"));
    if (!power) table.missing("power", "100 [W]");
    if (*power == glm::dvec3(0)) table.fail("power", "'power' is 0; a light must shine in at least one channel");
    light.irradiance = *power / (4 * std::numbers::pi);
    return light;
}

}  // namespace

void aimPointLight(Light& light, const Surface& surface, const std::string& where) {
    if (!surface.height_field)
        throw Error(ErrorCode::Input,
                    fmt::format("the point light '{}' shines on the mesh '{}', and point lights are built for height "
                                "fields only; use type = \"sun\"",
                                light.name, surface.name),
                    where);
    const double top = surface.height_field->maxZ();
    if (!(light.position->z > top))
        throw Error(ErrorCode::Input,
                    fmt::format("the point light '{}' lies at z = {} m, not above the surface '{}', which reaches up "
                                "to {:.4g} m; raise it",
                                light.name, light.position->z, surface.name, top),
                    where);
    const glm::dvec3 way = surface.center - *light.position;
    light.direction = unitVector(way);
    light.irradiance /= glm::dot(way, way);
}

Light loadLight(const ConfigValue& value, std::size_t number) {
    const TableReader table(value, "[[light]]",
                            {"name", "type", "direction", "irradiance", "angular_diameter", "position", "power"},
                            {"angle", "size", "temperature"});
    const auto type = table.choice("type", {"sun", "point"}, {"spot", "rectangle"});
    if (!type) table.missing("type", "\"sun\"");

    Light light;
    light.name = table.text("name").value_or(fmt::format("light {}", number));
    if (*type == 1) return loadPoint(table, light);
    for (const char* key : {"position", "power"})
        if (table.has(key)) table.fail(key, fmt::format("'{}' is a point light's; a sun has 'direction'", key));
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
        table.fail("irradiance", fmt::format("'irradiance' is {:g} W/m2; give {:g} to {:g}, the sun has 1000",
                                             brightest, kDimmest, kBrightest));
    if (light.irradiance == glm::dvec3(0))
        table.fail("irradiance", "'irradiance' is 0; a light must shine in at least one channel");
    light.angular_diameter_deg = table.number("angular_diameter", between(0, 10, "degrees")).value_or(0.53);
    return light;
}

}  // namespace photic
