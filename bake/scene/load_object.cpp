// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "bake/scene/load_parts.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/placement.h"
#include "bake/scene/unit_vector.h"

namespace photic {
namespace {

constexpr int kSphereRings = 64;

Plane loadPlane(const ConfigValue& value) {
    const TableReader table(value, "'plane'", {"point", "normal"});
    const auto point = table.vector3("point", anyNumber("m"));
    if (!point) table.missing("point", "[0, 0, -1.5]");
    const glm::dvec3 normal = table.vector3("normal", {}).value_or(glm::dvec3(0, 0, 1));
    if (normal == glm::dvec3(0))
        table.fail("normal", "'normal' has no length; give a direction, for example [0, 0, 1]");
    return {*point, unitVector(normal)};
}

TriangleMesh loadBox(const ConfigValue& value) {
    const TableReader table(value, "'box'", {"min", "max"});
    const auto min = table.vector3("min", anyNumber("m")), max = table.vector3("max", anyNumber("m"));
    if (!min) table.missing("min", "[-1, -1, -1]");
    if (!max) table.missing("max", "[1, 1, 0]");
    for (int a = 0; a < 3; ++a)
        if ((*min)[a] >= (*max)[a])
            table.fail("max", fmt::format("max.{0} is {1}, min.{0} is {2}: the box is empty; max must be greater",
                                          "xyz"[a], (*max)[a], (*min)[a]));
    return boxMesh(*min, *max);
}

TriangleMesh loadSphere(const ConfigValue& value) {
    const TableReader table(value, "'sphere'", {"center", "radius"});
    const auto center = table.vector3("center", anyNumber("m"));
    if (!center) table.missing("center", "[0, 0, -1]");
    const auto radius = table.number("radius", positive("m"));
    if (!radius) table.missing("radius", "0.2 [m]");
    return sphereMesh(*center, *radius, kSphereRings);
}

std::shared_ptr<const TriangleMesh> moved(TriangleMesh mesh, const Placement& placement) {
    place(mesh, placement);
    return std::make_shared<TriangleMesh>(std::move(mesh));
}

}  // namespace

Object loadObject(const ConfigValue& value, std::size_t number, LoadContext& context) {
    const TableReader table(value, "[[object]]",
                            {"name", "plane", "file", "box", "sphere", "role", "up", "smooth", "position", "rotation",
                             "scale", "albedo", "node", "material"});
    Object object;
    object.name = table.text("name").value_or(fmt::format("object {}", number));
    object.where = table.where();
    object.role = static_cast<Role>(table.choice("role", {"receiver", "movable", "blocker"}).value_or(0));
    object.albedo = table.colour("albedo", between(0, 1));
    table.exclusive({"plane", "file", "box", "sphere"});
    for (const std::string& key : placementKeys())
        if (table.has(key) && table.has("plane"))
            table.fail(key,
                       fmt::format("'{}' is for shapes that end; a plane lies where 'point' and 'normal' say", key));
    for (const char* key : {"up", "smooth", "node", "material"})
        if (table.has(key) && !table.has("file")) table.fail(key, fmt::format("'{}' is for meshes from a file", key));

    if (const ConfigValue* plane = table.find("plane")) {
        object.shape = loadPlane(*plane);
    } else if (const ConfigValue* box = table.find("box")) {
        object.shape = moved(loadBox(*box), loadPlacement(table));
    } else if (const ConfigValue* sphere = table.find("sphere")) {
        object.shape = moved(loadSphere(*sphere), loadPlacement(table));
    } else if (const auto file = table.text("file")) {
        object.shape = loadMeshKeys(table, *file, context);
    } else {
        table.fail(
            "[[object]] has no shape; give plane = { point, normal }, file, box = { min, max } or sphere = { center, "
            "radius }");
    }
    return object;
}

}  // namespace photic
