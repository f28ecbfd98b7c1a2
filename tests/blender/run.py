# SPDX-License-Identifier: Apache-2.0
"""Inside Blender: installs the add-on from its zip, and runs test_NAME.py.

    blender -b --factory-startup --python-exit-code 1 -P tests/blender/run.py -- NAME ZIP [TEST]
"""
import importlib
import os
import pathlib
import shutil
import sys
import unittest

import bpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "examples" / "blender")]


def main(name, addon_zip, *chosen):
    scripts = pathlib.Path(os.environ["BLENDER_USER_SCRIPTS"])      # a folder of the test's own
    shutil.rmtree(scripts, ignore_errors=True)
    (scripts / "addons").mkdir(parents=True)
    out = pathlib.Path(os.environ["PHOTIC_TEST_OUT"])
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    bpy.ops.preferences.addon_install(filepath=addon_zip, overwrite=True)
    assert (scripts / "addons" / "photic" / "__init__.py").exists(), "the zip was not installed"
    module = importlib.import_module(f"test_{name}")
    loader = unittest.defaultTestLoader
    suite = loader.loadTestsFromNames(chosen, module) if chosen else loader.loadTestsFromModule(module)
    result = unittest.TextTestRunner(stream=sys.stdout, verbosity=2).run(suite)
    if not result.testsRun or not result.wasSuccessful():
        raise SystemExit(1)


main(*sys.argv[sys.argv.index("--") + 1:])
