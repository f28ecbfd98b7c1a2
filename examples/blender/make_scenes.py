# SPDX-License-Identifier: Apache-2.0
"""Makes the add-on's example files: pool, ocean (Blender's Ocean modifier) ring (a mirror), glass
(balls of glass and of gold) and graded (glass whose index varies).

    blender -b --factory-startup --python-exit-code 1 -P examples/blender/make_scenes.py -- FOLDER [pool|ocean|ring|glass|graded]... [--bake] [--small] [--again]

Writes FOLDER/NAME.blend; with --bake also bakes it, saves it with its preview, and renders FOLDER/NAME.png
by Cycles and FOLDER/NAME_eevee.png. With --small bake and pictures are half as fine, of a quarter of the samples.
With --again the sun is then turned by 45 degrees and coloured, all is baked once more, and rendered as NAME_again.png and
NAME_again_eevee.png.
The add-on must be installed; $PHOTIC_PROGRAM or the search path must lead to the baker.
"""
import math
import pathlib
import sys

import bpy
from mathutils import Matrix

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import scenes  # noqa: E402

SAMPLES = 16     # enough: only the sky and what bounces is sampled


def world(colour, strength):
    made = scenes.with_nodes(bpy.data.worlds.new("Sky"))
    background = made.node_tree.nodes["Background"]
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (*colour, 1.0), strength
    bpy.context.scene.world = made


def tiles(name, first, second, size):
    """Tiles with joints."""
    made = scenes.material(name, Roughness=0.9)
    tree = made.node_tree
    brick = tree.nodes.new("ShaderNodeTexBrick")
    brick.offset, brick.location = 0.0, (-250, 250)
    for key, value in {"Color1": (*first, 1), "Color2": (*second, 1), "Mortar": (0.25, 0.3, 0.32, 1), "Scale": 1.0,
                       "Mortar Size": 0.02 * size, "Brick Width": size, "Row Height": size}.items():
        brick.inputs[key].default_value = value
    place = tree.nodes.new("ShaderNodeTexCoord")
    place.location = (-450, 250)
    tree.links.new(place.outputs["Object"], brick.inputs["Vector"])
    tree.links.new(brick.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    return made


def wall(name, points, made_of):
    return scenes.mesh_object(name, points, [(0, 1, 2, 3)], made_of=made_of)


def pool():
    """A pool of 2 m with a ball that may be moved: its light follows."""
    scene, water, floor = scenes.pool(waves=160, water_size=2.0)
    world((0.35, 0.55, 0.8), 0.25)
    blue = tiles("Tiles", (0.72, 0.86, 0.88), (0.66, 0.82, 0.86), 0.125)
    floor.data.materials[0] = blue
    wall("Wall north", [(-1, 1, -1.5), (1, 1, -1.5), (1, 1, 0.15), (-1, 1, 0.15)], scenes.material("North", Base_Color=(0.7, 0.84, 0.87, 1)))
    wall("Wall east", [(1, 1, -1.5), (1, -1, -1.5), (1, -1, 0.15), (1, 1, 0.15)], scenes.material("East", Base_Color=(0.7, 0.84, 0.87, 1)))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.22, location=(-0.3, 0.1, -0.85))
    ball = bpy.context.object
    ball.name = "Ball"
    bpy.ops.object.shade_smooth()
    ball.data.materials.append(scenes.material("Ball", Base_Color=(0.85, 0.25, 0.12, 1), Roughness=0.7))
    ball.photic.role = "MOVABLE"
    settings = scene.photic
    settings.resolution = 128
    settings.medium_from, settings.scattering, settings.absorption = "SCENE", (0.03, 0.035, 0.04), (0.12, 0.03, 0.02)
    scenes.camera((-1.9, -2.6, 1.5), (0.1, 0.15, -0.75), 32.0)


