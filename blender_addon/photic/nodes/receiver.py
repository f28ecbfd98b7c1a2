# SPDX-License-Identifier: GPL-3.0-or-later
"""The Receiver group: a surface's own shader, plus albedo / pi times the light that the volume brings to it."""
import math

from . import build, groups

UNDER_WATER, STRENGTH, LEVEL = "Under water", "Strength", "Water level"     # nodes that hold the preview's numbers


def build_group(volume_object, sample_group, level, under_water, strength, kind="Receiver"):
    """(Re)builds the group of a volume that looks light up by `sample_group`; `kind` is what it is called.

    `under_water` multiplies light on receivers below `level` [m, in the volume's frame]: (n_camera / n_water)^2 for a renderer
    that leaves radiance as it is where it refracts.
    """
    tree = groups.fresh(
        groups.named(kind, volume_object),
        [("NodeSocketShader", "Shader", None), ("NodeSocketColor", "Albedo", (0.8, 0.8, 0.8, 1.0)),
         ("NodeSocketVector", "Normal", None)],
        [("NodeSocketShader", "Shader", None), ("NodeSocketColor", "Irradiance", None)])
    b = build.Builder(tree)
    given = b.node("NodeGroupInput")
    light = b.node("ShaderNodeGroup", "Light", node_tree=sample_group)
    place = light.outputs["Position"]

    # A normal that nobody links is (0, 0, 0): the shaded one then.
    shaded = b.node("ShaderNodeNewGeometry").outputs["Normal"]
    is_given = b.math("GREATER_THAN", b.vector("LENGTH", given.outputs["Normal"]), 0.5)
    missing = b.math("SUBTRACT", 1.0, is_given)
    normal = b.vector("NORMALIZE", b.vector("ADD", given.outputs["Normal"], b.vector("SCALE", shaded, scale=missing)))
    turn = b.node("ShaderNodeVectorRotate", "Into the volume's frame", rotation_type="EULER_XYZ", invert=True)
    groups.drive_rotation(tree, turn, volume_object)
    b.plug(normal, turn.inputs["Vector"])

    below = b.math("LESS_THAN", b.split(place)[2], b.value(LEVEL, level))
    scaled = b.math("MULTIPLY_ADD", below, b.math("SUBTRACT", b.value(UNDER_WATER, under_water), 1.0), 1.0)
    factor = b.math("MULTIPLY", scaled, b.value(STRENGTH, strength))
    irradiance = None
    for suffix in ("", " 2"):       # of each lobe: light that opposes the rest has a direction of its own
        if "Flux" + suffix not in light.outputs:
            continue
        along = b.vector("DOT_PRODUCT", light.outputs["Flux" + suffix], turn.outputs[0])
        received = b.math("MULTIPLY", b.math("MAXIMUM", b.math("MULTIPLY", along, -1.0), 0.0), factor)
        lobe = b.vector("SCALE", light.outputs["Colour" + suffix], scale=received)
        irradiance = b.vector("ADD", irradiance, lobe) if irradiance else lobe

    emission = b.node("ShaderNodeEmission")
    b.plug(b.vector("MULTIPLY", irradiance, given.outputs["Albedo"]), emission.inputs["Color"])
    b.plug(1.0 / math.pi, emission.inputs["Strength"])
    both = b.node("ShaderNodeAddShader")
    b.plug(given.outputs["Shader"], both.inputs[0])
    b.plug(emission.outputs[0], both.inputs[1])
    out = b.node("NodeGroupOutput")
    b.plug(both.outputs[0], out.inputs["Shader"])
    b.plug(irradiance, out.inputs["Irradiance"])
    return tree


def set_numbers(tree, level, under_water, strength):
    """Changes the preview's numbers without building anew."""
    for name, number in ((LEVEL, level), (UNDER_WATER, under_water), (STRENGTH, strength)):
        node = tree.nodes.get(name)
        if node is not None:
            node.outputs[0].default_value = number
