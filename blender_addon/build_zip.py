#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the zip that Blender installs: build_zip.py [FOLDER]. Prints its path. The same sources give the same bytes."""
import ast
import pathlib
import re
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ADDON = HERE / "photic"
NO_TIME = (1980, 1, 1, 0, 0, 0)     # the first that a zip can hold
KEPT = {".py", ".toml"}


def version_of_bl_info():
    tree = ast.parse((ADDON / "__init__.py").read_text(encoding="utf-8"))
    for node in tree.body:
        if isinstance(node, ast.Assign) and node.targets[0].id == "bl_info":
            return ".".join(map(str, ast.literal_eval(node.value)["version"]))
    raise SystemExit("build_zip: photic/__init__.py has no bl_info")


def version_of_manifest():
    found = re.search(r'^version = "([^"]+)"', (ADDON / "blender_manifest.toml").read_text(encoding="utf-8"), re.M)
    if not found:
        raise SystemExit("build_zip: blender_manifest.toml has no version")
    return found[1]


def build(folder):
    version = version_of_bl_info()
    if version != version_of_manifest():
        raise SystemExit(f"build_zip: bl_info says {version}, blender_manifest.toml {version_of_manifest()}; make them agree")
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / f"photic-{version}.zip"
    files = [path for path in sorted(ADDON.rglob("*")) if path.suffix in KEPT and "__pycache__" not in path.parts]
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, name in [(p, f"photic/{p.relative_to(ADDON).as_posix()}") for p in files] + [(HERE / "LICENSE", "photic/LICENSE")]:
            archive.writestr(zipfile.ZipInfo(name, NO_TIME), path.read_bytes(), zipfile.ZIP_DEFLATED)
    return target


if __name__ == "__main__":
    print(build(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")))
