#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the zip that Blender installs: build_zip.py [FOLDER] [--baker BUNDLE]. Prints its path. The same files give the same bytes.

With --baker the zip carries the baker of BUNDLE (scripts/bundle), for Linux on x86-64, and is named so; otherwise the program
`photic` has to be installed.
"""
import argparse
import ast
import pathlib
import re
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ADDON = HERE / "photic"
NO_TIME = (1980, 1, 1, 0, 0, 0)     # the first that a zip can hold
KEPT = {".py", ".toml"}
PLATFORM = "linux-x64"              # as Blender's extensions call it
FILE, RUNNABLE = 0o100644, 0o100755


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


def contents(baker):
    """(name in the zip, bytes, mode) of each file."""
    for path in sorted(ADDON.rglob("*")):
        if path.suffix in KEPT and "__pycache__" not in path.parts and "bin" not in path.relative_to(ADDON).parts:
            data = path.read_bytes()
            if baker and path.name == "blender_manifest.toml":
                data = data.replace(b"\n[permissions]", f'platforms = ["{PLATFORM}"]\n\n[permissions]'.encode())
            yield f"photic/{path.relative_to(ADDON).as_posix()}", data, FILE
    yield "photic/LICENSE", (HERE / "LICENSE").read_bytes(), FILE
    for path in sorted(baker.rglob("*")) if baker else ():
        if path.is_file():
            yield f"photic/bin/{path.relative_to(baker).as_posix()}", path.read_bytes(), RUNNABLE if path.name == "photic" else FILE


def build(folder, baker=None):
    version = version_of_bl_info()
    if version != version_of_manifest():
        raise SystemExit(f"build_zip: bl_info says {version}, blender_manifest.toml {version_of_manifest()}; make them agree")
    if baker and not (baker / "photic").is_file():
        raise SystemExit(f"build_zip: there is no photic in '{baker}'; make it by scripts/bundle")
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / f"photic-{version}{'-' + PLATFORM if baker else ''}.zip"
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data, mode in contents(baker):
            entry = zipfile.ZipInfo(name, NO_TIME)
            entry.external_attr = mode << 16
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED)
    return target


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", nargs="?", default=".", type=pathlib.Path)
    parser.add_argument("--baker", type=pathlib.Path, help="a folder made by scripts/bundle")
    given = parser.parse_args()
    print(build(given.folder, given.baker))