def ocean():
    """Blender's own ocean over sand, seen from below the surface: light in the water."""
    scene = scenes.empty()
    world((0.3, 0.55, 0.75), 0.12)
    scenes.mesh_object("Sea", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)], smooth=True, made_of=scenes.glass("Sea"))
    sea = bpy.data.objects["Sea"]
    modifier = sea.modifiers.new("Ocean", "OCEAN")
    for name, value in {"geometry_mode": "GENERATE", "spatial_size": 12, "resolution": 12, "viewport_resolution": 12,
                        "wind_velocity": 4.0, "wave_scale": 0.35, "wave_scale_min": 0.08, "choppiness": 0.5, "random_seed": 7}.items():
        setattr(modifier, name, value)
    for polygon in sea.data.polygons:
        polygon.use_smooth = True
    sand = scenes.material("Sand", Base_Color=(0.76, 0.66, 0.48, 1), Roughness=1.0)
    scenes.sheet("Sand", 12.0, 48, lambda x, y: -3.2 + 0.12 * math.sin(1.3 * x + 0.6 * math.sin(y)) + 0.05 * math.sin(3.1 * y), sand)
    scenes.sun(energy=4.0)
    settings = scene.photic
    settings.domain_from, settings.resolution = "CUSTOM", 160
    settings.domain_min, settings.domain_max = (-4.0, -4.0, -3.6), (4.0, 4.0, 0.5)
    settings.medium_from, settings.anisotropy = "SCENE", 0.5
    settings.scattering, settings.absorption = (0.05, 0.06, 0.065), (0.2, 0.05, 0.03)
    settings.match_cycles = False       # the camera is under water
    scenes.camera((-3.4, -3.4, -1.7), (0.5, 0.5, -2.3), 24.0)


def ring():
    """A polished ring on a table: the heart-shaped line that a mirror makes, which shadow caustics can't."""
    scene = scenes.empty()
    world((0.5, 0.55, 0.6), 0.15)
    count, radius, height = 256, 0.5, 0.22
    angles = [2 * math.pi * i / count for i in range(count)]
    vertices = [(radius * math.cos(a), radius * math.sin(a), z) for z in (0.001, height) for a in angles]
    faces = [((i + 1) % count, i, count + i, count + (i + 1) % count) for i in range(count)]
    scenes.mesh_object("Ring", vertices, faces, smooth=True,
                       made_of=scenes.material("Brass", Base_Color=(0.97, 0.96, 0.95, 1), Metallic=1.0, Roughness=0.02))
    scenes.sheet("Table", 2.4, 1, lambda x, y: 0.0, scenes.material("Wood", Base_Color=(0.62, 0.45, 0.3, 1), Roughness=0.9), smooth=False)
    scenes.sun(energy=3.0, direction=(0.8, 0.25, -0.62))
    settings = scene.photic
    settings.domain_from, settings.resolution, settings.where = "CUSTOM", 512, "RECEIVERS"
    settings.domain_min, settings.domain_max = (-0.7, -0.7, -0.02), (0.7, 0.7, 0.25)
    scenes.camera((-0.9, -1.5, 1.25), (0.0, 0.0, 0.05), 42.0)


def glass():
    """A clear ball, a red one and a golden one on a table in the low sun: glass, coloured glass and a mirror in one bake."""
    scene = scenes.empty()
    world((0.5, 0.6, 0.75), 0.35)
    red = scenes.glass("Red glass", 1.5)
    absorption = red.node_tree.nodes.new("ShaderNodeVolumeAbsorption")
    absorption.inputs["Color"].default_value, absorption.inputs["Density"].default_value = (1.0, 0.25, 0.12, 1.0), 12.0
    out = next(n for n in red.node_tree.nodes if n.bl_idname == "ShaderNodeOutputMaterial")
    red.node_tree.links.new(absorption.outputs[0], out.inputs["Volume"])
    gold = scenes.material("Gold", Base_Color=(1.0, 0.78, 0.34, 1), Metallic=1.0, Roughness=0.0)
    for name, x, y, radius, made_of in (("Clear", -0.17, -0.05, 0.12, scenes.glass("Glass", 1.5)), ("Red", 0.1, -0.14, 0.09, red),
                                        ("Golden", 0.14, 0.16, 0.08, gold)):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=radius, location=(x, y, radius + 0.002))
        ball = bpy.context.object
        ball.name = name
        bpy.ops.object.shade_smooth()
        ball.data.materials.append(made_of)
    scenes.sheet("Table", 1.6, 1, lambda x, y: 0.0, scenes.material("Linen", Base_Color=(0.78, 0.74, 0.68, 1), Roughness=0.95), smooth=False)
    scenes.sun(energy=3.0, direction=(0.75, 0.35, -0.62))
    settings = scene.photic
    settings.domain_from, settings.resolution, settings.where = "CUSTOM", 384, "RECEIVERS"
    settings.domain_min, settings.domain_max = (-0.45, -0.4, -0.01), (0.75, 0.6, 0.3)
    scenes.camera((-0.35, -1.05, 0.62), (0.08, 0.04, 0.04), 42.0)


