# SPDX-License-Identifier: GPL-3.0-or-later
"""Suns and other lamps as the baker's [[light]] tables."""
import math

from .. import compat
from ..nodes import graph

LARGEST_DISC_DEG = 10.0     # that the baker takes


def is_baked(light_object):
    """Every light that shines, unless it was taken out."""
    light = light_object.data
    return light.photic.bake != "NO" and light.energy > 0 and max(light.color) > 0


def _is_plain(tree):
    """Whether a light's nodes leave it as it is: none, or those that Blender 5 gives to every light."""
    if tree is None:
        return True
    output = next((node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputLight" and node.is_active_output), None)
    emission = graph.source(output.inputs["Surface"]) if output else None
    if emission is None or emission.node.bl_idname != "ShaderNodeEmission":
        return False
    colour, strength = emission.node.inputs["Color"], emission.node.inputs["Strength"]
    return (not colour.is_linked and not strength.is_linked and strength.default_value == 1.0
            and tuple(colour.default_value)[:3] == (1.0, 1.0, 1.0))


def table(light_object, notes):
    """The [[light]] table. Blender's units: a point of P watts sends P / 4 pi to each side, an area P, before 4.0 pi / 4 of it."""
    light = light_object.data
    world = light_object.matrix_world
    colour = compat.light_level(light)
    level = colour[0] if max(colour) - min(colour) < 1e-6 * max(colour) else colour
    if not _is_plain(compat.shader_tree(light)):
        notes.append(f"the nodes of the light '{light_object.name}' are not baked; its strength and colour are")
    if not compat.is_normalized(light) and light.type != "SUN":
        notes.append(f"'{light_object.name}' is baked as if Normalize were on: its watts are taken for all that it sends")
    travel = [-c for c in world.col[2].to_3d().normalized()]
    common = {"name": light_object.name, "type": {"SUN": "sun", "POINT": "point", "SPOT": "spot", "AREA": "rectangle"}[light.type]}
    if light.type == "SUN":
        degrees = math.degrees(light.angle)
        if degrees > LARGEST_DISC_DEG:
            notes.append(f"the sun '{light_object.name}' is {degrees:.1f} degrees wide; {LARGEST_DISC_DEG:.0f} are baked")
        return {**common, "direction": travel, "irradiance": level, "angular_diameter": min(degrees, LARGEST_DISC_DEG)}
    if light.type != "AREA":
        if light.shadow_soft_size > 0:
            notes.append(f"the {light.type.lower()} light '{light_object.name}' is baked from its middle: its caustics are sharper "
                         f"than those of a ball of {light.shadow_soft_size:.3g} m")
        cone = {"direction": travel, "angle": math.degrees(light.spot_size), "blend": light.spot_blend} if light.type == "SPOT" else {}
        return {**common, "position": list(world.translation), "power": level, **cone}
    return {**common, "direction": travel, **_area(light_object, level, notes)}


def _area(light_object, level, notes):
    """Of a lamp with an area: discs and ellipses are baked as rectangles of their area."""
    light, world = light_object.data, light_object.matrix_world
    x, y = (world.col[i].to_3d() for i in (0, 1))
    size = [light.size * x.length, (light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size) * y.length]
    if light.shape in {"DISK", "ELLIPSE"}:
        size = [side * math.sqrt(math.pi) / 2 for side in size]
        notes.append(f"the round area light '{light_object.name}' is baked as a rectangle of the same area")
    if getattr(light, "spread", math.pi) < 0.999 * math.pi:
        notes.append(f"the Spread of the area light '{light_object.name}' is not baked: it is taken to shine to all sides")
    factor = compat.area_share()
    power = [factor * p for p in level] if isinstance(level, list) else factor * level
    return {"center": list(world.translation), "size": size, "tangent": list(x.normalized()), "power": power}
