# SPDX-License-Identifier: Apache-2.0
"""What is read from materials, lights, objects and instances, and what is said about the rest."""
import math
import unittest

import bpy
import numpy
import scenes
from mathutils import Matrix
from support import OUT

scenes.enable()
from photic.core import roles  # noqa: E402
from photic.export import collect, lights, materials, write  # noqa: E402
from photic.operators import scene_check  # noqa: E402
from photic.properties import method_options  # noqa: E402


def shader(kind, **inputs):
    """A material of one shader node."""
    made = scenes.with_nodes(bpy.data.materials.new(kind))
    tree = made.node_tree
    tree.nodes.clear()
    node = tree.nodes.new(kind)
    for name, value in inputs.items():
        scenes.compat().socket(node.inputs, name.replace("_", " ")).default_value = value
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], out.inputs["Surface"])
    return made, tree, node, out


def scene_now():
    return collect.collect(bpy.context.evaluated_depsgraph_get())


def words(scene):
    return " | ".join(note for _, note in scene.notes)


class Materials(unittest.TestCase):
    def setUp(self):
        scenes.empty()

    def test_single_shaders(self):
        for kind, inputs, role, ior in (
                ("ShaderNodeBsdfGlass", {"IOR": 1.5}, roles.REFRACTOR, 1.5),
                ("ShaderNodeBsdfRefraction", {"IOR": 1.33, "Roughness": 0.0}, roles.REFRACTOR, 1.33),
                ("ShaderNodeBsdfGlossy", {"Roughness": 0.05}, roles.MIRROR, None),
                ("ShaderNodeBsdfGlossy", {"Roughness": 0.6}, roles.RECEIVER, None),
                ("ShaderNodeBsdfDiffuse", {}, roles.RECEIVER, None),
                ("ShaderNodeEmission", {}, roles.RECEIVER, None),
                ("ShaderNodeBsdfPrincipled", {"Transmission": 1.0, "IOR": 1.4, "Roughness": 0.0}, roles.REFRACTOR, 1.4),
                ("ShaderNodeBsdfPrincipled", {"Metallic": 1.0, "Roughness": 0.1}, roles.MIRROR, None),
                ("ShaderNodeBsdfPrincipled", {}, roles.RECEIVER, None)):
            optics = materials.inspect(shader(kind, **inputs)[0])
            self.assertEqual(roles.role_of(optics), role, (kind, inputs))
            if ior:
                self.assertAlmostEqual(optics.ior, ior, 5)

    def test_mixes_groups_and_reroutes(self):
        made, tree, glass, out = shader("ShaderNodeBsdfGlass", IOR=1.4)
        diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
        mix = tree.nodes.new("ShaderNodeMixShader")
        reroute = tree.nodes.new("NodeReroute")
        mix.inputs[0].default_value = 0.3
        tree.links.new(glass.outputs[0], mix.inputs[1])
        tree.links.new(diffuse.outputs[0], mix.inputs[2])
        tree.links.new(mix.outputs[0], reroute.inputs[0])
        tree.links.new(reroute.outputs[0], out.inputs["Surface"])
        optics = materials.inspect(made)
        self.assertAlmostEqual(optics.refract, 0.7, 5)
        self.assertAlmostEqual(optics.diffuse, 0.3, 5)
        group = bpy.data.node_groups.new("inner", "ShaderNodeTree")
        group.outputs.new("NodeSocketShader", "Shader") if hasattr(group, "outputs") else group.interface.new_socket(
            "Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
        inner, inner_out = group.nodes.new("ShaderNodeBsdfRefraction"), group.nodes.new("NodeGroupOutput")
        inner.inputs["IOR"].default_value = 1.7
        group.links.new(inner.outputs[0], inner_out.inputs[0])
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        tree.links.new(node.outputs[0], out.inputs["Surface"])
        self.assertAlmostEqual(materials.inspect(made).ior, 1.7, 5)

    def test_nothing_is_lost_in_silence(self):
        made, tree, glass, _ = shader("ShaderNodeBsdfGlass", Roughness=0.1, Color=(0.2, 0.9, 0.9, 1.0))
        noise = tree.nodes.new("ShaderNodeTexNoise")
        tree.links.new(noise.outputs[0], glass.inputs["IOR"])
        said = " ".join(materials.inspect(made).notes)
        for word in ("textured IOR", "tinted", "roughness 0.1"):
            self.assertIn(word, said)
        hair, *_ = shader("ShaderNodeBsdfHair")
        self.assertIn("not understood", " ".join(materials.inspect(hair).notes))

    def test_roughness_and_tint_are_named(self):
        """What a new Principled with Transmission is: grey, and rough."""
        made, _, node, _ = shader("ShaderNodeBsdfPrincipled", Transmission=1.0)
        node.inputs["Roughness"].default_value = 0.5
        node.inputs["Base Color"].default_value = (0.8, 0.8, 0.8, 1.0)
        optics = materials.inspect(made)
        self.assertEqual(roles.role_of(optics), roles.RECEIVER)
        self.assertAlmostEqual(roles.too_rough(optics), 0.5, 6)
        self.assertIn("grey: its Base Color is 0.8 0.8 0.8", " ".join(optics.notes))
        node.inputs["Base Color"].default_value = (0.1, 0.8, 0.9, 1.0)
        self.assertIn("tinted: its Base Color is 0.1 0.8 0.9", " ".join(materials.inspect(made).notes))
        node.inputs["Roughness"].default_value = 0.0
        node.inputs["Base Color"].default_value = (1.0, 1.0, 1.0, 1.0)
        optics = materials.inspect(made)
        self.assertEqual((optics.notes, roles.too_rough(optics)), ([], 0.0))
        scenes.sheet("Sea", 2.0, 4, lambda x, y: 0.0, made)
        scenes.sun()
        node.inputs["Roughness"].default_value = 0.5
        said = scene_now()
        self.assertIn("'Sea' lets light through, but with Roughness 0.5", words(said))
        with self.assertRaisesRegex(write.BakerError, "bends light: 'Sea' lets .* Roughness 0.5"):
            write.scene_text(bpy.context.scene.photic, said, OUT, ())
        bpy.data.objects["Sea"].photic.role = "REFRACTOR"       # as the artist wishes
        self.assertNotIn("no caustics", words(scene_now()))

    def test_waves_that_are_only_shaded_are_named(self):
        """Bump, normal maps and displacement, at the shader or at a group around it: the bake would be of flat water."""
        def bumped(kind, into, socket="Normal"):
            made, tree, glass, out = shader("ShaderNodeBsdfGlass")
            bump = tree.nodes.new(kind)
            if kind == "ShaderNodeBump":
                tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs[0], bump.inputs["Height"])
            tree.links.new(bump.outputs[0], (glass if into == "glass" else out).inputs[socket])
            return made, tree, glass, bump
        for kind, word in (("ShaderNodeBump", "has a Bump"), ("ShaderNodeNormalMap", "has a Normal Map")):
            self.assertIn(word, " ".join(materials.inspect(bumped(kind, "glass")[0]).notes))
        for kind in ("ShaderNodeDisplacement", "ShaderNodeVectorDisplacement"):
            self.assertIn("has a Displacement", " ".join(materials.inspect(bumped(kind, "out", "Displacement")[0]).notes))
        made, tree, glass, _ = bumped("ShaderNodeBump", "glass")
        geometry = tree.nodes.new("ShaderNodeNewGeometry")
        tree.links.new(geometry.outputs["Normal"], glass.inputs["Normal"])       # the mesh's own: nothing is lost
        self.assertEqual(materials.inspect(made).notes, [])
        made, tree, _, out = shader("ShaderNodeBsdfDiffuse")
        tree.links.new(tree.nodes.new("ShaderNodeBump").outputs[0], tree.nodes["Diffuse BSDF"].inputs["Normal"])
        self.assertEqual(materials.inspect(made).notes, [])     # receivers are lit by their own normals
        scenes.sheet("Sea", 2.0, 4, lambda x, y: 0.0, bumped("ShaderNodeBump", "glass")[0])
        self.assertIn("the material of 'Sea': 'Glass BSDF' has a Bump", words(scene_now()))

    def test_media(self):
        made, tree, _, out = shader("ShaderNodeBsdfGlass")
        absorb, scatter = tree.nodes.new("ShaderNodeVolumeAbsorption"), tree.nodes.new("ShaderNodeVolumeScatter")
        absorb.inputs["Density"].default_value, absorb.inputs["Color"].default_value = 2.0, (0.5, 0.75, 1.0, 1.0)
        scatter.inputs["Density"].default_value, scatter.inputs["Color"].default_value = 0.5, (1.0, 0.5, 0.0, 1.0)
        scatter.inputs["Anisotropy"].default_value = 0.6
        both = tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(absorb.outputs[0], both.inputs[0])
        tree.links.new(scatter.outputs[0], both.inputs[1])
        tree.links.new(both.outputs[0], out.inputs["Volume"])
        medium = materials.inspect(made).medium
        numpy.testing.assert_allclose(medium.absorption, (1.0, 0.5, 0.0), atol=1e-6)
        numpy.testing.assert_allclose(medium.scattering, (0.5, 0.25, 0.0), atol=1e-6)
        self.assertAlmostEqual(medium.anisotropy, 0.6, 5)