def graded():
    """A Luneburg lens, a die of soft glass and a rod lens that points at the sun: glass whose index varies."""
    scene = scenes.empty()
    world((0.5, 0.6, 0.75), 0.35)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=0.13, location=(-0.26, 0.0, 0.132))
    lens = bpy.context.object
    lens.name, lens.photic.graded.through = "Luneburg lens", "LENS"
    bpy.ops.mesh.primitive_cube_add(size=0.15, location=(0.06, -0.06, 0.077), rotation=(0.0, 0.0, 0.15))
    die = bpy.context.object
    die.name = "Soft die"
    die.modifiers.new("Bevel", "BEVEL").width = 0.025
    die.modifiers["Bevel"].segments = 6
    die.photic.graded.through, die.photic.graded.smooth = "SMOOTHED", 0.003
    bpy.ops.mesh.primitive_cylinder_add(vertices=128, radius=0.055, depth=0.22, location=(0.3, 0.1, 0.139), rotation=(0.0, -0.776, 0.442))
    rod = bpy.context.object
    rod.name = "Rod lens"
    rod.photic.graded.through, rod.photic.graded.faces, rod.photic.graded.focus = "ROD", True, 0.35
    amber = scenes.glass("Amber", 1.3)
    absorption = amber.node_tree.nodes.new("ShaderNodeVolumeAbsorption")
    absorption.inputs["Color"].default_value, absorption.inputs["Density"].default_value = (1.0, 0.55, 0.15, 1.0), 6.0
    out = next(n for n in amber.node_tree.nodes if n.bl_idname == "ShaderNodeOutputMaterial")
    amber.node_tree.links.new(absorption.outputs[0], out.inputs["Volume"])
    for obj, made_of in ((lens, scenes.glass("Clear", 1.2)), (die, amber), (rod, scenes.glass("Rod glass", 1.6))):
        obj.data.polygons.foreach_set("use_smooth", [True] * len(obj.data.polygons))
        if hasattr(obj.data, "use_auto_smooth"):
            obj.data.use_auto_smooth = True
        elif obj == rod:
            obj.data.set_sharp_from_angle(angle=math.radians(30))
        obj.data.materials.append(made_of)
    scenes.sheet("Table", 1.8, 1, lambda x, y: 0.0, scenes.material("Linen", Base_Color=(0.78, 0.74, 0.68, 1), Roughness=0.95), smooth=False)
    scenes.sun(energy=3.0, angle_deg=0.0, direction=(0.55, 0.26, -0.62))
    settings = scene.photic
    settings.domain_from, settings.resolution = "CUSTOM", 320
    settings.domain_min, settings.domain_max = (-0.45, -0.2, -0.01), (0.62, 0.4, 0.28)
    scenes.camera((-0.2, -1.15, 0.72), (0.08, 0.06, 0.07), 46.0)


def render(path, engine="CYCLES", small=False):
    scene = bpy.context.scene
    samples = SAMPLES // 4 if small else SAMPLES
    scene.render.resolution_percentage = 50 if small else 100
    scene.render.engine = engine
    scene.eevee.taa_render_samples = samples
    scene.eevee.volumetric_samples, scene.eevee.volumetric_tile_size = 128, "4"
    scene.eevee.volumetric_end = 30.0
    scene.cycles.samples, scene.cycles.use_denoising = samples, False
    scene.cycles.max_bounces, scene.cycles.diffuse_bounces = 6, 1
    scene.render.resolution_x, scene.render.resolution_y = 720, 450
    scene.view_settings.view_transform, scene.view_settings.look = "Filmic", "Medium High Contrast"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def render_both(path, small):
    render(f"{path}.png", small=small)
    render(f"{path}_eevee.png", scenes.compat().eevee_engine(), small)


def turn_sun():
    sun = bpy.data.objects["Sun"]
    sun.matrix_world = Matrix.Rotation(math.pi / 4, 4, "Z") @ sun.matrix_world
    sun.data.color = (1.0, 0.75, 0.45)


def main(folder, *words):
    folder = pathlib.Path(folder).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    makers = {"pool": pool, "ocean": ocean, "ring": ring, "glass": glass, "graded": graded}
    for name in [word for word in words if word in makers] or list(makers):
        makers[name]()
        bpy.context.scene.name = name
        blend = str(folder / f"{name}.blend")
        bpy.ops.wm.save_as_mainfile(filepath=blend)
        if "--bake" in words:
            small = "--small" in words
            if small:
                bpy.context.scene.photic.resolution //= 2
            bpy.ops.photic.bake()
            bpy.ops.wm.save_as_mainfile(filepath=blend)
            render_both(folder / name, small)
            if "--again" in words:
                turn_sun()
                bpy.ops.photic.bake()
                render_both(folder / f"{name}_again", small)


if __name__ == "__main__":
    main(*sys.argv[sys.argv.index("--") + 1:])
