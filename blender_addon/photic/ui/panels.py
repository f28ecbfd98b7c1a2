# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels in the 3D view's sidebar, and on objects and lights."""
import textwrap

import bpy

from .. import compat
from ..core import roles
from ..export import collect
from ..operators import job
from ..properties import method_options
from ..properties.things import ROLES
from . import graded

CHARACTERS_A_LINE = 30      # of the sidebar as it opens
CHARACTERS_AN_ICON = 4
ROLE_NAMES = {identifier: name for identifier, name, _ in ROLES}
ROLE_ICONS = {roles.REFRACTOR: "MOD_OCEAN", roles.MIRROR: "SHADING_RENDERED", roles.RECEIVER: "MESH_PLANE",
              roles.MOVABLE: "EMPTY_ARROWS", roles.BLOCKER: "MESH_CUBE", roles.IGNORE: "X"}
ROWS_SHOWN = 24


def paragraph(layout, text, icon="NONE"):
    width = CHARACTERS_A_LINE - (CHARACTERS_AN_ICON if icon != "NONE" else 0)
    for line_number, line in enumerate(row for part in text.split("\n") for row in textwrap.wrap(part, width)):
        layout.label(text=line, icon=icon if line_number == 0 else "BLANK1" if icon != "NONE" else "NONE")


class Sidebar:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Photic"


class PHOTIC_PT_bake(Sidebar, bpy.types.Panel):
    bl_label = "Bake"
    bl_idname = "PHOTIC_PT_bake"

    def draw(self, context):
        layout, settings = self.layout, context.scene.photic
        if job.current:
            words, fraction = job.current.words, job.current.fraction
            compat.show_progress(layout, fraction, words)
            layout.operator("photic.cancel", icon="CANCEL")
            return
        column = layout.column(align=True)
        row = column.row(align=True)
        row.scale_y = 1.4
        row.operator("photic.bake", icon="RENDER_STILL")
        row.operator("photic.bake", text="Frames", icon="RENDER_ANIMATION").animation = True
        row = column.row(align=True)
        row.operator("photic.validate", icon="CHECKMARK")
        row.operator("photic.estimate", icon="INFO")
        if settings.estimate:
            paragraph(layout, settings.estimate)
        if settings.forms:
            paragraph(layout, settings.forms, icon="MOD_OCEAN")
        if settings.light_errors:
            paragraph(layout, settings.light_errors)
        if settings.message:
            paragraph(layout.box(), settings.message, icon="ERROR")


class PHOTIC_PT_preview(Sidebar, bpy.types.Panel):
    bl_label = "Preview"
    bl_parent_id = "PHOTIC_PT_bake"

    def draw(self, context):
        layout, settings = self.layout, context.scene.photic
        layout.use_property_split = True
        row = layout.row(align=True)
        row.enabled = settings.volume is not None
        row.operator("photic.preview", text="Show", icon="HIDE_OFF", depress=settings.previewing).show = True
        row.operator("photic.preview", text="Hide", icon="HIDE_ON", depress=not settings.previewing).show = False
        layout.prop(settings, "strength")
        if compat.samples_grids():
            layout.prop(settings, "look_up")
        column = layout.column()
        column.use_property_split = False       # the sidebar is too narrow for a name and a box side by side
        column.prop(settings, "match_cycles")
        column.prop(settings, "show_medium")
        column.prop(settings, "preview_after_bake")
        row = layout.row(align=True)
        row.operator("photic.load", icon="FILE_REFRESH")
        row.operator("photic.remove", icon="TRASH")


class PHOTIC_PT_domain(Sidebar, bpy.types.Panel):
    bl_label = "Domain"
    bl_parent_id = "PHOTIC_PT_bake"

    def draw(self, context):
        layout, settings = self.layout, context.scene.photic
        layout.row().prop(settings, "domain_from", expand=True)
        layout.use_property_split = True
        if settings.domain_from == "CUSTOM":
            layout.prop(settings, "domain_min")
            layout.prop(settings, "domain_max")
        layout.operator("photic.fit_domain", icon="SHADING_BBOX")
        column = layout.column()
        column.use_property_split = False
        if settings.domain_from == "CUSTOM":
            column.prop(settings, "domain_shown")
        column.row().prop(settings, "size_by", expand=True)
        column.prop(settings, "resolution" if settings.size_by == "RESOLUTION" else "voxel_size")
        column.prop(settings, "shear")


