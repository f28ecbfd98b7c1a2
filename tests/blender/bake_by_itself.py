# SPDX-License-Identifier: Apache-2.0
"""Bakes and renders a pool with an add-on that was installed and switched on before, by the baker that it brought along."""
import importlib
import os
import pathlib
import sys

import bpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples" / "blender"))
import scenes  # noqa: E402

out = pathlib.Path(os.environ["PHOTIC_TEST_OUT"])
enabled = [name for name in bpy.context.preferences.addons.keys() if name.split(".")[-1] == "photic"]
assert len(enabled) == 1, f"the add-on is not switched on: {list(bpy.context.preferences.addons.keys())}"
program = importlib.import_module(f"{enabled[0]}.core.program")
addon = pathlib.Path(sys.modules[enabled[0]].__file__).resolve().parent

scene, water, floor = scenes.pool(waves=24, floor_depth=1.0)
baker = pathlib.Path(program.find()).resolve()
assert addon in baker.parents, f"{baker} is not the add-on's own"
settings = scene.photic
settings.folder, settings.resolution = str(out), 32
assert bpy.ops.photic.bake() == {"FINISHED"}
assert settings.previewing and pathlib.Path(settings.volume_file).stat().st_size > 0

# The floor, lit by nothing but what was baked.
water.hide_render = bpy.data.objects["Sun"].hide_render = True
scenes.camera((0, 0, -0.5), (0, 0, -1), orthographic=1)
scene.render.engine = "CYCLES"
scene.render.resolution_x = scene.render.resolution_y = 32
scene.cycles.samples, scene.cycles.use_denoising = 4, False
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.filepath = str(out / "floor.exr")
bpy.ops.render.render(write_still=True)
picture = bpy.data.images.load(scene.render.filepath)
light = sum(picture.pixels[:][0::4]) / (32 * 32)
assert light > 0.1, f"the floor is dark: {light}"
print(f"Blender {bpy.app.version_string}: baked by {baker.relative_to(addon)} of the add-on, {baker.stat().st_size} bytes; "
      f"the floor's mean is {light:.3f}")
