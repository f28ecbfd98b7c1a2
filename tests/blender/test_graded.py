# SPDX-License-Identifier: Apache-2.0
"""Glass whose index varies: voxelised bodies, index volumes and lenses, from the panel to the scene file."""
import math
import tomllib
import unittest

import bpy
import numpy
import scenes
from graded_stage import CENTRE, INDEX, RADIUS, absorb, ball, scene_now, stage, tables, text_now
from mathutils import Euler, Matrix
from support import OUT

from photic.core import graded
from photic.core.program import BakerError
from photic.operators import scene_check


class Core(unittest.TestCase):
    def test_placement_is_the_matrix(self):
        for angles in ((0, 0, 0), (20, -35, 130), (170, 89, -20), (10, 90, 40), (10, -90, 0)):
            for scale in ((1, 1, 1), (2, 0.5, 3), (-1, 2, 1), (-1, -2, -0.5)):
                matrix = (Matrix.Translation((1, -2, 3)) @ Euler(map(math.radians, angles)).to_matrix().to_4x4()
                          @ Matrix.Diagonal((*scale, 1)))
                found = graded.placement(matrix, "Thing")
                again = (Matrix.Translation(found["position"]) @ Euler(map(math.radians, found["rotation"])).to_matrix().to_4x4()
                         @ Matrix.Diagonal((*found["scale"], 1)))
                numpy.testing.assert_allclose(numpy.array(again), numpy.array(matrix), atol=2e-6, err_msg=str((angles, scale)))

    def test_shear_is_refused(self):
        sheared = Matrix.Diagonal((1, 2, 1, 1)) @ Matrix.Rotation(0.5, 4, "Z")
        with self.assertRaisesRegex(BakerError, "'Thing' is sheared .* apply") as caught:
            graded.placement(sheared, "Thing")
        self.assertEqual(caught.exception.where, "Thing")
        with self.assertRaisesRegex(BakerError, "scale of 0"):
            graded.placement(Matrix.Diagonal((1, 0, 1, 1)), "Thing")

    def test_colours_are_parted_as_the_baker_parts_them(self):
        """Index of a flint glass at the channels, by Cauchy's formula through its two numbers, and one without."""
        red, green, blue = graded.channel_indices(1.62, 36.0)
        a = [1 / nm ** 2 for nm in (486.13, 587.56, 656.27)]
        slope = (blue - red) / (1 / 464.3 ** 2 - 1 / 611.4 ** 2)
        self.assertAlmostEqual(0.62 / (slope * (a[0] - a[2])), 36.0, 6)
        self.assertAlmostEqual(green + slope * (a[1] - 1 / 549.1 ** 2), 1.62, 9)
        self.assertEqual(graded.channel_indices(1.5, 0.0), (1.5,))
        self.assertEqual(graded.channel_indices((1.5, 1.51, 1.52), 50.0), (1.5, 1.51, 1.52))

    def test_bodies_that_touch_are_one(self):
        boxes = [(numpy.full(3, low), numpy.full(3, high)) for low, high in ((0, 1), (5, 6), (0.9, 2), (1.9, 5.1), (9, 10))]
        self.assertEqual(graded.groups(boxes), [[0, 1, 2, 3], [4]])

    def test_only_samples_that_nobody_speaks_of_go(self):
        folder = OUT / "tidy"
        folder.mkdir()
        kept, old, other = "0123456789abcdef", "fedcba9876543210", "mine"
        for name in (kept, old, other):
            for ending in (".vdb", ".solids.toml"):
                (folder / (name + ending)).write_text(f'file = "{old}.vdb"')    # tables of bodies keep nothing alive
        (folder / "Scene.toml").write_text(f'index = "{kept}.vdb"')
        graded.tidy(folder)
        self.assertEqual({path.name.split(".")[0] for path in folder.iterdir()}, {kept, other, "Scene"})


