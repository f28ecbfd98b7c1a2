# SPDX-License-Identifier: GPL-3.0-or-later
"""What the buttons do."""
import bpy

from . import bake, domain, kept_bakes, preview, scene_check

CLASSES = (bake.PHOTIC_OT_bake, bake.PHOTIC_OT_cancel, bake.PHOTIC_OT_load, bake.PHOTIC_OT_export,
           preview.PHOTIC_OT_preview, preview.PHOTIC_OT_remove,
           scene_check.PHOTIC_OT_validate, scene_check.PHOTIC_OT_estimate, domain.PHOTIC_OT_fit_domain)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    kept_bakes.register()


def unregister():
    bake.stop()
    kept_bakes.unregister()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
