# SPDX-License-Identifier: Apache-2.0
"""Glass whose index varies: its light on the floor, against scene files written by hand and against Snell's law."""
import json
import math
import pathlib
import unittest

import bpy
import numpy
import scenes
from graded_stage import CENTRE, HIGH, INDEX, LOW, RADIUS, VOXEL, ball, scene_now, stage, tables
from support import OUT, baker, picture, render, volumes_are_shown

from photic.core import graded
from photic.operators import job, scene_check


HEADER = f"""photic = 1
[domain]
min = {list(LOW)}
max = {list(HIGH)}
voxel_size = {VOXEL}
[[light]]
type = "sun"
direction = [0, 0, -1]
irradiance = 3
angular_diameter = 0
[[object]]
name = "floor"
plane = {{ point = [0, 0, 0] }}
[bake]
method = "wavefront"
"""


def by_hand(name, medium):
    """The same light baked from a scene file that was written by hand; returns the volume."""
    scene_file = OUT / f"{name}.toml"
    scene_file.write_text(HEADER + medium)
    baker("bake", scene_file, "-o", OUT / f"{name}.vdb", "--progress=none")
    return OUT / f"{name}.vdb"


def floor_map(volume):
    """E [W/m2] of 240 x 240 texels over the floor's middle."""
    scene_file = OUT / "floor.toml"
    scene_file.write_text(HEADER + '[[medium]]\nname = "lens"\nindex = { kind = "luneburg", center = [0, 0, 0.5], radius = 0.3 }\n')
    baker("picture", scene_file, volume, "--receiver", "floor", "--resolution", 240, "-o", OUT, "--progress=none")
    return picture(OUT / f"{pathlib.Path(volume).stem}_floor.exr")[..., 0]


def baked():
    assert bpy.ops.photic.bake() == {"FINISHED"}
    return bpy.path.abspath(bpy.context.scene.photic.volume_file)


def samples_in(folder):
    return {path.name: path.stat().st_mtime_ns for path in (OUT / folder / "Scene_scene").glob("*.vdb")}


def off(found, wanted):
    """Mean difference over the mean."""
    return float(numpy.abs(found - wanted).mean() / wanted.mean())


def circles(energy):
    """Power within circles on the floor [W], by their radius."""
    side = 1.2 / energy.shape[0]
    y, x = (numpy.indices(energy.shape) + 0.5) * side - 0.6
    radius = numpy.hypot(x, y)
    return {within: float(energy[radius < within].sum() * side * side) for within in (0.05, 0.1, 0.15, 0.2, 0.3)}


def snell():
    """The same of rays that refract twice at a sharp ball which reflects nothing."""
    height = numpy.linspace(0, 1, 200001)[1:-1] * RADIUS
    incidence = numpy.arcsin(height / RADIUS)
    turned = 2 * (incidence - numpy.arcsin(height / RADIUS / INDEX))
    out = -RADIUS * numpy.sin(turned - incidence), CENTRE[2] - RADIUS * numpy.cos(turned - incidence)
    landing = numpy.abs(out[0] - out[1] * numpy.tan(turned))
    return {within: 3.0 * 2 * math.pi * (height * (landing < within)).sum() * (height[1] - height[0])
            for within in (0.05, 0.1, 0.15, 0.2, 0.3)}


