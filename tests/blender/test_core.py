# SPDX-License-Identifier: Apache-2.0
"""What needs no Blender: the baker as a process, scene text, meshes, sidecars and roles."""
import importlib
import json
import os
import pathlib
import shutil
import stat
import sys
import time
import tomllib
import types
import unittest
import zipfile

import numpy
import scenes
from support import BAKER, OUT

scenes.enable()
from photic import compat  # noqa: E402
from photic.core import atlas, baked_files, catalogue, mesh_file, process, program, roles, toml_text, words  # noqa: E402


def script(name, text):
    """A baker that does as it is told."""
    path = OUT / name
    path.write_text(f"#!{sys.executable if os.path.isfile(sys.executable) else '/usr/bin/env python3'}\n{text}")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


def wait_for(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


class Packages(unittest.TestCase):
    def test_core_imports_no_blender(self):
        folder = os.path.dirname(importlib.import_module("photic.core").__file__)
        for name in os.listdir(folder):
            if name.endswith(".py"):
                self.assertNotIn("bpy", open(os.path.join(folder, name), encoding="utf-8").read(), name)


class SceneText(unittest.TestCase):
    def test_names_survive(self):
        names = ['plain', 'with "quotes"', "back\\slash", "tab\tand\nline", "水面 Ü", "a\x7fb"]
        text = toml_text.SceneText()
        for name in names:
            text.add("[[object]]", {"name": name, "scale": 1e-9, "n": 3, "on": True, "none": None, "at": [1.0, -2.5e30],
                                    "plane": {"point": [0, 0, 1]}}, name)
        read = tomllib.loads(str(text))
        self.assertEqual([o["name"] for o in read["object"]], names)
        self.assertEqual(read["object"][0]["at"], [1.0, -2.5e30])
        self.assertIs(read["object"][0]["on"], True)
        self.assertNotIn("none", read["object"][0])

    def test_lines_know_their_owner(self):
        text = toml_text.SceneText()
        text.add("[domain]", {"resolution": 4})
        text.add("[[surface]]", {"name": "a", "b": 1}, "Sea: 1")
        text.add("[bake]", {"method": "auto"})
        line = str(text).splitlines().index("b = 1") + 1
        self.assertEqual(text.owner_of(f"folder.toml/x.toml:{line}:5"), "Sea: 1")
        self.assertEqual(text.owner_of("x.toml:3"), "")
        self.assertEqual(text.owner_of(f"x.toml:{line + 4}"), "")
        self.assertEqual(text.owner_of("--set"), "")

    def test_numbers_of_numpy(self):
        """Since numpy 2 their repr names their type, and an ocean's size is one."""
        table = {"a": numpy.float64(12.5), "b": numpy.float32(0.5), "c": numpy.int64(3), "d": [numpy.float64(-1e-9)]}
        text = toml_text.SceneText()
        text.add("[domain]", table)
        self.assertEqual(tomllib.loads(str(text))["domain"], table)

    def test_infinities_are_refused(self):
        for value in (float("nan"), float("inf")):
            with self.assertRaises(ValueError):
                toml_text.value_text(value)


class MeshFile(unittest.TestCase):
    def test_written_once(self):
        points = numpy.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.5]])
        triangles = numpy.array([[0, 1, 2]])
        name = mesh_file.write_ply(OUT, points, triangles)
        first = (OUT / name).stat().st_mtime_ns
        self.assertEqual(mesh_file.write_ply(OUT, points, triangles), name)
        self.assertEqual((OUT / name).stat().st_mtime_ns, first)
        self.assertNotEqual(mesh_file.write_ply(OUT, points + 1e-12, triangles), name)
        self.assertFalse(list(OUT.glob("*.part")))


class Words(unittest.TestCase):
    def test_what_only_the_command_line_knows(self):
        said = words.plain("'Sea_scene/f76d8d703e1be2ec.ply' is closed; leave it open, or set event = \"reflect\"")
        self.assertEqual(said, "its mesh is closed; leave it open, or choose the role Mirror")
        self.assertEqual(words.plain("use voxel_size = 0.5"), "use Voxel size 0.5")
        self.assertEqual(words.plain("'rocks.ply' is damaged"), "'rocks.ply' is damaged")


