# SPDX-License-Identifier: Apache-2.0
"""What tests of bodies whose index varies stand on: a ball over a floor, below the sun."""
import tomllib

import bpy
import scenes
from support import OUT

scenes.enable()
from photic.core import graded  # noqa: E402
from photic.export import collect, write  # noqa: E402
from photic.properties import method_options  # noqa: E402

RADIUS, CENTRE, INDEX = 0.3, (0.0, 0.0, 0.5), 1.2
LOW, HIGH, VOXEL = (-0.6, -0.6, -0.1), (0.6, 0.6, 0.9), 1 / 48


def ball(name="Ball", radius=RADIUS, centre=CENTRE, ior=INDEX, through=graded.SMOOTHED):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=radius, location=centre)
    obj = bpy.context.object
    obj.name = name
    obj.data.polygons.foreach_set("use_smooth", [True] * len(obj.data.polygons))
    obj.data.materials.append(scenes.glass(name, ior))
    obj.photic.graded.through = through
    return obj


def floor(size=2.0):
    white = scenes.material("Floor", Base_Color=(0.8, 0.8, 0.8, 1.0), Roughness=1.0, Specular=0.0)
    return scenes.sheet("Floor", size, 1, lambda x, y: 0.0, white, smooth=False)


def absorb(material, per_metre):
    """Gives a material a Volume Absorption of one density and colour."""
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeVolumeAbsorption")
    density = max(per_metre)
    node.inputs["Density"].default_value = density
    node.inputs["Color"].default_value = (*(1 - a / density for a in per_metre), 1.0)
    out = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], out.inputs["Volume"])


def scene_now():
    bpy.context.view_layer.update()
    return collect.collect(bpy.context.evaluated_depsgraph_get())


def text_now():
    return write.scene_text(bpy.context.scene.photic, scene_now(), OUT, method_options.methods())


def tables():
    return tomllib.loads(str(text_now()))


def quick(scene, folder):
    """A box around ball and floor, the sun straight above."""
    settings = scene.photic
    settings.size_by, settings.voxel_size = "VOXEL", VOXEL
    settings.domain_from = "CUSTOM"
    settings.domain_min, settings.domain_max = LOW, HIGH
    settings.folder = str(OUT / folder)
    return settings


def stage(folder="bakes"):
    scene = scenes.empty()
    floor()
    scenes.sun(energy=3.0, angle_deg=0.0, direction=(0, 0, -1))
    return quick(scene, folder)
