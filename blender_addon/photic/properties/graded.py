# SPDX-License-Identifier: GPL-3.0-or-later
"""How light goes through an object of glass: settings of what has an index that varies."""
import bpy

from .. import compat
from ..core import graded

THROUGH = (
    (graded.SHARP, "Sharp body", "Light is bent at the faces, and goes straight in between"),
    (graded.SMOOTHED, "Graded body", "The body as samples of its index, with faces that are smoothed: light bends within them, and "
                                     "nothing is reflected"),
    (graded.FILE, "Index volume", "Samples of the index from a file (.vdb), placed by this object's transform"),
    (graded.LENS, "Luneburg lens", "A ball that gathers parallel light in one point of its far side, whichever way it comes"),
    (graded.ROD, "Rod lens", "A rod along the object's Z whose index falls towards its rim: light swings through it"),
)


class PhoticGraded(bpy.types.PropertyGroup):
    through: bpy.props.EnumProperty(name="Light goes through", items=THROUGH, default=graded.SHARP,
                                    description="What the object of glass is to light")
    voxel_size: bpy.props.FloatProperty(name="Samples", min=0.0, soft_max=1.0, precision=4, unit="LENGTH",
                                        description="Size of the samples of its index; 0: its longest side over 128")
    smooth: bpy.props.FloatProperty(name="Soft faces", min=0.0, soft_max=1.0, precision=4, unit="LENGTH",
                                    description="Deviation of the Gaussian over its faces, which go from 10 to 90 % in 2.6 times "
                                                "that; 0: one sample")
    file: bpy.props.StringProperty(name="File", subtype="FILE_PATH", options={"ANIMATABLE"} | compat.relative_path(),
                                   description="OpenVDB file with a float grid of the index of refraction, in metres, Z up")
    grid: bpy.props.StringProperty(name="Grid", description="Of the index; empty: ior, index or n, or the only one")
    absorption_grid: bpy.props.StringProperty(
        name="Absorption grid", description="Of the same file, per metre, one value or three; empty: the material's own absorption")
    faces: bpy.props.BoolProperty(name="Sharp faces", default=False,
                                  description="Light is refracted and reflected at the mesh too, and the index varies behind it")
    focus: bpy.props.FloatProperty(name="Focus", min=0.0, soft_max=10.0, precision=4, unit="LENGTH",
                                   description="How far behind its face, in the rod, parallel light meets; 0: its length")


def of(obj):
    """The settings as the exporter takes them, or None of a sharp body."""
    found = obj.photic.graded
    if found.through == graded.SHARP:
        return None
    return graded.Graded(found.through, found.voxel_size, found.smooth, bpy.path.abspath(found.file) if found.file else "",
                         found.grid, found.absorption_grid, found.faces and found.through in (graded.FILE, graded.ROD), found.focus)


def register():
    bpy.utils.register_class(PhoticGraded)


def unregister():
    bpy.utils.unregister_class(PhoticGraded)
