# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist sets, on the scene, objects, lights and in the preferences."""
import bpy

from .. import compat
from . import graded, method_options, preferences, things
from . import scene as scene_settings


def register():
    bpy.utils.register_class(preferences.PhoticPreferences)
    compat.register()
    graded.register()
    things.register()
    method_options.register()
    scene_settings.register()


def unregister():
    scene_settings.unregister()
    method_options.unregister()
    things.unregister()
    graded.unregister()
    compat.unregister()
    bpy.utils.unregister_class(preferences.PhoticPreferences)


def refresh():
    """After the baker has changed: its catalogue's properties anew. Values in the file stay, Blender keeps them by name."""
    scene_settings.unregister()
    method_options.unregister()
    method_options.register()
    scene_settings.register()
