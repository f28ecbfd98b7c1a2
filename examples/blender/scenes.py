# SPDX-License-Identifier: Apache-2.0
"""What scenes are made of: water, floors, suns and cameras by script, for the examples and the tests."""
import importlib
import math
import sys

import bpy

IOR = 1.333
WAVES = ((0.020, 1.10, 20.0, 0.4), (0.014, 0.70, 100.0, 1.7), (0.007, 0.45, -35.0, 2.9), (0.004, 0.30, 60.0, 1.0))


def empty():
    """A file with a scene and nothing in it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    enable()
    return bpy.context.scene


def enable():
    """Switches the add-on on, installed as an add-on or as an extension, and returns its module."""
    import addon_utils
    names = [module.__name__ for module in addon_utils.modules() if module.__name__.split(".")[-1] == "photic"]
    return addon_utils.enable(names[0] if names else "photic", default_set=False)


def compat():
    """The add-on's own knowledge of Blender's versions."""
    loaded = [name for name in sys.modules if name == "photic.compat" or name.endswith(".photic.compat")]
    return sys.modules[loaded[0]] if loaded else importlib.import_module(f"{enable().__name__}.compat")


def with_nodes(item):
    """A material or world with a node tree."""
    compat().switch_nodes(item, True)
    return item


def material(name, **inputs):
    made = with_nodes(bpy.data.materials.new(name))
    principled = next(n for n in made.node_tree.nodes if n.bl_idname == "ShaderNodeBsdfPrincipled")
    for key, value in inputs.items():
        compat().socket(principled.inputs, key.replace("_", " ")).default_value = value
    return made


def glass(name="Water", ior=IOR, roughness=0.0):
    made = with_nodes(bpy.data.materials.new(name))
    tree = made.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeBsdfGlass")
    shader.inputs["IOR"].default_value, shader.inputs["Roughness"].default_value = ior, roughness
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], out.inputs["Surface"])
    return made


def mesh_object(name, vertices, faces, smooth=False, made_of=None):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
    obj = bpy.data.objects.new(name, mesh)
    if made_of:
        mesh.materials.append(made_of)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def sheet(name, size, count, height, made_of=None, smooth=True):
    """count x count faces over a square of `size` [m], z = height(x, y)."""
    at = [(-0.5 + i / count) * size for i in range(count + 1)]
    vertices = [(x, y, height(x, y)) for y in at for x in at]
    n = count + 1
    faces = [(j * n + i, j * n + i + 1, (j + 1) * n + i + 1, (j + 1) * n + i) for j in range(count) for i in range(count)]
    return mesh_object(name, vertices, faces, smooth, made_of)


def wave_height(x, y):
    """The example pool's four sines."""
    total = 0.0
    for amplitude, length, degrees, phase in WAVES:
        a, k = math.radians(degrees), 2 * math.pi / length
        total += amplitude * math.sin(k * (x * math.cos(a) + y * math.sin(a)) + phase)
    return total


def sun(energy=3.0, angle_deg=0.53, direction=(0.433, 0.25, -0.866)):
    from mathutils import Vector
    light = bpy.data.lights.new("Sun", "SUN")
    light.energy, light.angle = energy, math.radians(angle_deg)
    obj = bpy.data.objects.new("Sun", light)
    obj.rotation_euler = Vector(direction).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(obj)
    return obj


def camera(location, target, lens=35.0, orthographic=None):
    from mathutils import Vector
    data = bpy.data.cameras.new("Camera")
    data.lens = lens
    if orthographic:
        data.type, data.ortho_scale = "ORTHO", orthographic
    obj = bpy.data.objects.new("Camera", data)
    obj.location = location
    obj.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.scene.camera = obj
    return obj


def pool(waves=96, water_size=4.0, floor_depth=1.5, floor_size=2.0):
    """Water over a white floor, the sun 30 degrees from the zenith."""
    scene = empty()
    water = sheet("Water", water_size, waves, wave_height, glass())
    white = material("Floor", Base_Color=(0.8, 0.8, 0.8, 1.0), Roughness=1.0)
    floor = sheet("Floor", floor_size, 1, lambda x, y: -floor_depth, white, smooth=False)
    sun()
    return scene, water, floor