class BakedFiles(unittest.TestCase):
    def setUp(self):
        self.folder = OUT / "bakes"
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir()

    def write(self, *names):
        for name in names:
            (self.folder / name).write_text(name)

    def test_a_number_is_given_once(self):
        self.assertEqual(baked_files.following(self.folder, "Sea [1]").name, "Sea [1]_bake1")
        second = baked_files.following(self.folder, "Sea [1]")
        self.assertEqual(second.name, "Sea [1]_bake2")      # even if nothing of the first is there
        self.write("Sea [1]_bake7.0003.vdb")
        self.assertEqual(baked_files.following(self.folder, "Sea [1]").number, 8)
        self.assertEqual(baked_files.following(self.folder, "Sea").number, 1)

    def test_whose_file(self):
        for name in ("Sea_bake3.vdb", "Sea_bake3.0004.exr", "Sea_bake3_rgb.exr", "Sea_bake3_rgb.0004.exr", "Sea_bake3.json",
                     "Sea_bake3.0004.exr.json"):
            self.assertEqual(baked_files.of(self.folder / name).number, 3, name)
        for name in ("Sea.vdb", "Sea_bake.vdb", "Sea_bake3.png", "Sea_bake3.vdb.part"):
            self.assertIsNone(baked_files.of(self.folder / name), name)

    def test_only_its_own_files_are_removed(self):
        own = ["Sea_bake1.vdb", "Sea_bake1.json", "Sea_bake1.exr.json", "Sea_bake1.exr", "Sea_bake1_rgb.exr", "Sea_bake1.0002.vdb"]
        others = ["Sea_bake11.vdb", "Sea_bake1.txt", "Sea_bake1.bak.vdb", "Deep_Sea_bake1.vdb", "Sea_bake2.vdb"]
        self.write(*own, *others)
        baked_files.Bake(str(self.folder), "Sea", 1).remove()
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), sorted(others))
        self.assertEqual(baked_files.newest(self.folder, "Sea").number, 11)

    def test_frames_are_there_under_both_names(self):
        self.write("Sea_bake1.0001.vdb", "Sea_bake1.0001.exr")
        bake = baked_files.Bake(str(self.folder), "Sea", 2)
        baked_files.link_frames(baked_files.Bake(str(self.folder), "Sea", 1), bake)
        self.assertEqual([path.name for path in bake.files()], ["Sea_bake2.0001.vdb"])
        bake.remove()
        self.assertEqual((self.folder / "Sea_bake1.0001.vdb").read_text(), "Sea_bake1.0001.vdb")


