# SPDX-License-Identifier: Apache-2.0
"""Glass bodies, mirrors and lamps: what reaches the baker, what it makes of it, and what Cycles shows."""
import math
import pathlib
import tomllib
import unittest

import bpy
import numpy
import scenes
from mathutils import Vector
from support import OUT, baker, picture, render

scenes.enable()
from photic.export import collect, lights, write  # noqa: E402
from photic.properties import method_options  # noqa: E402

RADIUS, CENTRE, INDEX = 0.3, (0.0, 0.0, 0.5), 1.5


def ball(name, radius, centre, made_of):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=radius, location=centre)
    obj = bpy.context.object
    obj.name = name
    obj.data.polygons.foreach_set("use_smooth", [True] * len(obj.data.polygons))
    obj.data.materials.append(made_of)
    return obj


def lamp(kind, place, towards, energy):
    data = bpy.data.lights.new(kind, kind)
    data.energy = energy
    obj = bpy.data.objects.new(kind, data)
    obj.location = place
    obj.rotation_euler = Vector(towards).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(obj)
    return obj


def floor(size=2.0):
    white = scenes.material("Floor", Base_Color=(0.8, 0.8, 0.8, 1.0), Roughness=1.0, Specular=0.0)
    return scenes.sheet("Floor", size, 1, lambda x, y: 0.0, white, smooth=False)


def scene_now():
    bpy.context.view_layer.update()
    return collect.collect(bpy.context.evaluated_depsgraph_get())


def tables():
    settings = bpy.context.scene.photic
    return tomllib.loads(str(write.scene_text(settings, scene_now(), OUT, method_options.methods())))


