# SPDX-License-Identifier: Apache-2.0
"""Frame ranges: the volume and the receivers follow the frame, and what did not change is not baked again."""
import pathlib
import unittest

import bpy
import numpy
import scenes
from support import ENGINES, OUT, render


class Frames(unittest.TestCase):
    def test_sequence(self):
        scene, water, floor = scenes.pool(waves=24, floor_depth=1.0)
        settings = scene.photic
        settings.folder, settings.resolution, settings.match_cycles = str(OUT), 40, False
        settings.options_beams.disc = "off"
        water.location.x = -0.3
        water.keyframe_insert("location", frame=3)
        water.location.x = 0.3
        water.keyframe_insert("location", frame=5)
        scene.frame_start, scene.frame_end = 3, 5
        scene.frame_set(4)
        self.assertEqual(bpy.ops.photic.bake(animation=True), {"FINISHED"})
        self.assertEqual(scene.frame_current, 4)
        for frame in (3, 4, 5):
            for extension in ("vdb", "exr", "exr.json"):
                self.assertTrue((OUT / f"Scene_bake1.{frame:04d}.{extension}").exists())
        data = settings.volume.data
        self.assertTrue(data.is_sequence)

        # Each frame of the sequence shows what a bake of that frame alone shows, before, in and after the range.
        shown = {}
        scenes.camera((0, 0, -0.5), (0, 0, -1), orthographic=1)
        water.hide_render = bpy.data.objects["Sun"].hide_render = True
        for frame in (3, 4, 5):
            scene.frame_set(frame)
            shown[frame] = render("CYCLES", 32)[..., :3].copy()
            self.assertEqual(data.grids.frame, frame)
        scene.frame_set(5)
        # EEVEE's own: the same pictures.
        self.assertLess(numpy.abs(render(ENGINES[1], 32)[..., :3] / shown[5] - 1).max(), 1e-3)
        for a, b in ((3, 4), (4, 5), (3, 5)):
            self.assertGreater(numpy.abs(shown[a] - shown[b]).max(), 0.05 * shown[a].mean())
        water.hide_render = bpy.data.objects["Sun"].hide_render = False

        # Nothing has changed: no frame is baked, no atlas written.
        before = {path.name: path.stat().st_mtime_ns for path in OUT.glob("Scene_bake*") if path.suffix in (".vdb", ".exr")}
        bpy.ops.photic.bake(animation=True)
        after = {path.name: path.stat().st_mtime_ns for path in OUT.glob("Scene_bake*") if path.suffix in (".vdb", ".exr")}
        self.assertEqual(before, after)
        # One frame has: only that one is.
        water.location.x = 0.5
        water.keyframe_insert("location", frame=5)
        bpy.ops.photic.bake(animation=True)
        name = settings.volume_file.replace(".0003.vdb", "")
        self.assertNotEqual(pathlib.Path(name).name, "Scene_bake1")
        last = {frame: pathlib.Path(f"{name}.{frame:04d}.vdb").stat().st_mtime_ns for frame in (3, 4, 5)}
        self.assertEqual(last[3], before["Scene_bake1.0003.vdb"])
        self.assertNotEqual(last[5], before["Scene_bake1.0005.vdb"])

        scene.frame_set(4)
        settings.folder = str(OUT / "single")
        bpy.ops.photic.bake()
        self.assertFalse(settings.volume.data.is_sequence)

    def test_changing_sun_is_refused(self):
        scene, *_ = scenes.pool(waves=8, floor_depth=1.0)
        settings = scene.photic
        settings.folder, settings.resolution = str(OUT / "sun"), 16
        settings.options_beams.disc = "off"
        sun = bpy.data.lights["Sun"]
        for frame, energy in ((1, 3.0), (2, 4.0)):
            sun.energy = energy
            sun.keyframe_insert("energy", frame=frame)
        scene.frame_start, scene.frame_end = 1, 2
        with self.assertRaisesRegex(RuntimeError, "strength changes"):
            bpy.ops.photic.bake(animation=True)
