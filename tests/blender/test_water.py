# SPDX-License-Identifier: Apache-2.0
"""Water as a height field or as a mesh: which is chosen, that it is said, and that the light is the same."""
import json
import math
import pathlib
import tomllib
import unittest

import bpy
import numpy
import scenes
from support import OUT, baker, picture

scenes.enable()
from photic.core import height_file, regular_grid  # noqa: E402

FINE, COARSE = 256, 128     # faces along a side of the water; a voxel is 1/32 m
# Facets with smooth normals against a smooth surface: measured 3.0 % at COARSE and 0.6 % at FINE, second order.
SAME_LIGHT = 0.01


def grid_mesh(columns, rows, place):
    """Vertices row by row at place(column, row), and two triangles a cell."""
    positions = numpy.array([place(i, j) for j in range(rows) for i in range(columns)], dtype=float)
    corners = (numpy.arange(rows - 1)[:, None] * columns + numpy.arange(columns - 1)).ravel()
    triangles = numpy.concatenate([corners[:, None] + step for step in ((0, 1, columns + 1), (0, columns + 1, columns))])
    return positions, triangles


def points_of(grid):
    """What the baker makes of a grid: its samples' positions."""
    rows, columns = grid.heights.shape
    x = grid.center[0] + grid.size[0] * (numpy.arange(columns) / (columns - 1) - 0.5)
    y = grid.center[1] + grid.size[1] * (numpy.arange(rows) / (rows - 1) - 0.5)
    x, y = numpy.meshgrid(x, y)
    if grid.moves:
        x, y = x + grid.moves[0], y + grid.moves[1]
    return numpy.stack([x, y, grid.heights + grid.center[2]], axis=-1).reshape(-1, 3)


def sorted_rows(points):
    return points[numpy.lexsort(points.T.round(6))]


class RegularGrids(unittest.TestCase):
    def test_any_order_of_vertices(self):
        positions, triangles = grid_mesh(9, 5, lambda i, j: (3 + 0.5 * i, 0.25 * j - 1, math.sin(i + 2 * j)))
        order = numpy.random.default_rng(1).permutation(len(positions))
        for shuffled, corners in ((positions, triangles), (positions[order], numpy.argsort(order)[triangles])):
            grid = regular_grid.find(shuffled, corners)
            self.assertIsNone(grid.moves)
            numpy.testing.assert_allclose(grid.size, (4.0, 1.0))
            numpy.testing.assert_allclose(points_of(grid), positions, atol=1e-12)

    def test_points_that_moved_sideways(self):
        def place(i, j):
            return 0.5 * i + 0.1 * math.sin(j), 0.25 * j + 0.05 * math.cos(i), math.sin(i * j)
        positions, triangles = grid_mesh(9, 5, place)
        for turned in (positions, positions[:, [1, 0, 2]] * (-1, 1, 1), positions * (-1, 1, 1)):
            grid = regular_grid.find(turned, triangles)
            numpy.testing.assert_allclose(sorted_rows(points_of(grid)), sorted_rows(turned), atol=1e-12)

    def refused(self, words, positions, triangles):
        with self.assertRaisesRegex(regular_grid.NotRegular, words):
            regular_grid.find(positions, triangles)

    def test_what_is_none(self):
        positions, triangles = grid_mesh(9, 5, lambda i, j: (0.5 * i, 0.25 * j, 0.0))
        self.refused("gaps", positions, triangles[:-1])
        self.refused("gaps", positions, numpy.concatenate([triangles[:-1], triangles[:1]]))
        self.refused("too small", *grid_mesh(3, 5, lambda i, j: (i, j, 0.0)))
        self.refused("regular grid|turned|far", positions[:, [0, 2, 1]], triangles)      # upright, as a wall
        angle = 0.5
        turn = numpy.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
        self.refused("turned", positions @ turn.T, triangles)
        breaking = positions.copy()
        breaking[:, 0] += 0.6 * numpy.sin(math.pi * positions[:, 0])
        self.refused("break", breaking, triangles)
        jumps = triangles.copy()
        jumps[0] = (0, 2, 9)
        self.refused("neighbours|regular", positions, jumps)


class Files(unittest.TestCase):
    def test_blender_reads_the_heights(self):
        heights = numpy.arange(20.0).reshape(4, 5) / 7
        moves = (heights + 100, heights - 50)
        name = height_file.write_exr(OUT, heights, moves)
        self.assertEqual(height_file.write_exr(OUT, heights, moves), name)
        read = picture(OUT / name)      # the lowest row first
        for channel, wanted in zip(range(3), (moves[0], heights, moves[1])):
            numpy.testing.assert_allclose(read[..., channel], wanted, rtol=1e-6)