class Written(unittest.TestCase):
    def setUp(self):
        scenes.empty()
        floor()
        scenes.sun()

    def test_a_body_has_an_inside(self):
        made = scenes.glass("Glass", INDEX)
        tree = made.node_tree
        absorption = tree.nodes.new("ShaderNodeVolumeAbsorption")
        absorption.inputs["Color"].default_value = (1.0, 0.5, 0.25, 1.0)
        absorption.inputs["Density"].default_value = 2.0
        out = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputMaterial")
        tree.links.new(absorption.outputs[0], out.inputs["Volume"])
        ball("Ball", RADIUS, CENTRE, made)
        scene = tables()
        surface, medium = scene["surface"][0], scene["medium"][0]
        self.assertEqual((surface["event"], surface["inside"]), ("both", medium["name"]))
        self.assertAlmostEqual(medium["ior"], INDEX, 6)
        numpy.testing.assert_allclose(medium["absorption"], (0.0, 1.0, 1.5), atol=1e-6)

    def tumbler(self, auto_smooth):
        """A cylinder about z, shaded smooth: round over its rims, or with sharp ones."""
        bpy.ops.mesh.primitive_cylinder_add(vertices=48, radius=RADIUS, depth=0.2, location=CENTRE, rotation=(0.5, 0, 0))
        obj = bpy.context.object
        obj.scale = (1.0, 2.0, -1.0)    # stretched and mirrored
        obj.data.materials.append(scenes.glass("Glass", INDEX))
        obj.data.polygons.foreach_set("use_smooth", [True] * len(obj.data.polygons))
        if not auto_smooth:
            return obj
        if hasattr(obj.data, "use_auto_smooth"):
            obj.data.use_auto_smooth, obj.data.auto_smooth_angle = True, math.radians(30)
        else:
            obj.data.set_sharp_from_angle(angle=math.radians(30))
        return obj

    def test_sharp_edges_stay_sharp(self):
        obj = self.tumbler(auto_smooth=True)
        surface = tables()["surface"][0]
        self.assertNotIn("smooth", surface)
        mesh = scene_now().of("REFRACTOR")[0].mesh
        turned = numpy.array(obj.matrix_world.to_3x3())
        up = numpy.linalg.inv(turned).T @ (0, 0, 1)
        up /= numpy.linalg.norm(up)
        along = numpy.abs(mesh.normals.reshape(-1, 3) @ up)
        caps = along > 0.999
        self.assertEqual(int(caps.sum()), 2 * 46 * 3, "all corners of the caps, and they alone, face along the axis")
        a, b, c = (mesh.positions[mesh.triangles[:, i]] for i in range(3))
        faces = numpy.cross(b - a, c - a)
        self.assertGreater((faces[:, None] * mesh.normals).sum(axis=2).min(), 0, "outwards, like the triangles")
        header = (pathlib.Path(OUT) / surface["file"]).read_bytes().split(b"end_header")[0].decode()
        self.assertIn("property double nz", header)
        self.assertEqual(scene_now().notes, [])

    def test_round_rims_stay_round(self):
        mesh = self.tumbler(auto_smooth=False).data
        self.assertTrue(tables()["surface"][0]["smooth"])
        mesh.polygons.foreach_set("use_smooth", [False] * len(mesh.polygons))
        mesh.update()
        self.assertFalse(tables()["surface"][0]["smooth"])

    def test_the_smaller_body_is_what_is_there(self):
        ball("Tumbler", 0.4, CENTRE, scenes.glass("Glass", 1.5))
        ball("Drink", 0.35, CENTRE, scenes.glass("Drink", 1.35))
        ball("Bubble", 0.1, CENTRE, scenes.glass("Air", 1.0))
        priority = {m["name"]: m["priority"] for m in tables()["medium"]}
        self.assertLess(priority["inside of Tumbler"], priority["inside of Drink"])
        self.assertLess(priority["inside of Drink"], priority["inside of Bubble"])

    def test_glass_in_the_water(self):
        scenes.sheet("Water", 4.0, 32, lambda x, y: 1.5, scenes.glass())
        ball("Ball", RADIUS, CENTRE, scenes.glass("Glass", INDEX))
        scene = tables()
        water = next(s for s in scene["surface"] if s["name"] == "Water")
        self.assertEqual((water["inside"], water["event"]), ("water", "refract"))
        self.assertAlmostEqual(next(m for m in scene["medium"] if m["name"] == "water")["ior"], scenes.IOR, 5)

    def test_dispersion(self):
        """Three coloured glasses that are added, and an Abbe number."""
        made = scenes.glass("Prism", 1.5)
        tree = made.node_tree
        out = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputMaterial")
        sums = [tree.nodes.new("ShaderNodeAddShader") for _ in range(2)]
        iors = (1.51, 1.52, 1.54)
        parts = [tree.nodes.new("ShaderNodeBsdfGlass") for _ in iors]
        for channel, (node, ior) in enumerate(zip(parts, iors)):
            node.inputs["Color"].default_value = [float(i == channel) for i in range(3)] + [1.0]
            node.inputs["IOR"].default_value, node.inputs["Roughness"].default_value = ior, 0.0
        tree.links.new(parts[2].outputs[0], sums[0].inputs[0])
        tree.links.new(parts[0].outputs[0], sums[0].inputs[1])
        tree.links.new(sums[0].outputs[0], sums[1].inputs[0])
        tree.links.new(parts[1].outputs[0], sums[1].inputs[1])
        tree.links.new(sums[1].outputs[0], out.inputs["Surface"])
        obj = ball("Prism", RADIUS, CENTRE, made)
        scene = scene_now()
        numpy.testing.assert_allclose(tables()["medium"][0]["ior"], iors, atol=1e-6)
        self.assertEqual([note for _, note in scene.notes if "tinted" in note or "indices" in note], [])
        obj.data.materials[0] = scenes.glass("Flint", 1.62)
        obj.photic.abbe = 36.0
        numpy.testing.assert_allclose(tables()["medium"][0]["abbe"], (1.62, 36.0), atol=1e-5)

    def test_a_mirror_has_its_colour(self):
        gold = scenes.material("Gold", Metallic=1.0, Roughness=0.0, Base_Color=(1.0, 0.8, 0.3, 1.0))
        ball("Ball", RADIUS, CENTRE, gold)
        surface = tables()["surface"][0]
        self.assertEqual(surface["event"], "mirror")
        numpy.testing.assert_allclose(surface["colour"], (1.0, 0.8, 0.3), atol=1e-6)

    def test_lamps(self):
        ball("Ball", RADIUS, CENTRE, scenes.glass("Glass", INDEX))
        spot = lamp("SPOT", (0, 0, 2), (0, 0, -1), 100.0)
        spot.data.spot_size, spot.data.spot_blend, spot.data.shadow_soft_size = math.radians(30), 0.25, 0.0
        point = lamp("POINT", (1, 0, 2), (0, 0, -1), 50.0)
        point.data.shadow_soft_size = 0.1
        area = lamp("AREA", (0, 1, 2), (0, 0, -1), 40.0)
        area.data.shape, area.data.size, area.data.size_y = "RECTANGLE", 0.5, 0.25
        dark = lamp("POINT", (1, 1, 2), (0, 0, -1), 0.0)
        dark.name = "Dark"
        by_type = {table["type"]: table for table in tables()["light"]}
        self.assertEqual(sorted(by_type), ["point", "rectangle", "spot", "sun"])
        self.assertAlmostEqual(by_type["spot"]["angle"], 30.0, 4)
        self.assertAlmostEqual(by_type["spot"]["blend"], 0.25, 6)
        numpy.testing.assert_allclose(by_type["rectangle"]["size"], (0.5, 0.25))
        self.assertAlmostEqual(by_type["rectangle"]["power"], 40 * scenes.compat().area_share(), 5)
        said = " | ".join(words for _, words in scene_now().notes)
        self.assertIn("'POINT' is baked from its middle", said)
        self.assertIn("'Dark' is not baked", said)
        self.assertNotIn("'SPOT'", said)
        spot.data.photic.bake = "NO"
        self.assertNotIn("spot", {table["type"] for table in tables()["light"]})


