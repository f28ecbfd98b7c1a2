# SPDX-License-Identifier: Apache-2.0
"""From the zip to nothing left: bake, show, do it twice, save, reopen, undo, hide, remove, disable."""
import unittest

import addon_utils
import bpy
import numpy
import scenes
from support import OUT, contents, render


def quick(scene):
    settings = scene.photic
    settings.folder, settings.resolution = str(OUT), 32
    settings.options_beams.disc = "off"


def own_keys(material):
    """Custom properties, without those that Cycles keeps there for itself."""
    return [key for key in material.keys() if key != "cycles"]


def nodes_of(material):
    """A material as text: nodes, links and values."""
    tree = material.node_tree
    return (sorted((n.bl_idname, n.name, tuple(n.location)) for n in tree.nodes),
            sorted((l.from_node.name, l.from_socket.name, l.to_node.name, l.to_socket.name) for l in tree.links))


class Life(unittest.TestCase):
    def setUp(self):
        self.scene, self.water, self.floor = scenes.pool(waves=24, floor_depth=1.0)
        quick(self.scene)
        self.white = self.floor.data.materials[0]

    def test_versions_agree(self):
        import photic
        path = photic.__file__.replace("__init__.py", "blender_manifest.toml")
        self.assertIn('version = "%d.%d.%d"' % photic.bl_info["version"], open(path, encoding="utf-8").read())

    def test_nothing_is_left(self):
        sun = bpy.data.lights["Sun"]
        before = contents(), nodes_of(self.white), sun.cycles.use_multiple_importance_sampling, \
            self.scene.eevee.use_ssr, self.water.data.materials[0].use_screen_refraction, own_keys(self.white)
        bare = scenes.sheet("Bare", 0.5, 1, lambda x, y: -0.9, smooth=False)
        with_bare = contents()
        self.assertEqual(bpy.ops.photic.bake(), {"FINISHED"})
        self.assertFalse(sun.cycles.use_multiple_importance_sampling)
        self.assertTrue(self.water.data.materials[0].use_screen_refraction)
        self.assertEqual(len(bare.data.materials), 1)
        self.assertNotEqual(nodes_of(self.white), before[1])
        bpy.ops.photic.preview(show=False)
        self.assertEqual(nodes_of(self.white), before[1])
        self.assertEqual(len(bare.data.materials), 0)
        bpy.ops.photic.preview(show=True)
        bpy.ops.photic.remove()
        self.assertEqual(contents(), with_bare)
        bpy.data.objects.remove(bare)
        bpy.data.meshes.remove(bpy.data.meshes["Bare"])
        after = contents(), nodes_of(self.white), sun.cycles.use_multiple_importance_sampling, \
            self.scene.eevee.use_ssr, self.water.data.materials[0].use_screen_refraction, own_keys(self.white)
        self.assertEqual(after, before)

    def test_twice_is_once(self):
        bpy.ops.photic.bake()
        once = contents(), nodes_of(self.white)
        bpy.ops.photic.preview(show=True)
        bpy.ops.photic.bake()
        self.assertEqual((contents(), nodes_of(self.white)), once)

    def test_save_and_reopen(self):
        bpy.ops.photic.bake()
        shown = nodes_of(self.white)
        path = str(OUT / "saved.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
        scene = bpy.context.scene
        white = bpy.data.materials["Floor"]
        self.assertEqual(nodes_of(white), shown)
        self.assertTrue(scene.photic.previewing)
        scenes.camera((0, 0, -0.5), (0, 0, -1), orthographic=1)
        for obj in (bpy.data.objects["Water"], bpy.data.objects["Sun"]):
            obj.hide_render = True
        self.assertGreater(render("CYCLES", 16)[..., :3].min(), 0.1)
        bpy.ops.photic.preview(show=False)
        self.assertEqual(render("CYCLES", 16)[..., :3].max(), 0.0)
        bpy.ops.photic.remove()
        self.assertFalse([g.name for g in bpy.data.node_groups if "Photic" in g.name])

    def test_a_new_bake_is_seen(self):
        """Blender keeps volumes and pictures of a path in memory: the second bake must replace them."""
        bpy.ops.photic.bake()
        self.water.hide_render = bpy.data.objects["Sun"].hide_render = True
        scenes.camera((0, 0, -0.5), (0, 0, -1), orthographic=1)
        first = render("CYCLES", 16)[..., :3]
        self.water.hide_render = bpy.data.objects["Sun"].hide_render = False
        bpy.data.lights["Sun"].energy = 6.0
        self.water.location.x = 0.4
        bpy.ops.photic.bake()
        self.water.hide_render = bpy.data.objects["Sun"].hide_render = True
        second = render("CYCLES", 16)[..., :3]
        self.assertGreater(second.mean(), 1.7 * first.mean())
        self.assertGreater(numpy.abs(second / second.mean() - first / first.mean()).max(), 0.1)

    def test_undo(self):
        before = nodes_of(self.white)
        bpy.ops.ed.undo_push(message="before")
        self.assertEqual(bpy.ops.photic.bake("EXEC_DEFAULT", True), {"FINISHED"})
        if not bpy.ops.ed.undo.poll():
            self.skipTest("this Blender keeps no undo steps in background mode")
        bpy.ops.ed.undo()
        self.assertEqual(nodes_of(bpy.data.materials["Floor"]), before)
        self.assertNotIn("Scene light", bpy.data.objects)
        bpy.ops.ed.redo()
        self.assertNotEqual(nodes_of(bpy.data.materials["Floor"]), before)

    def test_disable_and_enable(self):
        bpy.ops.photic.bake()
        shown = nodes_of(self.white)
        addon_utils.disable("photic")
        self.assertFalse(hasattr(bpy.types.Scene, "photic"))
        self.assertEqual([name for name in dir(bpy.types) if name.upper().startswith("PHOTIC")], [])
        self.assertEqual(nodes_of(self.white), shown)   # what was shown still renders without the add-on
        scenes.enable()
        self.assertTrue(bpy.context.scene.photic.previewing)
        self.assertIsNotNone(bpy.context.scene.photic.volume)

    def test_materials_keep_what_they_were(self):
        """No nodes, mixes, textures, two outputs: wrapped and unwrapped without a trace."""
        made = []
        plain = bpy.data.materials.new("No nodes")
        plain.diffuse_color = (0.1, 0.5, 0.9, 1.0)
        made.append(plain)
        mixed = scenes.material("Mixed")
        tree = mixed.node_tree
        mix, diffuse, noise = (tree.nodes.new(k) for k in ("ShaderNodeMixShader", "ShaderNodeBsdfDiffuse", "ShaderNodeTexNoise"))
        out, principled = tree.nodes["Material Output"], tree.nodes["Principled BSDF"]
        tree.links.new(noise.outputs["Color"], principled.inputs["Base Color"])
        tree.links.new(principled.outputs[0], mix.inputs[1])
        tree.links.new(diffuse.outputs[0], mix.inputs[2])
        tree.links.new(mix.outputs[0], out.inputs["Surface"])
        second = tree.nodes.new("ShaderNodeOutputMaterial")
        second.target = "CYCLES"
        tree.links.new(diffuse.outputs[0], second.inputs["Surface"])
        made.append(mixed)
        for number, material in enumerate(made):
            scenes.sheet(f"Thing {number}", 0.3, 1, lambda x, y: -0.8, material, smooth=False)
        mixed_before = nodes_of(mixed)
        bpy.ops.photic.bake()
        self.assertTrue(plain.use_nodes)
        bpy.ops.photic.preview(show=False)
        self.assertFalse(plain.use_nodes)
        self.assertEqual(nodes_of(mixed), mixed_before)
        self.assertEqual(own_keys(mixed), [])
