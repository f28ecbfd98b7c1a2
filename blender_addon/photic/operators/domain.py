# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit the custom domain to the scene."""
import bpy

from ..core.program import BakerError
from ..export import collect
from . import bake


class PHOTIC_OT_fit_domain(bpy.types.Operator):
    """Set the custom box to the automatic one, to start from"""
    bl_idname = "photic.fit_domain"
    bl_label = "Fit to the scene"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        settings = context.scene.photic
        box = collect.automatic_domain(collect.collect(context.evaluated_depsgraph_get()), settings.resolution)
        if box is None:
            bake.show_error(self, context, BakerError("Nothing in the scene bends light; there is nothing to fit a box to"))
            return {"CANCELLED"}
        settings.domain_from = "CUSTOM"
        settings.domain_min, settings.domain_max = box[0].tolist(), box[1].tolist()
        return {"FINISHED"}
