# SPDX-License-Identifier: Apache-2.0
"""What needs no Blender: the baker as a process, scene text, meshes, sidecars and roles."""
import importlib
import json
import os
import stat
import sys
import time
import tomllib
import unittest

import numpy
import scenes
from support import BAKER, OUT

scenes.enable()
from photic.core import atlas, catalogue, mesh_file, process, program, roles, toml_text  # noqa: E402


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