class Lamps(unittest.TestCase):
    def test_watts_are_what_cycles_takes_them_for(self):
        """Irradiance of a white floor a metre below: what Cycles renders, against what the table says."""
        for kind in ("POINT", "SPOT", "AREA"):
            scenes.empty()
            floor(0.2)
            light = lamp(kind, (0, 0, 1), (0, 0, -1), 30.0)
            if kind == "AREA":
                light.data.size = 0.02
            else:
                light.data.shadow_soft_size = 0.005
            bpy.context.view_layer.update()
            scenes.camera((0, 0.5, 0.5), (0, 0, 0), orthographic=0.02)
            radiance = render("CYCLES", 8, samples=64)[..., :3].mean()
            table = lights.table(light, [])
            intensity = table["power"] / (math.pi if kind == "AREA" else 4 * math.pi)
            self.assertAlmostEqual(radiance * math.pi / 0.8 / intensity, 1.0, delta=0.01, msg=kind)


class Baked(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = scenes.empty()
        floor()
        scenes.sun(energy=3.0, angle_deg=0.0, direction=(0, 0, -1))
        ball("Ball", RADIUS, CENTRE, scenes.glass("Glass", INDEX))
        settings = cls.scene.photic
        settings.size_by, settings.voxel_size = "VOXEL", 1 / 48
        settings.domain_from = "CUSTOM"
        settings.domain_min, settings.domain_max = (-0.6, -0.6, -0.1), (0.6, 0.6, 0.85)
        settings.folder = str(OUT)
        assert bpy.ops.photic.bake() == {"FINISHED"}
        cls.settings = settings

    def floor_map(self):
        """E [W/m2] of 240 x 240 texels over the floor's middle."""
        scene_file = OUT / "floor.toml"
        scene_file.write_text('photic = 1\n[domain]\nmin = [-0.6, -0.6, -0.1]\nmax = [0.6, 0.6, 0.85]\n[[light]]\ntype = "sun"\n'
                              'direction = [0, 0, -1]\n[[surface]]\nflat = true\nsize = [1, 1]\ncenter = [0, 0, 5]\n[[object]]\n'
                              'name = "floor"\nplane = { point = [0, 0, 0] }\n')
        volume = bpy.path.abspath(self.settings.volume_file)
        baker("picture", scene_file, volume, "--receiver", "floor", "--resolution", 240, "-o", OUT, "--progress=none")
        return picture(OUT / f"{pathlib.Path(volume).stem}_floor.exr")[..., 0]

    def test_light_comes_through_and_is_gathered(self):
        """Power within radii on the floor, against Snell's and Fresnel's laws for rays through a ball that refract twice."""
        energy = self.floor_map()
        side = 1.2 / energy.shape[0]
        y, x = (numpy.indices(energy.shape) + 0.5) * side - 0.6
        radius = numpy.hypot(x, y)
        height = numpy.linspace(0, 1, 200001)[1:-1] * RADIUS
        i, r = numpy.arcsin(height / RADIUS), numpy.arcsin(height / RADIUS / INDEX)
        parallel = (numpy.tan(i - r) / numpy.tan(i + r)) ** 2
        across = (numpy.sin(i - r) / numpy.sin(i + r)) ** 2
        share = ((1 - parallel) ** 2 + (1 - across) ** 2) / 2
        turned = 2 * (i - r)        # towards the axis; it leaves the ball where the normal is turned - i off the way down
        out = numpy.stack([-RADIUS * numpy.sin(turned - i), CENTRE[2] - RADIUS * numpy.cos(turned - i)])
        landing = numpy.where(turned < math.pi / 2, out[0] - out[1] * numpy.tan(turned), numpy.inf)
        for within in (0.15, 0.2, RADIUS):
            inside = numpy.abs(landing) < within
            wanted = 3.0 * 2 * math.pi * (share * height * inside).sum() * (height[1] - height[0])
            found = energy[radius < within].sum() * side * side
            self.assertAlmostEqual(found / wanted, 1.0, delta=0.02, msg=within)
        self.assertGreater(energy[radius < 0.06].mean(), 5 * 3.0)

    def test_cycles_shows_it(self):
        scenes.camera((0, 0, 0.12), (0, 0, 0), orthographic=0.8)
        shown = render("CYCLES", 48, samples=16, bounces=4)[..., 0] * math.pi / 0.8
        middle, rim = shown[20:28, 20:28].mean(), shown[:3].mean()
        self.assertGreater(middle, 5 * 3.0)
        self.assertLess(abs(rim / 3.0 - 1), 0.1)       # the sun itself, beside the ball's shadow


if __name__ == "__main__":
    unittest.main()
