# SPDX-License-Identifier: Apache-2.0
"""Receivers against `photic picture` of the same bake, in both engines, wherever they are moved."""
import json
import math
import pathlib
import unittest

import bpy
import numpy
import scenes
from mathutils import Euler, Matrix, Vector
from support import ENGINES, OUT, baker, picture, render, rmse

SIZE = 128
HALF = 0.6          # [m] of the pictured square
LIMIT = 0.01


def domain_text(low, high):
    return (f"photic = 1\n[domain]\nmin = {list(low)}\nmax = {list(high)}\nresolution = 32\n"
            "[[light]]\ntype = \"sun\"\ndirection = [0, 0, -1]\nirradiance = 3.0\n"
            "[[surface]]\nname = \"water\"\nflat = true\nsize = [4, 4]\n")


def baked_picture(point, normal):
    """The baker's own picture of a plane, and the frame that it is in: (picture, right, up) as unit vectors."""
    point, normal = Vector(point), Vector(normal).normalized()
    sky = Vector((0, 1, 0)) if abs(normal.z) > 0.999 else Vector((0, 0, 1))
    up = (sky - sky.dot(normal) * normal).normalized()
    right = up.cross(normal)
    reach = [HALF * (abs(up[i]) + abs(right[i])) for i in range(3)]
    # The box whose cut with an axis-aligned plane is the square.
    low, high = ([p + s * max(r, 0.1) for p, r in zip(point, reach)] for s in (-1, 1))
    scene = OUT / "plane.toml"
    scene.write_text(domain_text(low, high) + f"[[object]]\nname = \"plane\"\nplane = {{ point = {list(point)}, "
                     f"normal = {list(normal)} }}\n")
    volume = pathlib.Path(bpy.context.scene.photic.volume_file)
    baker("picture", scene, volume, "-o", OUT, "--receiver", "plane", "--resolution", SIZE, "--progress=none")
    return picture(OUT / f"{volume.stem}_plane.exr")[..., :3]


def look_along(point, normal):
    """An orthographic camera that sees what baked_picture shows: up is +y on floors and +z on walls."""
    normal = Vector(normal).normalized()
    sky = Vector((0, 1, 0)) if abs(normal.z) > 0.999 else Vector((0, 0, 1))
    up = (sky - sky.dot(normal) * normal).normalized()
    right = up.cross(normal)
    camera = bpy.context.scene.camera or scenes.camera((0, 0, 0), (0, 0, -1), orthographic=2 * HALF)
    camera.matrix_world = Matrix.Translation(Vector(point) + 0.05 * normal) @ Matrix((right, up, normal)).transposed().to_4x4()
    camera.data.clip_start = 0.001
    bpy.context.view_layer.update()


def compare(test, point, normal, engines=ENGINES):
    wanted = baked_picture(point, normal)
    test.assertGreater(wanted.std() / wanted.mean(), 0.05, "nothing to be seen there")
    look_along(point, normal)
    for engine in engines:
        found = render(engine, SIZE)[..., :3] * math.pi / 0.8
        test.assertLess(rmse(found, wanted), LIMIT, engine)


def compare_wall(test, floor, side):
    """The floor's mesh, which lies at z = -1, stood up as a wall at x = 0.7 side, its lit side towards the middle."""
    before = floor.matrix_world.copy()
    stand = Matrix(((0, 0, -side), (0, 1, 0), (side, 0, 0))).to_4x4()
    floor.matrix_world = Matrix.Translation(((0.7 - 1.0) * side, 0.0, -0.65)) @ stand
    bpy.context.view_layer.update()
    global HALF
    look_along((0.7 * side, 0, -0.65), (-side, 0, 0))
    HALF, kept = 0.3, HALF
    bpy.context.scene.camera.data.ortho_scale = 2 * HALF
    try:
        compare(test, (0.7 * side, 0, -0.65), (-side, 0, 0))
    finally:
        HALF = kept
        bpy.context.scene.camera.data.ortho_scale = 2 * HALF
        floor.matrix_world = before


