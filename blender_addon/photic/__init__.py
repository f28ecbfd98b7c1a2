# SPDX-License-Identifier: GPL-3.0-or-later
"""Photic: bakes caustics into light volumes and shows them on every receiver and in the water."""
bl_info = {
    "name": "Photic",
    "author": "The Photic authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Photic",
    "description": "Bakes caustics into light volumes; shows them on every receiver and in the water, without noise",
    "category": "Render",
}

try:
    import bpy
except ImportError:     # tests of core/ run without Blender
    bpy = None

if bpy is not None:
    from . import operators, properties, ui

    def register():
        properties.register()
        operators.register()
        ui.register()

    def unregister():
        ui.unregister()
        operators.unregister()
        properties.unregister()
