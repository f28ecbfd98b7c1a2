# SPDX-License-Identifier: Apache-2.0
"""What goes wrong, said in words: no baker, failed bakes, cancel, moved files, empty scenes, huge domains, odd names."""
import os
import pathlib
import shutil
import unittest

import bpy
import scenes
from support import BAKER, OUT, contents, render

scenes.enable()
from photic.operators import job, scene_check  # noqa: E402


def quick(scene, folder=OUT):
    settings = scene.photic
    settings.folder, settings.resolution = str(folder), 24
    settings.options_beams.disc = "off"
    return settings


def complaints():
    return " | ".join(words for _, words in scene_check.complaints(bpy.context))


class BadStates(unittest.TestCase):
    def setUp(self):
        self.scene, self.water, self.floor = scenes.pool(waves=16, floor_depth=1.0)
        self.settings = quick(self.scene)

    def tearDown(self):
        os.environ["PHOTIC_PROGRAM"] = BAKER
        self.assertIsNone(job.current)

    def fails(self, words):
        before = contents()
        with self.assertRaisesRegex(RuntimeError, words):
            bpy.ops.photic.bake()
        self.assertEqual(contents(), before)
        self.assertRegex(self.scene.photic.message, words)

    def test_baker_missing(self):
        os.environ["PHOTIC_PROGRAM"] = ""
        path, os.environ["PATH"] = os.environ["PATH"], str(OUT)
        try:
            self.fails("was not found")
        finally:
            os.environ["PATH"] = path

    def test_baker_crashes(self):
        bad = OUT / "crash"
        bad.write_text("#!/bin/sh\necho 'segmentation of faults' >&2\nexit 11\n")
        bad.chmod(0o755)
        os.environ["PHOTIC_PROGRAM"] = str(bad)
        self.fails("segmentation of faults")

    def test_baker_refuses_and_the_object_is_selected(self):
        ball = scenes.sheet("Glass ball Ü", 0.3, 1, lambda x, y: -0.5, scenes.glass("Other"))
        bpy.ops.mesh.primitive_cube_add(size=0.3, location=(0, 0, 0.5))
        ball.data = bpy.context.object.data
        ball.data.materials.append(scenes.glass("Other"))
        bpy.data.objects.remove(bpy.context.object)
        bpy.context.view_layer.update()
        try:
            bpy.ops.photic.bake()
        except RuntimeError as error:
            self.assertIn("Glass ball Ü", str(error))
            self.assertIn("closed", str(error))
            self.assertNotRegex(str(error), r"\.ply|event =")     # nor any other word of the scene file
            self.assertEqual(bpy.context.view_layer.objects.active, ball)
            self.assertTrue(ball.select_get())
            self.assertIn("closed", complaints())
        else:   # a baker that has learnt closed glass: then Validate has nothing to say about it
            self.assertNotIn("closed", complaints())

    def test_cancel(self):
        running = job.Job(bpy.context)
        running.tick()
        while running.run is None:
            running.tick()
        running.cancel()
        while not running.tick():
            pass
        running.end()
        self.assertTrue(running.cancelled)
        self.assertEqual(self.settings.volume_file, "")
        self.assertFalse(list(OUT.glob("*.part")) + list(OUT.glob(".*tmp*")))

    def test_moved_file(self):
        folder = OUT / "moved"
        quick(self.scene, folder)
        bpy.ops.photic.bake()
        shutil.move(folder, OUT / "elsewhere")
        with self.assertRaisesRegex(RuntimeError, "is gone"):
            bpy.ops.photic.load()
        with self.assertRaisesRegex(RuntimeError, "bake again"):
            bpy.ops.photic.preview(show=True)
        volume, atlas = (OUT / "elsewhere" / pathlib.Path(name).name for name in (self.settings.volume_file, self.settings.atlas_file))
        self.settings.volume_file, self.settings.atlas_file = str(volume), str(atlas)
        self.assertEqual(bpy.ops.photic.load(), {"FINISHED"})
        # The same file is still in Blender's memory: a broken one is met under another name.
        broken = volume.with_name("Broken.vdb")
        broken.write_bytes(b"no volume")
        self.settings.volume_file = str(broken)
        with self.assertRaisesRegex(RuntimeError, "cannot read"):
            bpy.ops.photic.load()

    def test_nothing_baked(self):
        for operator in (bpy.ops.photic.load, bpy.ops.photic.preview):
            with self.assertRaisesRegex(RuntimeError, "press Bake"):
                operator()

    def test_empty_scene(self):
        self.scene = scenes.empty()
        quick(self.scene)
        self.fails("no light in the scene")
        scenes.sun()
        self.fails("Nothing in the scene bends light")
        self.assertIn("Nothing receives", complaints())
        self.assertEqual(bpy.ops.photic.validate(), {"FINISHED"})

    def test_huge_domain(self):
        self.settings.domain_from = "CUSTOM"
        self.settings.domain_min, self.settings.domain_max = (-5e4,) * 3, (5e4,) * 3
        self.settings.size_by, self.settings.voxel_size = "VOXEL", 0.01
        self.fails("voxel")
        self.settings.domain_max = (-6e4,) * 3
        self.fails("empty")

    def test_validate_words(self):
        self.water.data.polygons.foreach_set("use_smooth", [False] * len(self.water.data.polygons))
        self.water.scale = (2, 2, 1)
        self.water.modifiers.new("Wave", "WAVE")
        bpy.context.view_layer.update()
        said = complaints()
        self.assertIn("Shade Smooth", said)
        self.assertIn("apply it", said)
        self.assertEqual(bpy.ops.photic.estimate(), {"FINISHED"})
        self.assertIn("voxels", self.settings.estimate)

    def test_sound_scene_has_no_complaint(self):
        self.assertEqual(complaints(), "")

    def test_odd_names_and_folders(self):
        self.water.name, self.floor.name = '水 "quoted"\\ ', "Fußboden mit Leerzeichen"
        self.floor.data.materials[0].name = "Weiß / 白"
        self.scene.name = "Szene: Ö/ö"
        folder = OUT / "ein Ordner mit Ümlaut"
        quick(self.scene, folder)
        self.assertEqual(bpy.ops.photic.bake(), {"FINISHED"})
        self.assertTrue(list(folder.glob("*.vdb")))

    def test_unsaved_file_goes_to_the_temporary_folder(self):
        self.settings.folder = "//light"
        self.assertEqual(bpy.ops.photic.bake(), {"FINISHED"})
        self.assertTrue(self.settings.volume_file.startswith(bpy.app.tempdir))

    def test_unwritable_folder(self):
        (OUT / "file").write_text("")
        self.settings.folder = str(OUT / "file" / "folder")
        self.fails("choose another")

    def test_linked_and_overridden_objects(self):
        library = str(OUT / "library.blend")
        bpy.data.objects.remove(self.water)
        bpy.ops.wm.save_as_mainfile(filepath=library, copy=True)
        self.scene, self.water, self.floor = scenes.pool(waves=16, floor_depth=1.0)
        self.settings = quick(self.scene)
        bpy.data.objects.remove(self.floor)
        with bpy.data.libraries.load(library, link=True) as (have, want):
            want.objects = ["Floor"]
        linked = want.objects[0]
        override = linked.override_create(remap_local_usages=True)
        self.scene.collection.objects.link(override)
        bpy.context.view_layer.update()
        try:
            bpy.ops.photic.bake()
        except RuntimeError as error:
            self.assertIn("linked", str(error))     # said in words, not a traceback
        self.assertTrue(self.settings.previewing)
        scenes.camera((0, 0, -0.5), (0, 0, -1), orthographic=1)
        self.water.hide_render = bpy.data.objects["Sun"].hide_render = True
        lit = render("CYCLES", 8)[..., :3].min()
        print("overridden receiver", "is lit" if lit > 0.1 else "is left out, and said so")
        bpy.ops.photic.remove()
        self.assertFalse([m.name for m in bpy.data.materials if "Photic" in m.name])
