# SPDX-License-Identifier: GPL-3.0-or-later
"""Preview on and off, and Remove."""
import bpy

from ..core.program import BakerError
from . import bake, preview_state


class PHOTIC_OT_preview(bpy.types.Operator):
    """Show the baked light on receivers and in the water, or take it away again"""
    bl_idname = "photic.preview"
    bl_label = "Preview"
    bl_options = {"REGISTER", "UNDO"}

    show: bpy.props.BoolProperty(name="Show", default=True, options={"SKIP_SAVE"})

    def execute(self, context):
        try:
            if self.show:
                for words in preview_state.show(context):
                    self.report({"WARNING"}, words)
            else:
                preview_state.hide(context)
        except BakerError as error:
            bake.show_error(self, context, error)
            return {"CANCELLED"}
        return {"FINISHED"}


class PHOTIC_OT_remove(bpy.types.Operator):
    """Remove the light volume, its node groups and everything else of Photic's from the scene; baked files stay"""
    bl_idname = "photic.remove"
    bl_label = "Remove"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        preview_state.remove(context)
        return {"FINISHED"}
