# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit the custom domain to the scene."""
import bpy

from ..core.program import BakerError
from . import bake, scene_check


class PHOTIC_OT_fit_domain(bpy.types.Operator):
    """Set the custom box to the automatic one, to start from"""
    bl_idname = "photic.fit_domain"
    bl_label = "Fit to the scene"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        settings = context.scene.photic
        before = settings.domain_from
        settings.domain_from = "AUTO"
        try:
            box = scene_check.estimate(context)["box"]
        except BakerError as error:
            settings.domain_from = before
            bake.show_error(self, context, error)
            return {"CANCELLED"}
        settings.domain_from = "CUSTOM"
        settings.domain_min, settings.domain_max = box["min"], box["max"]
        return {"FINISHED"}