class Baker(unittest.TestCase):
    def test_missing(self):
        with self.assertRaisesRegex(program.BakerError, "missing"):
            program.find(str(OUT / "nothing"))
        before = {name: os.environ[name] for name in ("PHOTIC_PROGRAM", "PATH")}
        try:
            os.environ["PHOTIC_PROGRAM"], os.environ["PATH"] = "", str(OUT)
            with self.assertRaisesRegex(program.BakerError, "not found"):
                program.find()
        finally:
            os.environ.update(before)

    def test_a_zip_may_carry_its_baker(self):
        """Found by itself, and made runnable, which unzipping by Blender forgets; the preferences and the environment override."""
        sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "blender_addon"))
        build_zip = importlib.import_module("build_zip")
        bundle = OUT / "bundle"
        (bundle / "lib").mkdir(parents=True)
        (bundle / "photic").write_text("#!/bin/sh\n")
        (bundle / "lib" / "libz.so.1").write_text("z")
        with self.assertRaisesRegex(SystemExit, "no photic"):
            build_zip.build(OUT, bundle / "lib")
        with zipfile.ZipFile(build_zip.build(OUT, bundle)) as archive:
            self.assertEqual(archive.getinfo("photic/bin/photic").external_attr >> 16, 0o100755)
            self.assertEqual(archive.read("photic/bin/lib/libz.so.1"), b"z")
            self.assertEqual(tomllib.loads(archive.read("photic/blender_manifest.toml").decode())["platforms"], ["linux-x64"])
            target = pathlib.Path(program.__file__).parents[1] / "bin" / program.NAME
            self.assertEqual(program.carried(), "")
            target.parent.mkdir()
            target.write_bytes(archive.read("photic/bin/photic"))
            target.chmod(0o644)
        kept = os.environ.pop("PHOTIC_PROGRAM")
        try:
            self.assertEqual(program.find(), str(target))
            self.assertTrue(os.access(target, os.X_OK))
            self.assertEqual(program.find(BAKER), BAKER)
            os.environ["PHOTIC_PROGRAM"] = BAKER
            self.assertEqual(program.find(), BAKER)
        finally:
            os.environ["PHOTIC_PROGRAM"] = kept
            shutil.rmtree(target.parent)
        with zipfile.ZipFile(build_zip.build(OUT)) as archive:
            self.assertNotIn("platforms", tomllib.loads(archive.read("photic/blender_manifest.toml").decode()))

    def test_catalogue_is_the_bakers(self):
        document = program.ask(BAKER, "methods", "--json")
        methods = catalogue.parse(document)
        self.assertEqual([m.name for m in methods], [m["name"] for m in document["methods"]])
        with self.assertRaisesRegex(program.BakerError, "one release"):
            catalogue.parse({"schema": "photic-methods-9"})

    def test_catalogue_is_kept(self):
        cache = OUT / "kept" / "methods.json"
        self.assertEqual(catalogue.load(str(OUT / "nothing"), cache), ())
        self.assertTrue(catalogue.load(BAKER, cache))
        self.assertEqual(catalogue.load(str(OUT / "nothing"), cache), catalogue.load(BAKER, cache))
        cache.write_text("{")
        self.assertEqual(catalogue.load(str(OUT / "nothing"), cache), ())

    def test_refusals_are_in_words(self):
        with self.assertRaisesRegex(program.BakerError, "nothing.toml"):
            program.ask(BAKER, "bake", "nothing.toml", "--dry-run", "--json", "--progress=json")
        with self.assertRaisesRegex(program.BakerError, "other than JSON"):
            program.ask(script("chatty", "print('hello')"), "methods")


class Runs(unittest.TestCase):
    def test_progress_and_done(self):
        run = process.Run(script("good", "import sys, json\n"
                                 "for e in ({'event': 'progress', 'stage': 'trace', 'fraction': 1, 'overall': 0.5, 'eta_s': 2},\n"
                                 "          {'event': 'warning', 'message': 'careful'}, {'event': 'done', 'output': 'x', 'report': {}}):\n"
                                 "    print(json.dumps(e), file=sys.stderr)\n"))
        self.assertTrue(wait_for(run.poll))
        self.assertEqual((run.stage, run.eta_s, run.warnings, run.done["output"]), ("trace", 2, ["careful"], "x"))
        self.assertIsNone(run.error)
        self.assertFalse(run.cancelled)

    def test_a_crash_keeps_its_last_words(self):
        run = process.Run(script("bad", "import sys\nprint('out of luck', file=sys.stderr)\nsys.exit(4)"))
        run.wait()
        self.assertIn("out of luck", str(run.error))
        silent = process.Run(script("silent", "import os\nos._exit(9)"))
        silent.wait()
        self.assertIn("exit code 9", str(silent.error))

    def test_cancel_ends_even_the_deaf(self):
        seconds = process.SECONDS_TO_END
        process.SECONDS_TO_END = 0.3
        try:
            for name, text in (("polite", "import time\ntime.sleep(60)"),
                               ("deaf", "import signal, sys, time\nsignal.signal(signal.SIGTERM, signal.SIG_IGN)\n"
                                        "print('{\"event\": \"progress\", \"stage\": \"deaf\"}', file=sys.stderr, flush=True)\ntime.sleep(60)")):
                run = process.Run(script(name, text))
                if name == "deaf":
                    self.assertTrue(wait_for(lambda: run.poll() or run.stage == "deaf"))
                run.cancel()
                self.assertTrue(wait_for(run.poll), name)
                self.assertTrue(run.cancelled)
                self.assertIsNone(run.error)
        finally:
            process.SECONDS_TO_END = seconds

    def test_not_a_program(self):
        (OUT / "text").write_text("no program")
        (OUT / "text").chmod(0o755)
        with self.assertRaises(program.BakerError):
            process.Run(str(OUT / "text"))


