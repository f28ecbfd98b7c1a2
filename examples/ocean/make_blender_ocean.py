# SPDX-License-Identifier: Apache-2.0
"""Bakes Blender's Ocean modifier to blender_ocean.exr, as an artist would: its own Bake button, its own half floats.

    blender --background --factory-startup --python examples/ocean/make_blender_ocean.py

The map is periodic over 12 m. G is the height, R and B are the horizontal displacement along x and y [m].
Made with Blender 3.4.1; other versions may draw other waves from the same seed.
"""
import pathlib
import shutil
import sys
import tempfile
import time

import bpy

HERE = pathlib.Path(__file__).resolve().parent

SETTINGS = {
    "geometry_mode": "GENERATE",
    "spectrum": "PHILLIPS",
    "spatial_size": 12,         # [m]; the modifier takes whole metres
    "resolution": 13,           # squared: 169 x 169 texels
    "viewport_resolution": 13,
    "wind_velocity": 4.0,       # [m/s]
    "wave_alignment": 0.3,
    "wave_scale": 0.3,
    "wave_scale_min": 0.08,     # [m]; shorter waves would be under-sampled
    "choppiness": 0.6,
    "random_seed": 7,
    "time": 3.0,
}


def wait_for(path, seconds=60):
    """The bake is a job in a thread of its own: waits until `path` has stopped growing."""
    end = time.monotonic() + seconds
    size = -1
    while time.monotonic() < end:
        time.sleep(0.5)
        now = path.stat().st_size if path.exists() else -1
        if 0 < now == size:
            return
        size = now
    raise TimeoutError(f"Blender wrote no {path.name} within {seconds} s")


def main():
    bpy.ops.mesh.primitive_plane_add(size=1)
    plane = bpy.context.object
    ocean = plane.modifiers.new("Ocean", "OCEAN")
    for name, value in SETTINGS.items():
        setattr(ocean, name, value)
    ocean.frame_start = ocean.frame_end = 1
    with tempfile.TemporaryDirectory() as folder:
        ocean.filepath = folder
        bpy.ops.object.ocean_bake(modifier=ocean.name)
        baked = pathlib.Path(folder) / "disp_0001.exr"
        wait_for(baked)
        shutil.copyfile(baked, HERE / "blender_ocean.exr")
    print("wrote", HERE / "blender_ocean.exr")


try:
    main()
except Exception as error:  # Blender would otherwise exit with 0
    print(f"make_blender_ocean: {error!r}", file=sys.stderr)
    sys.exit(1)