class Light(unittest.TestCase):
    def scene(self, waves=FINE, **more):
        scene, self.water, self.floor = scenes.pool(waves=waves, floor_depth=1.0, **more)
        settings = scene.photic
        settings.folder, settings.resolution = str(OUT), 64
        settings.preview_after_bake = False
        settings.options_beams.disc = "off"
        return scene

    def bake(self, surface):
        """(volume's path, the scene file's [[surface]])."""
        self.water.photic.surface = surface
        settings = bpy.context.scene.photic
        settings.folder = str(OUT / surface)
        bpy.ops.photic.bake()
        text = pathlib.Path(settings.folder, "Scene_scene", "Scene.toml").read_text(encoding="utf-8")
        return settings.volume_file, tomllib.loads(text)["surface"][0]

    def difference(self):
        """Relative L1 of the mesh's light against the height field's."""
        mesh, table = self.bake("MESH")
        self.assertEqual(table["kind"], "mesh")
        self.assertIn("as you chose", bpy.context.scene.photic.forms)
        field, table = self.bake("AUTO")
        self.assertEqual(table["kind"], "height_field")
        self.assertIn("height field of", bpy.context.scene.photic.forms)
        answer = json.loads(baker("compare", mesh, field, "--json"))["irradiance"]
        self.assertAlmostEqual(answer["energy_ratio"], 1.0, 3)
        return answer["relative_l1"], table

    def test_same_light_either_way(self):
        self.scene(COARSE)
        coarse, _ = self.difference()
        self.scene(FINE)
        fine, _ = self.difference()
        print(f"mesh against height field: {100 * coarse:.2f} % at {COARSE}, {100 * fine:.2f} % at {FINE} faces a side")
        self.assertLess(fine, SAME_LIGHT)
        self.assertLess(fine, 0.6 * coarse)

    def test_another_water_is_another_light(self):
        self.scene(FINE)
        field, _ = self.bake("AUTO")
        self.water.location.x += 0.02
        bpy.context.view_layer.update()
        moved, _ = self.bake("MESH")
        answer = json.loads(baker("compare", moved, field, "--json"))["irradiance"]
        self.assertGreater(answer["relative_l1"], 3 * SAME_LIGHT)

    def test_ocean_moves_sideways(self):
        scene = self.scene(4)
        self.water.modifiers.clear()
        ocean = self.water.modifiers.new("Ocean", "OCEAN")
        for name, value in {"geometry_mode": "GENERATE", "spatial_size": 4, "resolution": 14, "viewport_resolution": 14,
                            "wind_velocity": 3.0, "wave_scale": 0.1, "wave_scale_min": 0.1, "choppiness": 0.7}.items():
            setattr(ocean, name, value)
        for polygon in self.water.data.polygons:
            polygon.use_smooth = True
        bpy.context.view_layer.update()
        difference, table = self.difference()
        print(f"an ocean's mesh against its height field: {100 * difference:.2f} %")
        self.assertTrue(table["displacement"])
        self.assertIn("movement sideways", scene.photic.forms)
        self.assertLess(difference, 3 * SAME_LIGHT)
        ocean.choppiness = 0.0
        bpy.context.view_layer.update()
        self.assertNotIn("displacement", self.bake("AUTO")[1])

    def test_reasons_are_said(self):
        scene = self.scene(24)

        def forms():
            self.water.data.update()
            bpy.context.view_layer.update()
            bpy.ops.photic.validate()
            return scene.photic.forms
        self.assertIn("height field of 25 × 25", forms())
        self.water.rotation_euler.z = 0.6
        self.assertIn("mesh: its grid is turned", forms())
        self.water.rotation_euler.z = math.pi / 2
        self.assertIn("height field of 25 × 25", forms())
        self.water.data.polygons.foreach_set("use_smooth", [False] * len(self.water.data.polygons))
        self.assertIn("shaded flat", forms())
        self.water.data.polygons.foreach_set("use_smooth", [True] * len(self.water.data.polygons))
        other = scenes.sheet("Mirror", 0.2, 1, lambda x, y: -0.4, scenes.material("Metal", Metallic=1.0, Roughness=0.0))
        self.assertIn("not alone", forms())
        bpy.data.objects.remove(other)
        self.water.modifiers.new("Triangles", "DECIMATE").ratio = 0.5
        self.assertIn("mesh: its", forms())


