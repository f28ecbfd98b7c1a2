# SPDX-License-Identifier: Apache-2.0
"""From the zip to nothing left: bake, show, do it twice, save, reopen, undo, hide, remove, disable."""
import unittest

import addon_utils
import bpy
import numpy
import scenes
from support import ENGINES, OUT, contents, render, volumes_are_shown

scenes.enable()
from photic import compat  # noqa: E402
from photic.core import baked_files  # noqa: E402


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

    def state(self):
        """All that the preview changes."""
        water, scene = self.water.data.materials[0], self.scene
        eevee = {name: getattr(scene.eevee, name) for name in compat.SCENE_SEE_THROUGH if hasattr(scene.eevee, name)}
        cycles = {name: getattr(scene.cycles, name) for name in ("blur_glossy", "caustics_reflective", "volume_biased")
                  if hasattr(scene.cycles, name)}
        return (contents(), nodes_of(self.white), own_keys(self.white), nodes_of(water), getattr(water, compat.see_through(water)),
                bpy.data.lights["Sun"].cycles.use_multiple_importance_sampling, eevee, cycles)

    def test_nothing_is_left(self):
        sun = bpy.data.lights["Sun"]
        before = self.state()
        bare = scenes.sheet("Bare", 0.5, 1, lambda x, y: -0.9, smooth=False)
        with_bare = contents()
        self.assertEqual(bpy.ops.photic.bake(), {"FINISHED"})
        self.assertFalse(sun.cycles.use_multiple_importance_sampling)
        self.assertTrue(getattr(self.water.data.materials[0], compat.see_through(self.water.data.materials[0])))
        self.assertEqual(len(bare.data.materials), 1)
        self.assertNotEqual(nodes_of(self.white), before[1])
        thick = compat.thickness(next(n for n in self.water.data.materials[0].node_tree.nodes
                                      if n.bl_idname == "ShaderNodeOutputMaterial"))
        self.assertTrue(thick is None or thick.is_linked)
        bpy.ops.photic.preview(show=False)
        self.assertEqual(nodes_of(self.white), before[1])
        self.assertEqual(len(bare.data.materials), 0)
        bpy.ops.photic.preview(show=True)
        bpy.ops.photic.remove()
        self.assertEqual(contents(), with_bare)
        bpy.data.objects.remove(bare)
        bpy.data.meshes.remove(bpy.data.meshes["Bare"])
        self.assertEqual(self.state(), before)

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
        first = {engine: render(engine, 16)[..., :3] for engine in ENGINES}
        self.water.hide_render = bpy.data.objects["Sun"].hide_render = False
        bpy.data.lights["Sun"].energy = 6.0
        self.water.location.x = 0.4
        bpy.ops.photic.bake()
        self.water.hide_render = bpy.data.objects["Sun"].hide_render = True
        for engine in ENGINES:
            second = render(engine, 16)[..., :3]
            self.assertGreater(second.mean(), 1.7 * first[engine].mean(), engine)
            self.assertGreater(numpy.abs(second / second.mean() - first[engine] / first[engine].mean()).max(), 0.1, engine)

    def water_seen(self, engine):
        """The light in the water, from the side."""
        for obj in self.scene.objects:
            obj.hide_render = obj != self.scene.photic.volume
        if self.scene.camera is None:
            scenes.camera((0, -4, -0.5), (0, 0, -0.5), orthographic=1)
            self.scene.camera.data.clip_start, self.scene.camera.data.clip_end = 1.0, 8.0
        seen = render(engine, 32, samples=4)[..., :3]     # EEVEE's froxels are 8 pixels wide
        for obj in self.scene.objects:
            obj.hide_render = obj == self.scene.photic.volume
        return seen

    def test_a_new_bake_is_seen_in_the_water(self):
        settings = self.scene.photic
        settings.medium_from, settings.match_cycles = "SCENE", False
        for engine in ENGINES:
            if not volumes_are_shown(engine):
                print(f"skipped {engine}: it shows no volume grid here, a stock one neither")
                continue
            with self.subTest(engine):
                bpy.data.lights["Sun"].energy = 1.0
                bpy.ops.photic.bake()
                first, name = self.water_seen(engine), settings.volume.data.filepath
                self.assertGreater(first.mean(), 0.0)
                bpy.data.lights["Sun"].energy = 1.0
                settings.domain_from, settings.domain_min, settings.domain_max = "CUSTOM", (-1.2, -1.2, -1.1), (0.0, 1.2, 0.2)
                bpy.ops.photic.bake()   # half of the water is dark now
                second = self.water_seen(engine)
                self.assertNotEqual(settings.volume.data.filepath, name)
                self.assertLess(second[:, 26:].mean(), 0.1 * first[:, 26:].mean())
                self.assertGreater(second[:, :12].mean(), 0.3 * first[:, :12].mean())
                settings.domain_from = "AUTO"

    def test_older_bakes_go_when_nothing_refers_to_them(self):
        """The one that is shown, that to which undo leads and that of the saved file stay; the others go."""
        def there():
            return sorted({baked_files.of(path).number for path in OUT.glob("Scene_bake*")})
        for path in OUT.glob("Scene_bake*"):
            path.unlink()
        numbers = []
        for count in range(5):
            bpy.ops.photic.bake()
            numbers.append(baked_files.of(self.scene.photic.volume_file).number)
            self.assertEqual(there(), numbers[-2:])
            self.assertEqual(numbers, sorted(set(numbers)))
        path = str(OUT / "kept.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        for _ in range(3):
            bpy.ops.photic.bake()
            numbers.append(baked_files.of(bpy.path.abspath(bpy.context.scene.photic.volume_file)).number)
        self.assertEqual(there(), [numbers[4]] + numbers[-2:])
        bpy.ops.wm.open_mainfile(filepath=path)     # without having saved: what the file knew is there
        self.assertEqual(bpy.ops.photic.load(), {"FINISHED"})
        bpy.context.scene.photic.resolution = 24
        bpy.ops.photic.bake()
        bpy.ops.wm.save_mainfile()
        bpy.ops.photic.bake()
        self.assertNotIn(numbers[4], there())
        # Another file of the same folder, whose bake was removed, finds the newest.
        bpy.context.scene.photic.volume_file = str(OUT / "Scene_bake1.vdb")
        bpy.context.scene.photic.atlas_file = str(OUT / "Scene_bake1.exr.json")
        self.assertEqual(bpy.ops.photic.load(), {"FINISHED"})
        self.assertEqual(baked_files.of(bpy.context.scene.photic.volume_file).number, max(there()))

    def test_a_failed_bake_leaves_no_files(self):
        bpy.ops.photic.bake()
        before = sorted(path.name for path in OUT.glob("Scene_bake*"))
        self.scene.photic.domain_from = "CUSTOM"
        self.scene.photic.domain_min, self.scene.photic.domain_max = (-5e4,) * 3, (5e4,) * 3
        self.scene.photic.size_by, self.scene.photic.voxel_size = "VOXEL", 0.01
        with self.assertRaises(RuntimeError):
            bpy.ops.photic.bake()
        self.assertEqual(sorted(path.name for path in OUT.glob("Scene_bake*")), before)

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
        had_nodes = compat.shader_tree(plain) is not None     # since 5.0 every material has
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
        self.assertIsNotNone(compat.shader_tree(plain))
        bpy.ops.photic.preview(show=False)
        self.assertEqual(compat.shader_tree(plain) is not None, had_nodes)
        self.assertEqual(nodes_of(mixed), mixed_before)
        self.assertEqual(own_keys(mixed), [])
