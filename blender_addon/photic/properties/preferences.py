# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's preferences: where the baker is."""
import os

import bpy

from ..core import catalogue, program

ADDON = __package__.rpartition(".")[0]      # the folder's name, or bl_ext.….photic where add-ons are extensions


def _baker_changed(_preferences, _context):
    from . import refresh
    refresh()


class PhoticPreferences(bpy.types.AddonPreferences):
    bl_idname = ADDON

    program: bpy.props.StringProperty(
        name="Baker", subtype="FILE_PATH", update=_baker_changed,
        description="The program 'photic', if another is to bake than the add-on's own; empty: $PHOTIC_PROGRAM, the one that "
                    "came with the add-on, or the search path")
    threads: bpy.props.IntProperty(name="Threads", min=0, max=1024, description="That a bake uses; 0: all cores")

    def draw(self, _context):
        layout = self.layout
        layout.prop(self, "program")
        layout.prop(self, "threads")
        try:
            layout.label(text=f"Bakes with {program.find(self.program)}", icon="CHECKMARK")
        except program.BakerError as error:
            layout.label(text=str(error), icon="ERROR")


def get():
    """The preferences, or None when the add-on runs without being enabled in them (tests, scripts)."""
    addon = bpy.context.preferences.addons.get(ADDON)
    return addon.preferences if addon else None


def baker():
    """Path of the baker. Raises BakerError."""
    preferences = get()
    return program.find(bpy.path.abspath(preferences.program) if preferences else "")


def threads():
    preferences = get()
    return preferences.threads if preferences else 0


def methods():
    """The catalogue of the baker that is set."""
    preferences = get()
    cache = os.path.join(bpy.utils.user_resource("CONFIG"), "photic", "methods.json")
    return catalogue.load(bpy.path.abspath(preferences.program) if preferences else "", cache)
