# SPDX-License-Identifier: Apache-2.0
"""Receivers that look light up at their vertices (Geometry Nodes' Sample Grid, since Blender 5.0), against `photic picture` and
against the atlas."""
import json
import math
import pathlib
import time
import unittest

import bpy
import numpy
import scenes
from mathutils import Euler, Matrix, Vector
from support import ENGINES, OUT, baker, contents, render, rmse
from test_receivers import LIMIT, SIZE, baked_picture, compare, compare_wall, look_along

MODIFIER = "Photic Light"


def sheet(cells, name="Floor"):
    """The pool's floor as so many cells a side."""
    old = bpy.data.objects.get(name)
    material = old.data.materials[0] if old else bpy.data.materials["Floor"]
    if old:
        bpy.data.objects.remove(old)
    return scenes.sheet(name, 2.0, cells, lambda x, y: -1.0, material, smooth=False)


def looks_up_at_vertices(obj):
    return MODIFIER in obj.modifiers


class Dense(unittest.TestCase):
    """A floor whose mesh is much finer than the voxels."""

    def bake(self, resolution=96, cells=520, energy=None):
        self.scene, self.water, _ = scenes.pool(waves=64, floor_size=2.0, floor_depth=1.0)
        self.floor = sheet(cells)
        settings = self.scene.photic
        settings.folder, settings.resolution = str(OUT), resolution
        settings.options_beams.disc = "off"
        settings.match_cycles = False
        if energy:
            energy()
        self.assertEqual(bpy.ops.photic.bake(), {"FINISHED"})
        for obj in self.scene.objects:
            if obj == self.water or obj.type == "LIGHT":
                obj.hide_render = True

    def test_it_is_lit_in_every_version(self):
        self.bake()
        self.assertEqual(looks_up_at_vertices(self.floor), bpy.app.version >= (5, 0, 0))
        compare(self, (0, 0, -1.0), (0, 0, 1), engines=ENGINES[:1])