class Written(unittest.TestCase):
    def setUp(self):
        self.settings = stage()

    def said(self):
        return " | ".join(words for _, words in scene_check.complaints(bpy.context))

    def refused(self, words, blamed):
        with self.assertRaisesRegex(BakerError, words) as caught:
            text_now()
        self.assertEqual(caught.exception.where, blamed)

    def test_a_sharp_body_stays_as_it_was(self):
        ball(through=graded.SHARP)
        scene = tables()
        self.assertEqual(scene["bake"]["method"], "auto")
        self.assertNotIn("index", scene["medium"][0])
        self.assertEqual(scene["surface"][0]["inside"], scene["medium"][0]["name"])

    def test_a_voxelised_body(self):
        obj = ball()
        absorb(obj.data.materials[0], (0.0, 1.0, 2.0))
        text = text_now()
        scene = tomllib.loads(str(text))
        self.assertEqual(scene["bake"]["method"], "wavefront")
        self.assertNotIn("surface", scene)
        medium, = scene["medium"]
        volume, = text.volumes
        self.assertEqual((medium["index"], medium["absorption_volume"]), (volume.target.name,) * 2)
        bodies = tomllib.loads(volume.table.read_text())
        self.assertAlmostEqual(bodies["voxel_size"], 0.6 / 128, 5)
        self.assertAlmostEqual(bodies["smooth"], 1.0, 6)
        self.assertAlmostEqual(bodies["solid"][0]["ior"], INDEX, 6)
        numpy.testing.assert_allclose(bodies["solid"][0]["absorption"], (0, 1, 2), atol=1e-6)
        self.assertIn("'Ball' is baked as samples of its index of 4.69 mm, its faces 12 mm wide", scene_now().forms_words)
        obj.photic.graded.voxel_size, obj.photic.graded.smooth = 0.02, 0.05
        other, = text_now().volumes
        self.assertNotEqual(other.target, volume.target)
        self.assertAlmostEqual(tomllib.loads(other.table.read_text())["smooth"], 2.5, 5)
        obj.photic.abbe = 40.0
        self.assertEqual(len(set(tables()["medium"][0]["index"])), 3)
        obj.photic.graded.smooth = 3.0
        self.refused("use samples of 0.03 m", "Ball")

    def test_bodies_that_touch_share_their_samples(self):
        ball("Glass")
        ball("Wine", 0.25, ior=1.3)
        ball("Far", 0.1, (2.0, 0.0, 0.5))
        text = text_now()
        self.assertEqual(sorted(volume.owners for volume in text.volumes), [("Far",), ("Glass", "Wine")])
        self.assertEqual(len(tomllib.loads(str(text))["medium"]), 2)

    def test_an_index_volume(self):
        obj = ball(through=graded.FILE)
        self.refused("'Ball' has no index volume yet", "Ball")
        path = OUT / "given.vdb"
        obj.photic.graded.file = str(path)
        self.refused(r"The index volume '.*given.vdb' of 'Ball' is gone", "Ball")
        self.assertIn("is gone", self.said())
        path.write_bytes(b"")
        obj.scale, obj.rotation_euler = (1, 2, 3), (0.1, 0.2, 0.3)
        obj.photic.graded.absorption_grid = "absorption"
        index = tables()["medium"][0]["index"]
        numpy.testing.assert_allclose(index["position"], CENTRE, atol=1e-6)
        numpy.testing.assert_allclose(index["rotation"], numpy.degrees((0.1, 0.2, 0.3)), atol=1e-4)
        numpy.testing.assert_allclose(index["scale"], (1, 2, 3), atol=1e-5)
        self.assertEqual(tables()["medium"][0]["absorption_volume"]["grid"], "absorption")
        obj.photic.graded.faces = True
        scene = tables()
        self.assertEqual(scene["surface"][0]["inside"], scene["medium"][0]["name"])
        parent = bpy.data.objects.new("Parent", None)
        bpy.context.scene.collection.objects.link(parent)
        parent.scale, obj.parent = (1, 1, 4), parent
        self.refused("'Ball' is sheared", "Ball")

    def test_lenses(self):
        obj = ball(through=graded.LENS)
        index = tables()["medium"][0]["index"]
        numpy.testing.assert_allclose(index["center"], CENTRE, atol=1e-6)
        self.assertAlmostEqual(index["radius"], RADIUS, 6)
        obj.scale = (1, 1, 1.5)
        self.refused(r"'Ball' is no ball \(0.6 x 0.6 x 0.9 m\)", "Ball")
        bpy.data.objects.remove(obj)
        bpy.ops.mesh.primitive_cylinder_add(vertices=48, radius=0.1, depth=0.6, location=CENTRE, rotation=(0, math.pi / 2, 0))
        rod = bpy.context.object
        rod.name = "Rod"
        rod.data.materials.append(scenes.glass("Glass", 1.6))
        rod.photic.graded.through = graded.ROD
        index = tables()["medium"][0]["index"]
        numpy.testing.assert_allclose(numpy.abs(index["axis"]), (1, 0, 0), atol=1e-6)
        numpy.testing.assert_allclose((index["n0"], index["radius"], index["length"], index["g"]),
                                      (1.6, 0.1, 0.6, math.pi / 2 / 0.6), atol=1e-5)
        rod.photic.graded.faces = True
        self.assertNotIn("radius", tables()["medium"][0]["index"])
        rod.photic.graded.focus = 0.15
        self.refused("'Rod' has a radius of 0.1 m and should focus 0.15 m .* more than 0.159 m", "Rod")

    def test_what_cannot_be_is_said(self):
        obj = ball()
        self.settings.method = "beams"
        self.refused("Beams can't bend light in 'Ball'", "Ball")
        self.settings.method, self.settings.shear = "auto", True
        self.refused("'Ball' .* Lean with the light off", "Ball")
        self.settings.shear = False
        lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
        lamp.data.energy, lamp.location = 10, CENTRE
        bpy.context.scene.collection.objects.link(lamp)
        self.assertEqual([light["type"] for light in tables()["light"]].count("point"), 1, "it may stand in a body")
        bpy.data.objects.remove(lamp)
        tumbler = ball("Tumbler", 0.4, ior=1.5, through=graded.SHARP)
        self.refused("'Ball' lies in the glass 'Tumbler'", "Ball")
        tumbler.location.x += 0.5
        self.assertIn("'Ball' reaches into the glass 'Tumbler'", self.said())
        tumbler.location.x += 0.5
        self.assertEqual(self.said(), "")
        water = scenes.sheet("Water", 3.0, 8, lambda x, y: 0.95, scenes.glass())
        self.refused("'Ball' lies in the water 'Water'", "Ball")
        water.location.z -= 0.4
        self.assertIn("'Ball' reaches into the water 'Water'", self.said())
        bpy.data.objects.remove(water)
        obj.data.materials[0] = scenes.glass("Other", INDEX)
        import bmesh
        mesh = bmesh.new()
        mesh.from_mesh(obj.data)
        bmesh.ops.delete(mesh, geom=mesh.faces[:20], context="FACES")
        mesh.to_mesh(obj.data)
        self.refused("'Ball' has holes", "Ball")
        self.assertIn("'Ball' has holes", self.said())


if __name__ == "__main__":
    unittest.main()
