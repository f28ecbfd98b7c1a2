# SPDX-License-Identifier: Apache-2.0
"""The pool by Cycles itself and by a baked volume: seconds, noise, and error against a converged picture.

    blender -b --factory-startup --python-exit-code 1 -P examples/blender/compare_cycles.py -- FOLDER RUN...

A RUN is VIEW:NAME:SAMPLES[:SEED], VIEW above or below, NAME baked, photons (the same, by the
reference method), mnee (shadow caustics) or path. `table` compares what is in
FOLDER already. The add-on must be installed, and $PHOTIC_PROGRAM or the search path lead to the baker.
"""
import json
import pathlib
import sys
import time

import bpy
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import scenes  # noqa: E402

SIZE = 256
VIEWS = {"above": ((0.0, -2.6, 2.4), (0.0, 0.0, -0.9), 40.0), "below": ((0.0, -0.95, -0.35), (0.0, 0.15, -1.5), 24.0)}
VOXELS = 256
PHOTONS = 48_000_000
CONVERGED = ("photons", 64)
THREADS = 1


def build(folder, view):
    """The pool with a bake beside it; nothing is shown yet."""
    scene, water, floor = scenes.pool(waves=160)
    scenes.camera(*VIEWS[view])
    settings = scene.photic
    settings.folder, settings.resolution, settings.where = str(folder), VOXELS, "RECEIVERS"
    settings.preview_after_bake = False
    water.photic.surface = "MESH"       # what Cycles renders, facets and all: a height field is smoother than that
    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x = render.resolution_y = SIZE
    render.threads_mode, render.threads = "FIXED", THREADS
    scene.cycles.blur_glossy = 0.0      # for all alike: it would roughen the water
    scene.cycles.sample_clamp_indirect = 0.0
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    return scene, water, floor


def prepare(scene, water, floor, name, bake_log):
    if name in ("baked", "photons"):
        settings = scene.photic
        settings.folder = str(pathlib.Path(settings.folder) / name)
        if name == "photons":
            settings.method, settings.options_photons.count = "photons", PHOTONS
        start = time.monotonic()
        bpy.ops.photic.bake()
        bake_log.write_text(json.dumps({"bake_seconds": time.monotonic() - start, "bytes": pathlib.Path(settings.volume_file).stat().st_size}))
        bpy.ops.photic.preview(show=True)
    elif name == "mnee":
        bpy.data.lights["Sun"].cycles.is_caustics_light = True
        water.cycles.is_caustics_caster = True
        floor.cycles.is_caustics_receiver = True
    elif name == "path":
        bpy.data.lights["Sun"].cycles.use_multiple_importance_sampling = True


def run(folder, view, name, samples, seed=0):
    scene, water, floor = build(folder, view)
    prepare(scene, water, floor, name, folder / f"bake_{name}.json")
    scene.cycles.samples, scene.cycles.seed = samples, seed
    scene.render.filepath = str(folder / f"{view}_{name}_{samples}_{seed}.exr")
    start = time.monotonic()
    bpy.ops.render.render(write_still=True)
    seconds = time.monotonic() - start
    pathlib.Path(scene.render.filepath).with_suffix(".json").write_text(json.dumps({"seconds": seconds}))
    print(f"{view} {name} {samples}: {seconds:.2f} s")


def pixels(path):
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    values = numpy.empty(SIZE * SIZE * 4, dtype=numpy.float32)
    image.pixels.foreach_get(values)
    return values.reshape(SIZE, SIZE, 4)[..., :3].astype(float)


def error(found, wanted):
    """Root mean square over the mean, where the converged picture shows the floor."""
    lit = wanted.mean(axis=2) > 0.02 * wanted.mean()
    return float(numpy.sqrt(((found - wanted)[lit] ** 2).mean()) / wanted[lit].mean())


def table(folder):
    print("| view | run | samples | seconds | noise | error | mean |\n|---|---|---:|---:|---:|---:|---:|")
    for view in VIEWS:
        converged = pixels(folder / f"{view}_{CONVERGED[0]}_{CONVERGED[1]}_0.exr")
        for path in sorted(folder.glob(f"{view}_*_0.exr")):
            _, name, samples, _ = path.stem.split("_")
            found, twin = pixels(path), path.with_name(path.stem[:-1] + "1.exr")
            noise = f"{error(pixels(twin), found) / 2 ** 0.5:.4f}" if twin.exists() else ""
            seconds = json.loads(path.with_suffix(".json").read_text())["seconds"]
            print(f"| {view} | {name} | {samples} | {seconds:.2f} | {noise} | {error(found, converged):.4f} "
                  f"| {found.mean() / converged.mean():.4f} |")


def main(folder, *runs):
    folder = pathlib.Path(folder).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    for text in runs:
        if text == "table":
            table(folder)
            continue
        view, name, samples, *seed = text.split(":")
        run(folder, view, name, int(samples), *map(int, seed))


main(*sys.argv[sys.argv.index("--") + 1:])
