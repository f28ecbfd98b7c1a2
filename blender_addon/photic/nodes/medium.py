# SPDX-License-Identifier: GPL-3.0-or-later
"""The Medium group: single scattering of the light in a volume, and the medium's extinction, as a volume shader.

Nothing is scattered at random: the volume's light becomes emission, so a few samples are enough.
"""
import math

import bpy

from .. import compat
from . import build, graph, groups

UNDER_WATER, STRENGTH = "Under water", "Strength"
# A grid of numbers falls off over the last voxel by itself, and would be dimmed twice if it were multiplied by the density;
# Cycles' grids of colours (3.4) stay bright up to the last voxel's side, and are cut by it.
FRINGE = 0.02
LEAST_EXTINCTION = 1e-3     # [1/m]; EEVEE 3.4 shows emission without extinction 19 times too bright


def build_material(volume_object, medium, layout, has_density, under_water, strength):
    """(Re)builds the group and the material of a volume, and returns the material.

    `medium` has absorption, scattering [1/m] and anisotropy; `layout` is the volume's atlas, which says what stored irradiance is a
    multiple of, whether it is coloured, and whether there is a second lobe.
    Irradiance and direction are interpolated apart by Blender; see docs/light_volume.md for what that costs.
    """
    tree = groups.fresh(
        groups.named("Medium", volume_object),
        [("NodeSocketColor", "Absorption", (0.0, 0.0, 0.0, 1.0)), ("NodeSocketColor", "Scattering", (0.05, 0.05, 0.05, 1.0)),
         ("NodeSocketFloat", "Anisotropy", 0.0)],
        [("NodeSocketShader", "Volume", None)])
    b = build.Builder(tree)
    given = b.node("NodeGroupInput")
    absorption, scattering, g = (given.outputs[name] for name in ("Absorption", "Scattering", "Anisotropy"))
    scattered, irradiance = None, None
    for suffix in ("", "_2") if layout.image_2 else ("",):
        light = b.node("ShaderNodeAttribute", attribute_name="irradiance" + suffix).outputs["Color"]
        lobe = b.vector("SCALE", light, scale=_phase(b, tree, volume_object, "direction" + suffix, g))
        scattered = b.vector("ADD", scattered, lobe) if scattered else lobe
        irradiance = b.vector("ADD", irradiance, light) if irradiance else light
    mask = _mask(b, irradiance, has_density)
    scale = b.math("MULTIPLY", b.math("MULTIPLY", b.value(STRENGTH, strength), b.value(UNDER_WATER, under_water)),
                   b.math("MULTIPLY", mask if layout.rgb_image else b.math("GREATER_THAN", mask, FRINGE), layout.scale))
    radiance = b.vector("SCALE", b.vector("MULTIPLY", scattered, scattering), scale=scale)
    emission = b.node("ShaderNodeEmission")
    b.plug(radiance, emission.inputs["Color"])

    both = b.node("ShaderNodeAddShader")
    b.plug(emission.outputs[0], both.inputs[0])
    b.plug(_extinction(b, b.vector("ADD", absorption, scattering), mask), both.inputs[1])
    out = b.node("NodeGroupOutput")
    b.plug(both.outputs[0], out.inputs["Volume"])
    return _material(volume_object, tree, medium)


def _mask(b, irradiance, has_density):
    """1 in the medium. Without a gate a renderer fills the whole padded box with the medium."""
    if has_density:
        return b.node("ShaderNodeAttribute", attribute_name="density").outputs[2]
    return b.math("GREATER_THAN", b.vector("DOT_PRODUCT", irradiance, (1.0, 1.0, 1.0)), 1e-6)


def _phase(b, tree, volume_object, grid, g):
    """Towards the camera, of light that travels as a grid of directions says."""
    turn = b.node("ShaderNodeVectorRotate", "Into the world", rotation_type="EULER_XYZ")
    groups.drive_rotation(tree, turn, volume_object)
    b.plug(b.node("ShaderNodeAttribute", attribute_name=grid).outputs["Vector"], turn.inputs["Vector"])
    return _henyey_greenstein(b, turn.outputs[0], g)


def _henyey_greenstein(b, direction, g):
    """p(cos) [1/sr] with g times the direction's length: light from many sides scatters as evenly as it arrives."""
    incoming = b.node("ShaderNodeNewGeometry").outputs["Incoming"]
    length = b.vector("LENGTH", direction)
    cosine = b.math("DIVIDE", b.vector("DOT_PRODUCT", direction, incoming), b.math("MAXIMUM", length, 1e-6))
    g = b.math("MULTIPLY", g, b.math("MINIMUM", length, 1.0))
    g2 = b.math("MULTIPLY", g, g)
    base = b.math("MULTIPLY_ADD", b.math("MULTIPLY", g, cosine), -2.0, b.math("ADD", g2, 1.0))
    return b.math("DIVIDE", b.math("MULTIPLY", b.math("SUBTRACT", 1.0, g2), 1 / (4 * math.pi)),
                  b.math("POWER", base, 1.5))


def _extinction(b, extinction, mask):
    """Volume Absorption takes density * (1 - colour): the largest channel is the density."""
    x, y, z = b.split(extinction)
    largest = b.math("MAXIMUM", b.math("MAXIMUM", x, y), b.math("MAXIMUM", z, LEAST_EXTINCTION))
    white = b.vector("SUBTRACT", (1.0, 1.0, 1.0), b.vector("DIVIDE", extinction, b.join(largest, largest, largest)))
    node = b.node("ShaderNodeVolumeAbsorption")
    b.plug(white, node.inputs["Color"])
    b.plug(b.math("MULTIPLY", largest, mask), node.inputs["Density"])
    return node.outputs[0]


def _material(volume_object, tree, medium):
    name = groups.named("Medium", volume_object)
    material = bpy.data.materials.get(name)
    if material is None or not graph.is_ours(material):
        material = bpy.data.materials.new(name)
        compat.mark(material)
    compat.switch_nodes(material, True)
    material.node_tree.nodes.clear()
    b = build.Builder(material.node_tree)
    group = b.node("ShaderNodeGroup", "Medium", node_tree=tree)
    group.hide = False
    group.width = 220
    out = b.node("ShaderNodeOutputMaterial")
    out.hide = False
    group.location, out.location = (0, 0), (300, 0)
    b.plug(group.outputs["Volume"], out.inputs["Volume"])
    set_medium(material, medium)
    return material


def set_medium(material, medium):
    group = material.node_tree.nodes["Medium"]
    group.inputs["Absorption"].default_value = (*medium.absorption, 1.0)
    group.inputs["Scattering"].default_value = (*medium.scattering, 1.0)
    group.inputs["Anisotropy"].default_value = medium.anisotropy


def set_numbers(tree, under_water, strength):
    for name, number in ((UNDER_WATER, under_water), (STRENGTH, strength)):
        node = tree.nodes.get(name)
        if node is not None:
            node.outputs[0].default_value = number
