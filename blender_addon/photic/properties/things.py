# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of single objects and lights."""
import bpy

from ..core import roles
from . import graded

ROLES = (
    ("AUTO", "Automatic", "From the material: water, glass or transmission bends light, smooth metal mirrors it"),
    (roles.REFRACTOR, "Refractor", "Water or glass: light goes through and is bent"),
    (roles.MIRROR, "Mirror", "Smooth metal: light is reflected"),
    (roles.RECEIVER, "Receiver", "Light falls on it and ends there"),
    (roles.MOVABLE, "Movable receiver", "Light falls on it, but it casts no shadow into the bake: move it as you like"),
    (roles.BLOCKER, "Blocker", "Casts a shadow, and shows no light"),
    (roles.IGNORE, "Ignored", "Takes no part in the bake"),
)


class PhoticObject(bpy.types.PropertyGroup):
    role: bpy.props.EnumProperty(name="Role", items=ROLES, default="AUTO",
                                 description="What the object is to the bake")
    surface: bpy.props.EnumProperty(
        name="Surface", default="AUTO", description="What water is baked as",
        items=(("AUTO", "Automatic", "A smooth height field where the mesh is a regular grid, otherwise the mesh"),
               ("MESH", "Mesh", "The mesh as it is, with its normals")))
    ior: bpy.props.FloatProperty(name="Refractive index", min=0.0, max=5.0, precision=4,
                                 description="0: from the material (1.333 for an Ocean without a material that bends light)")
    abbe: bpy.props.FloatProperty(name="Abbe number", min=0.0, max=200.0, precision=1,
                                  description="How little a glass parts the colours: 59 crown glass, 36 flint glass, 55 diamond. "
                                              "0: it parts none")
    graded: bpy.props.PointerProperty(type=graded.PhoticGraded)


class PhoticLight(bpy.types.PropertyGroup):
    bake: bpy.props.EnumProperty(
        name="Bake", default="AUTO", description="Whether the light's caustics are baked",
        items=(("AUTO", "Automatic", "Every light that shines is"), ("YES", "Yes", ""), ("NO", "No", "It casts no baked caustics")))


def register():
    for group, owner in ((PhoticObject, bpy.types.Object), (PhoticLight, bpy.types.Light)):
        bpy.utils.register_class(group)
        owner.photic = bpy.props.PointerProperty(type=group)


def unregister():
    for group, owner in ((PhoticLight, bpy.types.Light), (PhoticObject, bpy.types.Object)):
        del owner.photic
        bpy.utils.unregister_class(group)