class Sidecars(unittest.TestCase):
    def test_errors_are_in_words(self):
        with self.assertRaisesRegex(program.BakerError, "bake again"):
            atlas.read(OUT / "none.json")
        bad = OUT / "bad.json"
        for text in ("", "[]", "{}", json.dumps({"photic_atlas": 1})):
            bad.write_text(text)
            with self.assertRaisesRegex(program.BakerError, "no atlas"):
                atlas.read(bad)
        bad.write_text(json.dumps({"photic_atlas": 2}))
        with self.assertRaisesRegex(program.BakerError, "version 2"):
            atlas.read(bad)


class Roles(unittest.TestCase):
    def test_rules(self):
        def role(**values):
            return roles.role_of(roles.Optics(**values))
        self.assertEqual(role(refract=1.0), roles.REFRACTOR)
        self.assertEqual(role(refract=0.4, diffuse=0.6), roles.RECEIVER)
        self.assertEqual(role(mirror=1.0), roles.MIRROR)
        self.assertEqual(role(mirror=1.0, roughness=0.5), roles.RECEIVER)
        self.assertEqual(roles.role_of(None), roles.RECEIVER)
        self.assertEqual(roles.role_of(None, is_water=True), roles.REFRACTOR)


class Renamed(unittest.TestCase):
    """What 4.x and 5.x call otherwise, on stand-ins that have the new names only, or the old ones only."""

    def test_versions(self):
        for version, late, shader in (((3, 4, 1), True, "3D_UNIFORM_COLOR"), ((4, 0, 0), True, "UNIFORM_COLOR"),
                                      ((4, 3, 2), True, "UNIFORM_COLOR"), ((5, 0, 0), False, "UNIFORM_COLOR")):
            self.assertEqual(compat.half_voxel_late(version), late, version)
            self.assertEqual(compat.line_shader(version), shader, version)
            self.assertEqual(compat.samples_grids(version), version >= (5, 0, 0))

    def test_sockets_of_groups_since_4_0(self):
        class Interface:
            items_tree = ()

            def new_socket(self, name, in_out, socket_type):
                item = types.SimpleNamespace(name=name, in_out=in_out, socket_type=socket_type, item_type="SOCKET")
                self.items_tree += (item,)
                return item

            def clear(self):
                self.items_tree = ()
        tree = types.SimpleNamespace(interface=Interface())     # no .inputs and .outputs: using them is an error
        compat.add_socket(tree, "INPUT", "NodeSocketFloat", "Anisotropy", 0.5)
        compat.add_socket(tree, "OUTPUT", "NodeSocketShader", "Volume")
        tree.interface.items_tree += (types.SimpleNamespace(name="A panel", item_type="PANEL"),)
        self.assertEqual(tree.interface.items_tree[0].default_value, 0.5)
        self.assertEqual(compat.socket_names(tree, "INPUT"), ["Anisotropy"])
        self.assertEqual(compat.socket_names(tree, "OUTPUT"), ["Volume"])
        compat.clear_sockets(tree)
        self.assertEqual(compat.socket_names(tree, "INPUT"), [])

    def test_marks_where_nodes_have_no_custom_properties(self):
        class Node:
            photic_made = False

            def keys(self):
                raise TypeError("bpy_struct.keys(): this type doesn't support IDProperties")

            def __setitem__(self, key, value):
                raise TypeError("bpy_struct[key] = val: id properties not supported for this type")
        node = Node()
        self.assertFalse(compat.is_marked(node))
        compat.mark(node)
        self.assertTrue(compat.is_marked(node))
        material = {}
        self.assertFalse(compat.is_marked(material))
        compat.mark(material)
        self.assertTrue(compat.is_marked(material))

    def test_settings(self):
        name = types.SimpleNamespace
        for cycles, wanted in ((name(emission_sampling="AUTO"), ("emission_sampling", "NONE")),
                               (name(sample_as_light=True), ("sample_as_light", False))):
            self.assertEqual(compat.quiet_emission(name(cycles=cycles)), [(cycles, *wanted)])
        self.assertEqual(compat.quiet_emission(name()), [])
        self.assertEqual(compat.see_through(name(use_raytrace_refraction=False)), "use_raytrace_refraction")
        for version, wanted in (((3, 4, 1), "BLENDER_EEVEE"), ((4, 1, 1), "BLENDER_EEVEE"), ((4, 2, 0), "BLENDER_EEVEE_NEXT"),
                                ((4, 5, 9), "BLENDER_EEVEE_NEXT"), ((5, 0, 0), "BLENDER_EEVEE"), ((5, 2, 2), "BLENDER_EEVEE")):
            self.assertEqual(compat.eevee_engine(version), wanted)
        tree = object()
        self.assertIsNone(compat.shader_tree(name(node_tree=tree, use_nodes=False)))
        self.assertIs(compat.shader_tree(name(node_tree=tree, use_nodes=True)), tree)
        self.assertIs(compat.shader_tree(name(node_tree=tree)), tree)       # as in 6.0
        self.assertIsNone(compat.shader_tree(name(node_tree=None, use_nodes=True)))
        light = name(use_nodes=False)
        compat.switch_nodes(light, True)
        self.assertTrue(light.use_nodes)
        compat.switch_nodes(object(), True)                 # nothing to switch
        for names in (("Transmission",), ("Transmission Weight",)):
            self.assertEqual(compat.socket({names[0]: 7}, "Transmission"), 7)
        self.assertIsNone(compat.socket({"Fac": 1}, "Transmission"))
        self.assertEqual(compat.see_through(name(use_screen_refraction=False)), "use_screen_refraction")

    def test_lights(self):
        name = types.SimpleNamespace
        self.assertAlmostEqual(compat.area_share((3, 6, 9)), 0.785398, 6)
        self.assertEqual(compat.area_share((4, 0, 0)), 1.0)
        old = name(energy=3.0, color=(1.0, 0.5, 0.25))
        self.assertEqual(compat.light_level(old), [3.0, 1.5, 0.75])
        new = name(energy=3.0, color=(1.0, 0.5, 0.25), exposure=1.0, use_temperature=True, temperature_color=(1.0, 0.5, 2.0))
        self.assertEqual(compat.light_level(new), [6.0, 1.5, 3.0])
        new.use_temperature = False
        self.assertEqual(compat.light_level(new), [6.0, 3.0, 1.5])
        self.assertTrue(compat.is_normalized(old))
        self.assertFalse(compat.is_normalized(name(normalize=False)))

    def test_progress(self):
        drawn = []
        compat.show_progress(types.SimpleNamespace(progress=lambda factor, text: drawn.append((factor, text))), 0.5, "half")
        compat.show_progress(types.SimpleNamespace(label=lambda text, icon: drawn.append(text)), 0.5, "half")
        self.assertEqual(drawn, [(0.5, "half"), "half"])

    def test_names_are_asked_for_in_one_place(self):
        """No other file compares versions or looks for what was renamed."""
        folder = pathlib.Path(importlib.import_module("photic").__file__).parent
        for path in folder.rglob("*.py"):
            if path.name != "compat.py":
                self.assertNotRegex(path.read_text(encoding="utf-8"), r"app\.version|\.interface\b|use_screen_refraction|"
                                    r"\.use_nodes|BLENDER_EEVEE|Transmission Weight|\"Fac\"|\.normalize\b", path.name)