class PHOTIC_PT_roles(Sidebar, bpy.types.Panel):
    bl_label = "Roles"
    bl_parent_id = "PHOTIC_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        shown = 0
        for obj in context.scene.objects:
            role = collect.role_of(obj)
            if obj.type not in collect.SHAPES or (role == roles.IGNORE and obj.photic.role == "AUTO"):
                continue
            if shown == ROWS_SHOWN:
                layout.label(text="More on the objects' own panels")
                break
            shown += 1
            row = layout.split(factor=0.5)
            row.label(text=obj.name, icon=ROLE_ICONS[role])
            text = f"{ROLE_NAMES[role]} (found)" if obj.photic.role == "AUTO" else None
            row.prop_menu_enum(obj.photic, "role", text=text or ROLE_NAMES[role])


class PHOTIC_PT_method(Sidebar, bpy.types.Panel):
    bl_label = "Method"
    bl_parent_id = "PHOTIC_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = self.layout, context.scene.photic
        layout.use_property_split = True
        layout.prop(settings, "method")
        for name in ("where", "band", "quadrature", "tolerance", "prefilter", "grid_caustic", "grid_arrival_time"):
            layout.prop(settings, name)
        methods = method_options.methods()
        chosen = next((m for m in methods if m.name == settings.method), methods[0] if methods else None)
        if chosen is None:
            layout.label(text="No baker: see the preferences", icon="ERROR")
            return
        options = getattr(settings, f"options_{chosen.name}")
        box = layout.box()
        box.label(text=f"Of {chosen.name}")
        for option in chosen.options:
            box.prop(options, option.name)


class PHOTIC_PT_medium(Sidebar, bpy.types.Panel):
    bl_label = "Medium"
    bl_parent_id = "PHOTIC_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = self.layout, context.scene.photic
        layout.row().prop(settings, "medium_from", expand=True)
        layout.use_property_split = True
        if settings.medium_from == "SCENE":
            for name in ("absorption", "scattering", "anisotropy"):
                layout.prop(settings, name)


class PHOTIC_PT_output(Sidebar, bpy.types.Panel):
    bl_label = "Output"
    bl_parent_id = "PHOTIC_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = self.layout, context.scene.photic
        layout.use_property_split = True
        layout.prop(settings, "folder")
        if settings.volume_file:
            layout.prop(settings, "volume_file")
            layout.prop(settings, "atlas_file")
        layout.operator("photic.export", icon="EXPORT")


class PHOTIC_PT_scene(bpy.types.Panel):
    """The same buttons for those who look for them among the scene's properties."""
    bl_label = "Photic"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "scene"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        PHOTIC_PT_bake.draw(self, context)
        PHOTIC_PT_domain.draw(self, context)


class PHOTIC_PT_object(bpy.types.Panel):
    bl_label = "Photic"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "object"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type in collect.SHAPES

    def draw(self, context):
        layout, obj = self.layout, context.object
        layout.use_property_split = True
        layout.prop(obj.photic, "role")
        role = collect.role_of(obj)
        if obj.photic.role == "AUTO":
            layout.label(text=f"Found: {ROLE_NAMES[role]}", icon=ROLE_ICONS[role])
        if role == roles.REFRACTOR:
            graded.draw(layout, obj)


class PHOTIC_PT_light(bpy.types.Panel):
    bl_label = "Photic"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.light is not None

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop(context.light.photic, "bake")


CLASSES = (PHOTIC_PT_bake, PHOTIC_PT_preview, PHOTIC_PT_domain, PHOTIC_PT_roles, PHOTIC_PT_method, PHOTIC_PT_medium,
           PHOTIC_PT_output, PHOTIC_PT_scene, PHOTIC_PT_object, PHOTIC_PT_light)