class Things(unittest.TestCase):
    def setUp(self):
        self.scene, self.water, self.floor = scenes.pool(waves=8)

    def test_roles_are_found_and_can_be_changed(self):
        self.assertEqual(collect.role_of(self.water), roles.REFRACTOR)
        self.assertEqual(collect.role_of(self.floor), roles.RECEIVER)
        self.floor.photic.role = "MOVABLE"
        self.assertEqual(collect.role_of(self.floor), roles.MOVABLE)
        self.assertEqual({i.role for i in scene_now().items}, {roles.REFRACTOR, roles.MOVABLE})
        self.floor.photic.role = "IGNORE"
        self.assertEqual(len(scene_now().items), 1)

    def test_an_ocean_is_water_without_a_material(self):
        self.water.data.materials.clear()
        self.water.modifiers.new("Ocean", "OCEAN").resolution = 3
        self.assertEqual(collect.role_of(self.water), roles.REFRACTOR)
        scene = scene_now()
        self.assertAlmostEqual(scene.of(roles.REFRACTOR)[0].optics.ior, 1.333)
        self.assertIn("viewport's resolution", words(scene))

    def test_modifiers_and_transforms_are_applied(self):
        self.floor.modifiers.new("Subsurf", "SUBSURF").levels = 2
        self.floor.location, self.floor.scale = (1, 2, 3), (2, -1, 1)
        bpy.context.view_layer.update()
        item = scene_now().of(roles.RECEIVER)[0]
        self.assertEqual(len(item.mesh.triangles), 32)
        numpy.testing.assert_allclose(item.mesh.positions.mean(axis=0), (1, 2, 1.5), atol=1e-5)
        self.assertGreater(item.mesh.mean_normal()[2], 0, "a mirroring scale turned the mesh inside out")

    def test_instances_are_baked_each(self):
        collection = bpy.data.collections.new("Rocks")
        rock = scenes.sheet("Rock", 0.2, 1, lambda x, y: -1.0, smooth=False)
        self.scene.collection.objects.unlink(rock)
        collection.objects.link(rock)
        for at in (-0.5, 0.5):
            empty = bpy.data.objects.new("Instance", None)
            empty.instance_type, empty.instance_collection, empty.location.x = "COLLECTION", collection, at
            self.scene.collection.objects.link(empty)
        bpy.context.view_layer.update()
        rocks = [item for item in scene_now().items if item.object_name == "Rock"]
        self.assertEqual(sorted(item.name for item in rocks), ["Rock", "Rock #2"])
        self.assertEqual(sorted(round(float(item.mesh.positions[:, 0].mean()), 3) for item in rocks), [-0.5, 0.5])

    def test_water_upside_down_is_turned(self):
        self.water.data.flip_normals()
        scene = scene_now()
        self.assertGreater(scene.of(roles.REFRACTOR)[0].mesh.mean_normal()[2], 0)
        self.assertIn("away from the light", words(scene))

    def test_suns(self):
        bpy.context.view_layer.update()
        sun = bpy.data.objects["Sun"]
        notes = []
        table = lights.table(sun, notes)
        numpy.testing.assert_allclose(table["direction"], (0.433, 0.25, -0.866), atol=1e-4)
        self.assertAlmostEqual(table["irradiance"], 3.0)
        self.assertAlmostEqual(table["angular_diameter"], 0.53, 5)
        sun.data.color, sun.data.angle = (1, 0.5, 0.25), math.radians(20)
        table = lights.table(sun, notes)
        numpy.testing.assert_allclose(table["irradiance"], (3.0, 1.5, 0.75))
        self.assertIn("20.0 degrees", notes[0])

    def test_lights_with_nodes_of_their_own(self):
        sun, notes = bpy.data.objects["Sun"], []
        lights.table(sun, notes)
        self.assertEqual(notes, [])
        scenes.with_nodes(sun.data)     # which newer ones have done by themselves
        lights.table(sun, notes)
        self.assertEqual(notes, [])
        tree = sun.data.node_tree
        next(n for n in tree.nodes if n.bl_idname == "ShaderNodeEmission").inputs["Strength"].default_value = 2.0
        lights.table(sun, notes)
        self.assertIn("nodes of the light 'Sun'", notes[0])

    def test_lamps_that_are_taken_out_are_named(self):
        lamp = bpy.data.objects.new("Bulb", bpy.data.lights.new("Bulb", "AREA"))
        self.scene.collection.objects.link(lamp)
        bpy.context.view_layer.update()
        self.assertIn("rectangle", {table["type"] for _, table in scene_now().lights})
        lamp.data.photic.bake = "NO"
        scene = scene_now()
        self.assertIn("area light 'Bulb' is not baked", words(scene))
        self.assertEqual(len(scene.lights), 1)

    def test_hidden_things(self):
        self.floor.hide_set(True)
        bpy.context.view_layer.update()
        self.assertIn("hidden in the viewport", words(scene_now()))
        self.floor.hide_render = True
        self.assertEqual(words(scene_now()), "")

    def test_options_that_were_set_are_written(self):
        settings = self.scene.photic
        settings.options_beams.mesh = 77
        settings.options_photons.sampling = "random"
        text = str(write.scene_text(settings, scene_now(), OUT, method_options.methods()))
        self.assertIn("[bake.beams]\nmesh = 77\n", text)
        self.assertIn('[bake.photons]\nsampling = "random"\n', text)
        self.assertNotIn("disc", text.split("[bake.beams]")[1])

    def test_domain_is_cropped_to_the_pool_but_not_to_a_fish(self):
        def box():
            found = scene_check.estimate(bpy.context)["box"]
            return found["min"], found["max"]

        self.scene.photic.resolution = 128
        low, high = box()
        numpy.testing.assert_allclose((low[0], high[0]), (-1.047, 1.047), atol=2e-3)
        self.assertLess(low[2], -1.5 - 2 * 2 / 128)
        self.floor.photic.role = "MOVABLE"
        low, high = box()
        self.assertLess(low[0], -2.0)
        self.assertEqual(bpy.ops.photic.fit_domain(), {"FINISHED"})
        settings = self.scene.photic
        self.assertEqual(settings.domain_from, "CUSTOM")
        numpy.testing.assert_allclose(settings.domain_min, low, rtol=1e-5)
        numpy.testing.assert_allclose(settings.domain_max, high, rtol=1e-5)


class Catalogue(unittest.TestCase):
    def test_every_option_is_a_property(self):
        scene = scenes.empty()
        for method in method_options.methods():
            group = getattr(scene.photic, f"options_{method.name}")
            for option in method.options:
                self.assertIn(option.name, group.bl_rna.properties, method.name)
                value = getattr(group, option.name)
                if option.type == "number":
                    self.assertAlmostEqual(value, option.default, 6)
                else:
                    self.assertEqual(value, option.default)
        for method in method_options.methods():
            scene.photic.method = method.name
            self.assertEqual(scene.photic.method, method.name)
