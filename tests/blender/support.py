# SPDX-License-Identifier: Apache-2.0
"""What the tests share: a folder, pictures as arrays, renders without anything but what is measured, and the baker."""
import os
import pathlib
import subprocess

import bpy
import numpy
import scenes

HERE = pathlib.Path(__file__).resolve().parent
OUT = pathlib.Path(os.environ["PHOTIC_TEST_OUT"])
BAKER = os.environ["PHOTIC_PROGRAM"]
ENGINES = ("CYCLES", scenes.compat().eevee_engine())


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


_shown = {}


def volumes_are_shown(engine):
    """Whether an engine shows a volume grid in this build of Blender at all: stock_volume.py, in a Blender of its own, for there
    are some that crash there (Cycles of Ubuntu's 4.0.2)."""
    if engine not in _shown:
        path = OUT / "stock.vdb"
        scene_file = OUT / "stock.toml"
        scene_file.write_text('photic = 1\n[domain]\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\nresolution = 16\n[[light]]\n'
                              'type = "sun"\ndirection = [0, 0, -1]\nirradiance = 1\n[[surface]]\nname = "w"\n'
                              'kind = "height_field"\nwaves = [{ amplitude = 1e-6, wavelength = 1 }]\nsize = [4, 4]\ncenter = [0, 0, 0.9]\n[medium]\nscattering = 1\n'
                              '[bake]\ngrids = ["irradiance", "density"]\n')
        baker("bake", scene_file, "-o", path, "--progress=none")
        tried = subprocess.run([bpy.app.binary_path, "-b", "--factory-startup", "--python-exit-code", "1", "-P",
                                str(HERE / "stock_volume.py"), "--", engine, str(path)], capture_output=True, text=True, check=False)
        _shown[engine] = "shown: True" in tried.stdout
        if not _shown[engine] and "shown: False" not in tried.stdout:
            print(f"{engine} ends with {tried.returncode} where it is to show a stock volume\n{tried.stdout[-500:]}")
    return _shown[engine]


def rmse(found, wanted):
    """Root mean square of the difference over the mean of what is wanted."""
    return float(numpy.sqrt(((found - wanted) ** 2).mean()) / wanted.mean())


def contents():
    """Names of all that a file holds, to find what was left behind."""
    kinds = ("objects", "meshes", "materials", "lights", "volumes", "images", "node_groups", "worlds", "cameras", "actions",
             "collections", "texts")
    return {kind: sorted(item.name for item in getattr(bpy.data, kind)) for kind in kinds}