class Receivers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene, cls.water, cls.floor = scenes.pool(waves=64, floor_size=2.0, floor_depth=1.0)
        settings = cls.scene.photic
        settings.folder, settings.resolution = str(OUT), 96
        settings.options_beams.disc = "off"
        settings.match_cycles = False
        assert bpy.ops.photic.bake() == {"FINISHED"}
        for obj in (cls.water, bpy.data.objects["Sun"]):
            obj.hide_render = True

    def test_the_bake_says_its_error(self):
        self.assertRegex(self.scene.photic.light_errors, r"^Light on 'Floor' is off by [0-9.]+ % at [0-9.]+ mm; half of it with")

    def test_floor(self):
        compare(self, (0, 0, -1.0), (0, 0, 1))

    def test_shifted_by_a_voxel_is_found(self):
        wanted = baked_picture((0, 0, -1.0), (0, 0, 1))
        look_along((0.02, 0, -1.0), (0, 0, 1))
        self.assertGreater(rmse(render("CYCLES", SIZE)[..., :3] * math.pi / 0.8, wanted), LIMIT)

    def test_moved_after_the_bake(self):
        before = self.floor.matrix_world.copy()
        for height in (-0.7, -0.43):
            self.floor.location.z = height + 1.0
            bpy.context.view_layer.update()
            compare(self, (0, 0, height), (0, 0, 1), engines=ENGINES if height == -0.43 else ENGINES[:1])
        self.floor.matrix_world = before

    def test_wall(self):
        compare_wall(self, self.floor, 1)

    def test_moved_and_turned_volume_takes_its_light_along(self):
        look_along((0, 0, -1.0), (0, 0, 1))
        wanted = render("CYCLES", SIZE)
        self.assertGreater(wanted[..., :3].mean(), 0.1)
        volume, camera = self.scene.photic.volume, self.scene.camera
        move = Matrix.Translation((3.0, -2.0, 0.7)) @ Euler((0.5, -0.3, 1.1)).to_matrix().to_4x4()
        things = [volume, self.floor, camera]
        before = [thing.matrix_world.copy() for thing in things]
        for thing in things:
            thing.matrix_world = move @ thing.matrix_world
        bpy.context.view_layer.update()
        try:
            for engine in ENGINES:
                found = render(engine, SIZE)
                self.assertLess(rmse(found[..., :3], wanted[..., :3]), LIMIT, engine)
            self.floor.matrix_world = before[1]     # left behind, it gets none of that light
            camera.matrix_world = before[2]
            bpy.context.view_layer.update()
            self.assertEqual(render("CYCLES", 16)[..., :3].max(), 0.0)
        finally:
            for thing, matrix in zip(things, before):
                thing.matrix_world = matrix
            bpy.context.view_layer.update()

    def test_match_cycles_divides_by_n_squared_under_water_only(self):
        look_along((0, 0, -1.0), (0, 0, 1))
        plain = render("CYCLES", 32)[..., :3]
        self.assertGreater(plain.min(), 0.0)
        self.scene.photic.match_cycles = True
        try:
            matched = render("CYCLES", 32)[..., :3]
            numpy.testing.assert_allclose(matched, plain / scenes.IOR ** 2, rtol=1e-4)
            self.scene.photic.level, kept = -5.0, self.scene.photic.level
            self.scene.photic.match_cycles = True
            numpy.testing.assert_allclose(render("CYCLES", 32)[..., :3], plain, rtol=1e-4)
            self.scene.photic.level = kept
        finally:
            self.scene.photic.match_cycles = False

    def test_strength(self):
        look_along((0, 0, -1.0), (0, 0, 1))
        plain = render("CYCLES", 32)[..., :3]
        self.assertGreater(plain.min(), 0.0)
        self.scene.photic.strength = 2.5
        doubled = render("CYCLES", 32)[..., :3]
        self.scene.photic.strength = 1.0
        numpy.testing.assert_allclose(doubled, 2.5 * plain, rtol=1e-4)


class ColouredReceivers(unittest.TestCase):
    def test_coloured_sun(self):
        scene, water, floor = scenes.pool(waves=48, floor_depth=1.0)
        bpy.data.lights["Sun"].color = (1.0, 0.7, 0.3)
        settings = scene.photic
        settings.folder, settings.resolution, settings.match_cycles = str(OUT), 64, False
        settings.options_beams.disc = "off"
        assert bpy.ops.photic.bake() == {"FINISHED"}
        water.hide_render = bpy.data.objects["Sun"].hide_render = True
        wanted = baked_picture((0, 0, -1.0), (0, 0, 1))
        look_along((0, 0, -1.0), (0, 0, 1))
        for engine in ENGINES:
            found = render(engine, SIZE)[..., :3] * math.pi / 0.8
            for channel in range(3):
                self.assertLess(rmse(found[..., channel], wanted[..., channel]), LIMIT, (engine, channel))
            self.assertGreater(found[..., 0].mean(), 2 * found[..., 2].mean())


class OpposedSuns(unittest.TestCase):
    """A wall between two suns: each lights its own side, which one direction a voxel cannot tell."""

    @classmethod
    def setUpClass(cls):
        cls.scene, cls.water, cls.floor = scenes.pool(waves=64, floor_size=2.0, floor_depth=1.0)
        scenes.sun(energy=2.0, direction=(-0.77, -0.25, -0.58)).name = "Sun 2"
        settings = cls.scene.photic
        settings.folder, settings.resolution = str(OUT), 96
        settings.options_beams.disc = "off"
        settings.match_cycles = False
        assert bpy.ops.photic.bake() == {"FINISHED"}
        for obj in (cls.water, bpy.data.objects["Sun"], bpy.data.objects["Sun 2"]):
            obj.hide_render = True

    def test_the_second_lobe_is_there(self):
        sidecar = json.loads(pathlib.Path(bpy.path.abspath(self.scene.photic.atlas_file)).read_text(encoding="utf-8"))
        self.assertTrue(sidecar["image_2"])

    def test_walls(self):
        for side in (1, -1):
            compare_wall(self, self.floor, side)
