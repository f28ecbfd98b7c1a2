# SPDX-License-Identifier: Apache-2.0
"""What the tests share: a folder, pictures as arrays, renders without anything but what is measured, and the baker."""
import os
import pathlib
import subprocess

import bpy
import numpy

OUT = pathlib.Path(os.environ["PHOTIC_TEST_OUT"])
BAKER = os.environ["PHOTIC_PROGRAM"]
ENGINES = ("CYCLES", "BLENDER_EEVEE_NEXT" if bpy.app.version[:2] >= (4, 2) and bpy.app.version < (5, 0) else "BLENDER_EEVEE")


def baker(*arguments):
    """Runs the command line; a failure is the test's."""
    done = subprocess.run([BAKER, *map(str, arguments)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def picture(path):
    """Pixels of an EXR, height x width x RGBA, the lowest row first."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    pixels = numpy.empty(image.size[0] * image.size[1] * 4, dtype=numpy.float32)
    image.pixels.foreach_get(pixels)
    shape = (image.size[1], image.size[0], 4)
    bpy.data.images.remove(image)
    return pixels.reshape(shape)


def render(engine, size, samples=1, bounces=0):
    """Radiance seen by the scene's camera: pixel centres, no film, no filter."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.render.resolution_x, scene.render.resolution_y = size if isinstance(size, tuple) else (size, size)
    scene.render.resolution_percentage = 100
    scene.render.filter_size = 0.0
    scene.render.film_transparent = True
    scene.cycles.samples, scene.cycles.max_bounces = samples, bounces
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.filter_width = 0.01
    scene.eevee.taa_render_samples = samples
    scene.view_settings.view_transform = "Raw"
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGBA"
    scene.render.filepath = str(OUT / f"{engine}.exr")
    bpy.ops.render.render(write_still=True)
    return picture(scene.render.filepath)


def rmse(found, wanted):
    """Root mean square of the difference over the mean of what is wanted."""
    return float(numpy.sqrt(((found - wanted) ** 2).mean()) / wanted.mean())


def contents():
    """Names of all that a file holds, to find what was left behind."""
    kinds = ("objects", "meshes", "materials", "lights", "volumes", "images", "node_groups", "worlds", "cameras", "actions",
             "collections", "texts")
    return {kind: sorted(item.name for item in getattr(bpy.data, kind)) for kind in kinds}