@unittest.skipUnless(scenes.compat().samples_grids(), "Blender has no Sample Grid before 5.0")
class AtVertices(Dense):
    test_it_is_lit_in_every_version = None     # tested once, by its own class

    def test_floor_wherever_it_is(self):
        self.bake()
        self.assertTrue(looks_up_at_vertices(self.floor))
        compare(self, (0, 0, -1.0), (0, 0, 1))
        self.floor.location.z = 0.57
        bpy.context.view_layer.update()
        compare(self, (0, 0, -0.43), (0, 0, 1))
        self.floor.location.z = 0.0
        bpy.context.view_layer.update()
        compare_wall(self, self.floor, 1)

        # A volume that is moved and turned takes its light along.
        look_along((0, 0, -1.0), (0, 0, 1))
        wanted = render("CYCLES", SIZE)
        move = Matrix.Translation((3.0, -2.0, 0.7)) @ Euler((0.5, -0.3, 1.1)).to_matrix().to_4x4()
        things = [self.scene.photic.volume, self.floor, self.scene.camera]
        for thing in things:
            thing.matrix_world = move @ thing.matrix_world
        bpy.context.view_layer.update()
        for engine in ENGINES:
            self.assertLess(rmse(render(engine, SIZE)[..., :3], wanted[..., :3]), LIMIT, engine)

    def test_a_coarse_mesh_keeps_the_atlas_and_so_does_what_shares_its_material(self):
        self.bake(cells=20)
        self.assertFalse(looks_up_at_vertices(self.floor))
        dense = sheet(520, "Dense")
        coarse = self.floor
        dense.data.materials[0] = coarse.data.materials[0]
        self.assertEqual(bpy.ops.photic.preview(show=True), {"FINISHED"})
        self.assertFalse(looks_up_at_vertices(dense))
        dense.data.materials[0] = coarse.data.materials[0].copy()
        self.assertEqual(bpy.ops.photic.preview(show=True), {"FINISHED"})
        self.assertTrue(looks_up_at_vertices(dense))
        self.assertFalse(looks_up_at_vertices(coarse))
        bpy.data.objects.remove(dense)
        compare(self, (0, 0, -1.0), (0, 0, 1), engines=ENGINES[:1])

    def test_colours_and_a_second_sun(self):
        def lights():
            bpy.data.lights["Sun"].color = (1.0, 0.7, 0.3)
            scenes.sun(energy=2.0, direction=(-0.77, -0.25, -0.58)).name = "Sun 2"
        self.bake(energy=lights)
        self.assertTrue(looks_up_at_vertices(self.floor))
        # Stood up as a wall that both suns see, and looked up at its vertices: what the command line says of these points.
        self.floor.matrix_world = Matrix.Translation((-0.3, 0.0, -0.65)) @ Matrix(((0, 0, -1), (0, 1, 0), (1, 0, 0))).to_4x4()
        bpy.context.view_layer.update()
        mesh = self.floor.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        def attribute(name):
            values = numpy.empty(3 * len(mesh.vertices), dtype=numpy.float32)
            mesh.attributes[name].data.foreach_get("vector", values)
            return values.reshape(-1, 3)
        normal = numpy.array(self.floor.matrix_world.to_3x3() @ Vector((0, 0, 1)))
        found = 0.0
        for suffix in ("", "_2"):
            flux, rgb = attribute("photic_flux" + suffix), attribute("photic_rgb" + suffix)
            mean = numpy.maximum(rgb.mean(axis=1, keepdims=True), 1e-6)
            found = found + numpy.maximum(0.0, -(flux @ normal))[:, None] * rgb / mean
        points = [self.floor.matrix_world @ vertex.co for vertex in mesh.vertices][::97]
        table = OUT / "points.csv"
        table.write_text("\n".join(",".join(map(repr, (*point, *map(float, normal)))) for point in points))
        sampled = json.loads(baker("sample", self.scene.photic.volume_file, table, "--json"))["frames"][0]["points"]
        inside = [i for i, point in enumerate(sampled) if point["place"] == "inside"]
        wanted = numpy.array([sampled[i]["face_irradiance"] for i in inside])
        self.assertGreater(len(inside), 500)
        self.assertGreater(wanted[:, 0].mean(), 1.2 * wanted[:, 2].mean())
        self.assertLess(abs(found[::97][inside] - wanted).sum() / wanted.sum(), 1e-4)
        # The material makes the same of it as of the atlas, but for what is between vertices.
        look_along((0.7, 0, -0.65), tuple(normal))
        bpy.context.scene.camera.data.ortho_scale = 0.5
        for engine in ENGINES:
            self.scene.photic.look_up = "AUTO"
            bpy.ops.photic.preview(show=True)
            self.assertTrue(looks_up_at_vertices(self.floor))
            at_vertices = render(engine, SIZE)[..., :3]
            self.scene.photic.look_up = "PIXELS"
            bpy.ops.photic.preview(show=True)
            at_pixels = render(engine, SIZE)[..., :3]
            for channel in range(3):
                self.assertGreater(at_pixels[..., channel].mean(), 0.01)
                self.assertLess(rmse(at_vertices[..., channel], at_pixels[..., channel]), 4 * LIMIT, (engine, channel))

    def test_it_goes_without_a_trace(self):
        self.bake(resolution=32)
        self.assertTrue(looks_up_at_vertices(self.floor))
        bpy.ops.photic.preview(show=False)
        self.assertEqual(list(self.floor.modifiers), [])
        bpy.ops.photic.preview(show=True)
        self.assertEqual([m.name for m in self.floor.modifiers], [MODIFIER])
        self.scene.photic.look_up = "PIXELS"
        bpy.ops.photic.preview(show=True)
        self.assertEqual(list(self.floor.modifiers), [])
        bpy.ops.photic.remove()
        self.assertEqual([name for name in contents()["node_groups"] if name.startswith("Photic")], [])

    def test_measured_against_the_atlas(self):
        """Prints error and time of both, by the mesh's edges in voxels; the error is why edges of a fifth of one are chosen."""
        self.bake()
        voxel = min(json.loads(pathlib.Path(self.scene.photic.atlas_file).read_text(encoding="utf-8"))["voxel_size"])
        wanted = baked_picture((0, 0, -1.0), (0, 0, 1))
        errors = {}
        for cells in (60, 120, 240, 520):
            self.floor = sheet(cells)
            for look_up in ("PIXELS", "VERTICES"):
                self.scene.photic.look_up = look_up
                bpy.ops.photic.preview(show=True)
                look_along((0, 0, -1.0), (0, 0, 1))
                seconds = {}
                for engine in ENGINES:
                    found = render(engine, SIZE)[..., :3] * math.pi / 0.8
                    errors[cells, look_up, engine] = rmse(found, wanted)
                    begin = time.process_time()
                    render(engine, 512, samples=16)
                    seconds[engine] = time.process_time() - begin
                print(f"edges of {2.0 / cells / voxel:.2f} voxels, at {look_up.lower()}: " + ", ".join(
                    f"{engine} {100 * errors[cells, look_up, engine]:.3f} % off, 16 samples in {seconds[engine]:.1f} s of CPU"
                    for engine in ENGINES))
        for engine in ENGINES:
            self.assertLess(errors[520, "VERTICES", engine], LIMIT)
            self.assertGreater(errors[240, "VERTICES", engine], LIMIT)
            self.assertLess(errors[60, "PIXELS", engine], 0.1 * LIMIT)
