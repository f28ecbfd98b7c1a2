# SPDX-License-Identifier: GPL-3.0-or-later
"""Suns and other lamps as the baker's [[light]] tables."""
import math

from .. import compat
from ..nodes import graph

LARGEST_DISC_DEG = 10.0     # that the baker takes


def is_baked(light_object):
    """Suns unless they were taken out; others only when they were asked for."""
    choice = light_object.data.photic.bake
    return choice == "YES" or (choice == "AUTO" and light_object.data.type == "SUN")


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
    """The [[light]] table; kinds that the baker has not learnt are written by their names, and refused by it."""
    light = light_object.data
    world = light_object.matrix_world
    colour = [light.energy * c for c in light.color]
    level = colour[0] if max(colour) - min(colour) < 1e-6 * max(colour) else colour
    if not _is_plain(compat.shader_tree(light)):
        notes.append(f"the nodes of the light '{light_object.name}' are not baked; its strength and colour are")
    travel = [-c for c in world.col[2].to_3d().normalized()]
    common = {"name": light_object.name, "type": {"SUN": "sun", "POINT": "point", "SPOT": "spot", "AREA": "rectangle"}[light.type]}
    if light.type == "SUN":
        degrees = math.degrees(light.angle)
        if degrees > LARGEST_DISC_DEG:
            notes.append(f"the sun '{light_object.name}' is {degrees:.1f} degrees wide; {LARGEST_DISC_DEG:.0f} are baked")
        return {**common, "direction": travel, "irradiance": level, "angular_diameter": min(degrees, LARGEST_DISC_DEG)}
    table_of = {**common, "position": list(world.translation), "power": level}
    if light.type != "POINT":
        table_of["direction"] = travel
    if light.type == "SPOT":
        table_of["angle"] = math.degrees(light.spot_size)
    if light.type == "AREA":
        table_of["size"] = [light.size, light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size]
    return table_of
