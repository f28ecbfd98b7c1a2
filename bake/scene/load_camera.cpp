// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <glm/geometric.hpp>

#include "bake/scene/load_parts.h"
#include "bake/scene/unit_vector.h"

namespace photic {

Camera loadCamera(const ConfigValue& value, std::size_t number) {
    const TableReader table(value, "[[camera]]", {"name", "position", "target", "up", "field_of_view"});
    Camera camera;
    camera.name = table.text("name").value_or(fmt::format("camera {}", number));
    camera.where = table.where();
    const auto position = table.vector3("position", anyNumber("m")), target = table.vector3("target", anyNumber("m"));
    if (!position) table.missing("position", "[3, -4, 2]");
    if (!target) table.missing("target", "[0, 0, -1]");
    camera.position = *position, camera.target = *target;
    if (camera.position == camera.target) table.fail("target", "'target' is where the camera stands; move one of them");
    const glm::dvec3 up = table.vector3("up", {}).value_or(glm::dvec3(0, 0, 1));
    const glm::dvec3 sight = unitVector(camera.target - camera.position);
    if (up == glm::dvec3(0)) table.fail("up", "'up' has no length; give a direction, for example [0, 0, 1]");
    camera.up = unitVector(up);
    if (glm::length(glm::cross(camera.up, sight)) < 1e-9)
        table.fail(table.has("up") ? "up" : "target",
                   "the camera looks along its own 'up'; for a look straight down give up = [0, 1, 0]");
    camera.field_of_view_deg =
        table.number("field_of_view", {0, 179, true, "degrees"}).value_or(camera.field_of_view_deg);
    return camera;
}

}  // namespace photic
