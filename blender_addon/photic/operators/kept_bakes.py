# SPDX-License-Identifier: GPL-3.0-or-later
"""Removes bakes that nothing refers to any more: no scene, volume or picture of the open file, none of the file as it was last
saved or opened, and not the bake before the last one, to which undo leads."""
import bpy
from bpy.app.handlers import persistent

from ..core import baked_files

_seen = set()       # bakes that this session has made or met: no others are removed
_saved = {}         # a .blend's path -> the bakes that it refers to on disk


def _referred():
    paths = [path for scene in bpy.data.scenes for path in (scene.photic.volume_file, scene.photic.atlas_file)]
    paths += [item.filepath for item in (*bpy.data.volumes, *bpy.data.images)]
    return {bake for bake in (baked_files.of(bpy.path.abspath(path)) for path in paths if path) if bake}


def made(bake, before=None):
    """After `bake` took the place of `before`: older ones go."""
    _seen.add(bake)
    kept = _referred().union({bake, before}, *_saved.values())
    for old in [old for old in _seen if old not in kept]:
        old.remove()
        _seen.discard(old)


@persistent
def _file_is_on_disk(*_):
    if bpy.data.filepath:
        _saved[bpy.data.filepath] = _referred()
    _seen.update(_referred())


def register():
    bpy.app.handlers.load_post.append(_file_is_on_disk)
    bpy.app.handlers.save_post.append(_file_is_on_disk)


def unregister():
    for handlers in (bpy.app.handlers.load_post, bpy.app.handlers.save_post):
        if _file_is_on_disk in handlers:
            handlers.remove(_file_is_on_disk)
    _seen.clear()
    _saved.clear()
