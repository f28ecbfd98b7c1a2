// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "bake/scene/load_parts.h"
#include "bake/scene/unit_vector.h"

namespace photic {

namespace {

/// Keys of each type besides `name` and `type`, in the order of LightType.
const std::vector<std::vector<std::string>> kKeys{{"direction", "irradiance", "angular_diameter"},
                                                  {"position", "power"},
                                                  {"position", "direction", "power", "angle", "blend"},
                                                  {"center", "size", "direction", "tangent", "power", "samples"}};
const std::vector<std::string> kTypes{"sun", "point", "spot", "rectangle"};

void refuseOtherKeys(const TableReader& table, std::size_t type) {
    for (std::size_t other = 0; other < kKeys.size(); ++other)
        for (const std::string& key : kKeys[other])
            if (table.has(key) && std::find(kKeys[type].begin(), kKeys[type].end(), key) == kKeys[type].end())
                table.fail(key, fmt::format("'{}' is a {}'s; a {} has {}", key, kTypes[other], kTypes[type],
                                            fmt::join(kKeys[type], ", ")));
}

glm::dvec3 loadDirection(const TableReader& table) {
    const auto direction = table.vector3("direction", {});
    if (!direction) table.missing("direction", "[0.4, 0.2, -0.9]");
    if (*direction == glm::dvec3(0))
        table.fail("direction",
                   "'direction' has no length; give the direction that the light travels in, for example [0, 0, -1]");
    return unitVector(*direction);
}

// Beyond these, single precision runs out of range on the way to the volume, whose values are relative anyway.
constexpr double kDimmest = 1e-12, kBrightest = 1e12;

/// Irradiance or power: some light in some channel, within what can be told apart.
void checkBrightness(const TableReader& table, const std::string& key, const char* unit, const glm::dvec3& value,
                     const char* example) {
    const double brightest = std::max({value.x, value.y, value.z});
    if (brightest == 0) table.fail(key, fmt::format("'{}' is 0; a light must shine in at least one channel", key));
    if (brightest > kBrightest || brightest < kDimmest)
        table.fail(key, fmt::format("'{}' is {:g} {}; give {:g} to {:g}, {}", key, brightest, unit, kDimmest,
                                    kBrightest, example));
}

void loadPower(const TableReader& table, Light& light) {
    const auto power = table.colour("power", notNegative("W"));
    if (!power) table.missing("power", "100 [W]");
    checkBrightness(table, "power", "W", *power, "a lamp has 100");
    light.power = *power;
}

void loadSun(const TableReader& table, Light& light) {
    light.direction = loadDirection(table);
    light.irradiance = table.colour("irradiance", notNegative("W/m2")).value_or(glm::dvec3(1000));
    checkBrightness(table, "irradiance", "W/m2", light.irradiance, "the sun has 1000");
    light.angular_diameter_deg = table.number("angular_diameter", between(0, 10, "degrees")).value_or(0.53);
}

void loadPoint(const TableReader& table, Light& light) {
    light.position = table.vector3("position", anyNumber("m"));
    if (!light.position) table.missing("position", "[0, 0, 2.5]");
    loadPower(table, light);
}

void loadSpot(const TableReader& table, Light& light) {
    loadPoint(table, light);
    light.direction = loadDirection(table);
    light.cone_angle_deg = table.number("angle", {0, 180, true, "degrees"}).value_or(45);
    light.blend = table.number("blend", between(0, 1)).value_or(0.15);
}

void loadRectangle(const TableReader& table, Light& light) {
    light.position = table.vector3("center", anyNumber("m"));
    if (!light.position) table.missing("center", "[0, 0, 2.5]");
    const auto size = table.vector2("size", positive("m"));
    if (!size) table.missing("size", "[0.5, 0.5] [m]");
    light.size = *size;
    light.direction = loadDirection(table);
    const glm::dvec3 aside = std::fabs(light.direction.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 given = table.vector3("tangent", {}).value_or(aside);
    const glm::dvec3 across = given - glm::dot(given, light.direction) * light.direction;
    if (glm::length(across) <= 1e-9 * glm::length(given))
        table.fail("tangent",
                   "'tangent' is along 'direction', or has no length; give the way that the side size[0] runs");
    light.tangent = unitVector(across);
    loadPower(table, light);
    light.samples = static_cast<int>(table.integer("samples", 1, 4096).value_or(light.samples));
}

}  // namespace

void aimLight(Light& light, const glm::dvec3& center, const std::string& name, double least_distance) {
    if (!light.position) return;
    const glm::dvec3 way = center - *light.position;
    const double squared = std::max(glm::dot(way, way), least_distance * least_distance);
    if (!(squared > 0))
        throw Error(ErrorCode::Input,
                    fmt::format("the light '{}' stands in the centre of '{}', which it is to shine on; move it",
                                light.name, name),
                    light.where);
    if (light.type == LightType::Point && way != glm::dvec3(0)) light.direction = unitVector(way);
    const double solid = light.type == LightType::Rectangle ? std::numbers::pi : 4 * std::numbers::pi;
    light.irradiance = light.power / (solid * squared);
}

Light loadLight(const ConfigValue& value, std::size_t number) {
    std::vector<std::string> known{"name", "type"};
    for (const auto& keys : kKeys)
        for (const std::string& key : keys)
            if (std::find(known.begin(), known.end(), key) == known.end()) known.push_back(key);
    const TableReader table(value, "[[light]]", known, {"temperature", "spread", "shape"});
    const auto type = table.choice("type", kTypes);
    if (!type) table.missing("type", "\"sun\"");
    refuseOtherKeys(table, *type);

    Light light;
    light.name = table.text("name").value_or(fmt::format("light {}", number));
    light.where = table.where();
    light.type = static_cast<LightType>(*type);
    constexpr void (*kLoaders[])(const TableReader&, Light&) = {loadSun, loadPoint, loadSpot, loadRectangle};
    kLoaders[*type](table, light);
    return light;
}

}  // namespace photic