class Baked(unittest.TestCase):
    def test_a_smoothed_ball_gathers_light(self):
        """Against samples that were made by hand of an own ball, and against Snell's law; Cycles shows it on the floor."""
        stage()
        obj = ball()
        obj.photic.graded.voxel_size = obj.photic.graded.smooth = 1 / 96
        found = floor_map(baked())
        (OUT / "hand.csv").write_text("\n".join(f"{RADIUS * math.sin(a)}, {CENTRE[2] - RADIUS * math.cos(a)}"
                                                for a in numpy.linspace(0, math.pi, 181)))
        baker("voxelise", OUT / "hand.csv", "--ior", INDEX, "--voxel-size", 1 / 96, "--smooth", 1, "-o", OUT / "hand_n.vdb",
              "--progress=none")
        wanted = floor_map(by_hand("hand", '[[medium]]\nname = "ball"\nindex = "hand_n.vdb"\n'))
        self.assertLess(off(found, wanted), 0.01)
        # A smoothed face has a rim that bends light too, and spreads the smallest circle.
        law, power = snell(), circles(found)
        self.assertLess(numpy.mean([abs(power[within] / law[within] - 1) for within in law]), 0.08)
        scenes.camera((0, 0, 0.12), (0, 0, 0), orthographic=0.4)
        shown = render("CYCLES", 64, samples=4, bounces=4)[..., 0] * math.pi / 0.8
        y, x = (numpy.indices(shown.shape) + 0.5) / 160 - 0.2
        middle = numpy.hypot(x, y) < 0.15
        self.assertAlmostEqual(shown[middle].sum() / 160 ** 2 / circles(found)[0.15], 1.0, delta=0.03)

    def test_wide_faces_add_little_to_the_light(self):
        """Smoothed over a sixth of its radius: without a rim of its own what counts is 1.86 times the light that meets the ball,
        and Blender's own sun shines on most of it too."""
        settings = stage("wide")
        obj = ball()
        obj.photic.graded.smooth = 0.05
        obj.data.materials[0].node_tree.nodes["Glass BSDF"].inputs["IOR"].default_value = INDEX
        rim = tables()["bake"]["wavefront"]["rim"]
        self.assertEqual((rim, scene_now().notes), (0.5, []))
        whole = 3.0 * math.pi * RADIUS ** 2
        self.assertAlmostEqual(circles(floor_map(baked()))[0.3] / whole, 1.12, delta=0.03)
        settings.options_wavefront.rim = 0.01
        self.assertGreater(circles(floor_map(baked()))[0.3] / whole, 1.4)
        obj.photic.graded.smooth = 0.12      # nothing of its middle is left
        self.assertRegex(" ".join(words for _, words in scene_check.complaints(bpy.context)), "soft faces of 'Ball' reach some 240 mm")

    def test_a_second_bake_after_a_change(self):
        """The same samples for another sun, others for another index; those that nobody speaks of go."""
        settings = stage("changed")
        obj = ball()
        working = job.Job(bpy.context)
        said = []
        while not working.tick():
            said.append(working.words)
            if working.run:
                working.run.wait(interval=0.005)
        working.end()
        self.assertTrue([words for words in said if words.startswith("Voxelising 'Ball': ")], said)
        first, made = floor_map(bpy.path.abspath(settings.volume_file)), samples_in("changed")
        self.assertEqual(len(made), 1)
        bpy.data.lights["Sun"].energy = 6.0
        numpy.testing.assert_allclose(floor_map(baked()), 2 * first, rtol=2e-3, atol=0.02)
        self.assertEqual(samples_in("changed"), made)
        bpy.data.lights["Sun"].energy = 3.0
        obj.data.materials[0].node_tree.nodes["Glass BSDF"].inputs["IOR"].default_value = 1.4
        self.assertGreater(off(floor_map(baked()), first), 0.2)
        self.assertEqual(len(samples_in("changed")), 1)
        self.assertNotEqual(set(samples_in("changed")), set(made))
        obj.photic.graded.voxel_size = 1e-5
        with self.assertRaisesRegex(RuntimeError, "'Ball' can't be voxelised: .* use larger voxels"):
            bpy.ops.photic.bake()
        obj.photic.graded.through = graded.SHARP
        baked()
        self.assertEqual(samples_in("changed"), {})

    def test_an_index_volume_goes_where_its_object_is(self):
        """Samples of a lying egg, made upright at the origin and larger, against the egg voxelised in its place."""
        settings = stage("placed")
        # How rays meet the faces' voxels is chance, and 6 % of the light at one ray a voxel.
        settings.options_wavefront.spacing, settings.options_wavefront.steps = 0.5, 2
        turned = (0.0, math.radians(60), math.radians(50))
        obj = ball()
        obj.rotation_euler, obj.scale = turned, (1.0, 1.0, 0.5)
        obj.photic.graded.voxel_size, obj.photic.graded.smooth = 0.3 / 40, 0.6 / 40
        obj.location.x = 0.1
        wanted = floor_map(baked())
        bpy.data.objects.remove(obj)
        path = OUT / "egg.vdb"
        (OUT / "egg.csv").write_text("\n".join(f"{math.sin(a)}, {-0.5 * math.cos(a)}" for a in numpy.linspace(0, math.pi, 181)))
        baker("voxelise", OUT / "egg.csv", "--ior", INDEX, "--voxel-size", 1 / 40, "--smooth", 2, "--absorption", "6,0,0",
              "-o", path, "--progress=none")
        bpy.ops.mesh.primitive_cube_add(size=2.0, location=(0.1, 0.0, 0.5), rotation=turned)
        cube = bpy.context.object
        cube.name, cube.scale = "Cube", (0.3, 0.3, 0.3)
        cube.data.materials.append(scenes.glass("Volume"))
        cube.photic.graded.through, cube.photic.graded.file = graded.FILE, str(path)
        found = floor_map(baked())
        self.assertLess(off(found, wanted), 0.05)
        self.assertGreater(off(found[::-1], wanted), 0.2, "a mirrored one would be told")
        cube.photic.graded.absorption_grid = "absorption"
        volume = baked()
        scene_file = OUT / "floor.toml"
        baker("picture", scene_file, volume, "--receiver", "floor", "--resolution", 240, "-o", OUT, "--progress=none")
        red, green, _, _ = numpy.moveaxis(picture(OUT / f"{pathlib.Path(volume).stem}_floor.exr"), 2, 0)
        numpy.testing.assert_allclose(green.sum(), found.sum(), rtol=2e-3)
        self.assertTrue(0.1 < red.sum() / green.sum() < 0.5, red.sum() / green.sum())   # exp(-6 . 0.2 m) is 0.3

        def refused(words):
            with self.assertRaisesRegex(RuntimeError, words):
                bpy.ops.photic.bake()
            self.assertEqual(bpy.context.view_layer.objects.active, cube)
            self.assertRegex(" ".join(said for _, said in scene_check.complaints(bpy.context)), words)
        cube.photic.graded.absorption_grid = "dye"
        refused("Cube: cannot read .*egg.vdb.*no grid 'dye'.* it holds n .float., absorption .vec3s.")
        cube.photic.graded.absorption_grid, cube.photic.graded.grid = "", "absorption"
        refused("Cube: cannot read .*egg.vdb.*no float grid 'absorption'")
        path.write_bytes(b"no volume")
        cube.photic.graded.grid = ""
        refused("Cube: .*egg.vdb")
        path.unlink()
        refused("The index volume '.*egg.vdb' of 'Cube' is gone")

    def test_a_lens_is_the_formula(self):
        stage("lens")
        ball(through=graded.LENS)
        found = baked()
        wanted = by_hand("luneburg", '[[medium]]\nname = "lens"\nindex = { kind = "luneburg", center = [0, 0, 0.5], radius = 0.3 }\n')
        self.assertLess(off(floor_map(found), floor_map(wanted)), 1e-3)
        # Light straight from above meets in the lowest point of the ball.
        values = []
        for z in (0.14, 0.2, 0.26):
            (OUT / "points.csv").write_text(f"0.0,0.0,{z}\n")
            values.append(json.loads(baker("sample", found, OUT / "points.csv", "--json"))["frames"][0]["points"][0]["irradiance"])
        self.assertGreater(values[1], 5 * max(values[0], values[2]))

    def test_a_rod_with_sharp_faces(self):
        """A lens of copiers, behind faces that refract and reflect."""
        stage("rod")
        bpy.ops.mesh.primitive_cylinder_add(vertices=96, radius=0.2, depth=0.6, location=CENTRE)
        rod = bpy.context.object
        rod.name = "Rod"
        rod.data.materials.append(scenes.glass("Glass", 1.6))
        rod.photic.graded.through, rod.photic.graded.faces, rod.photic.graded.focus = graded.ROD, True, 1.0
        power = circles(floor_map(baked()))
        # Near the axis, light that comes in at h leaves at h cos(0.6 g), with the slope n0 g h sin(0.6 g), 0.2 m above the
        # floor: there it is 0.18 h from the axis. Both faces keep what Fresnel's equations leave.
        g = math.pi / 2
        self.assertLess(0.2 * abs(math.cos(0.6 * g) - 0.2 * 1.6 * g * math.sin(0.6 * g)), 0.04)
        wanted = 3.0 * math.pi * 0.2 ** 2 * (1 - (0.6 / 2.6) ** 2) ** 2
        self.assertAlmostEqual(power[0.05] / wanted, 1.0, delta=0.02)
        self.assertLess(power[0.3] / wanted, 1.02)

    def test_a_lens_over_water(self):
        settings = stage("water")
        ball(through=graded.LENS)
        scenes.sheet("Water", 1.1, 24, lambda x, y: 0.1 + 0.004 * math.sin(9 * x), scenes.glass())
        self.assertEqual([words for _, words in scene_check.complaints(bpy.context)], [])
        energy = floor_map(baked())
        side = energy[110:130, 10:25].mean()        # beside the lens, below the water
        self.assertAlmostEqual(side / 3.0, 0.98, delta=0.15)
        self.assertGreater(energy[115:125, 115:125].mean(), 2 * side)
        self.assertAlmostEqual(settings.ior, scenes.IOR, 4)
        self.assertLess(abs(settings.level - 0.1), 0.01)

    def test_light_in_the_haze(self):
        """With a medium of the scene's own, and no water, all light that was bent is seen."""
        settings = stage("haze")
        ball(through=graded.LENS)
        settings.medium_from, settings.scattering = "SCENE", (0.3, 0.3, 0.3)
        baked()
        self.assertFalse(settings.has_density)
        self.assertFalse(settings.volume.hide_render)
        if not volumes_are_shown("CYCLES"):
            self.skipTest("Cycles shows no volume grid here, a stock one neither")
        for obj in bpy.context.scene.objects:
            obj.hide_render = obj != settings.volume
        scenes.camera((0, -4, 0.4), (0, 0, 0.4), orthographic=1.2)
        seen = render("CYCLES", 48, samples=8)[..., 0]      # rows from z = -0.2 on, 25 mm each
        waist, above = seen[16], seen[26]
        self.assertGreater(waist[22:26].max(), 5 * above[22:26].max())
        self.assertLess(waist[4:16].max(), 0.2 * waist[22:26].max())


if __name__ == "__main__":
    unittest.main()
