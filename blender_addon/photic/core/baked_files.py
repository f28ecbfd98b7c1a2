# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of baked files: NAME_bake3.vdb, NAME_bake3.0001.vdb, and their atlases beside them.

Each bake has a number of its own: Blender keeps the grids of a path until it is closed, so that a new file of an old name is
not shown. A number that was given is not given again, even when its files are gone.
"""
import dataclasses
import os
import pathlib
import re
import shutil

_given = {}     # (folder, stem) -> the last number that this session has given


@dataclasses.dataclass(frozen=True)
class Bake:
    """All files of one bake."""
    folder: str
    stem: str
    number: int

    @property
    def name(self):
        return f"{self.stem}_bake{self.number}"

    def files(self):
        folder = pathlib.Path(self.folder)
        after = re.compile(re.escape(self.name) + r"(_[^.]*)?(\.\d+)?\.(vdb|exr|json|exr\.json)")
        return sorted(path for path in folder.glob(f"{self.name}*") if after.fullmatch(path.name)) if folder.is_dir() else []

    def remove(self):
        for path in self.files():
            try:
                path.unlink()
            except OSError:     # in use, or not ours to remove: it stays
                pass


def of(path):
    """The bake that a file is part of, or None."""
    path = pathlib.Path(path)
    found = re.fullmatch(r"(.+)_bake(\d+)(_[^.]*)?(\.\d+)?\.(vdb|exr|json|exr\.json)", path.name)
    return Bake(os.path.normpath(path.parent), found[1], int(found[2])) if found else None


def bakes(folder, stem):
    """The bakes of a stem that have files in a folder, oldest first."""
    folder = pathlib.Path(folder)
    found = {of(path) for path in folder.glob(f"{glob_escaped(stem)}_bake*")} if folder.is_dir() else set()
    return sorted((bake for bake in found if bake and bake.stem == stem), key=lambda bake: bake.number)


def glob_escaped(text):
    return re.sub(r"([*?[])", r"[\1]", text)


def following(folder, stem):
    """A bake whose number is larger than any that is there or was given."""
    key = (os.path.normpath(folder), stem)
    number = max([_given.get(key, 0)] + [bake.number for bake in bakes(folder, stem)]) + 1
    _given[key] = number
    return Bake(key[0], stem, number)


def newest(folder, stem):
    """The newest bake that has a volume, or None."""
    return next((bake for bake in reversed(bakes(folder, stem)) if any(p.suffix == ".vdb" for p in bake.files())), None)


def link_frames(before, bake):
    """Gives `bake` the volumes of `before` too, so that the baker finds those frames that have not changed."""
    for path in before.files():
        if path.suffix != ".vdb":
            continue
        target = path.with_name(bake.name + path.name[len(before.name):])
        try:
            os.link(path, target)
        except OSError:         # a file system without links
            shutil.copy2(path, target)
