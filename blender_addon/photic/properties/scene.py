# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of a scene's bake, and what is kept of the last one."""
import zlib

import bpy
from bpy.props import (BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty,
                       StringProperty)

from .. import compat
from . import method_options

_method_items = []     # Blender keeps no reference to the strings of a dynamic enum


def _methods(_settings, _context):
    return _method_items


def _preview_changed(settings, _context):
    from ..operators import preview_state
    preview_state.update_numbers(settings)


def _annotations():
    """The class's properties; one pointer for the options of each method."""
    metres = {"subtype": "TRANSLATION", "unit": "LENGTH", "size": 3, "precision": 3}
    per_metre = {"size": 3, "min": 0.0, "soft_max": 2.0, "precision": 3}
    own = {
        "domain_from": EnumProperty(name="Domain", items=(
            ("AUTO", "Automatic", "The box of what bends light and of where its light goes"),
            ("CUSTOM", "Custom", "A box of your own")), default="AUTO", description="The box that is baked"),
        "domain_min": FloatVectorProperty(name="From", default=(-1.0, -1.0, -1.0), **metres),
        "domain_max": FloatVectorProperty(name="To", default=(1.0, 1.0, 1.0), **metres),
        "domain_shown": BoolProperty(name="Show the box", default=True, description="Draw the box in the 3D view"),
        "size_by": EnumProperty(name="Size by", items=(
            ("RESOLUTION", "Resolution", "Voxels along the longest side"), ("VOXEL", "Voxel size", "In metres")),
            default="RESOLUTION"),
        "resolution": IntProperty(name="Resolution", default=128, min=4, max=4096, soft_max=1024,
                                  description="Voxels along the domain's longest side"),
        "voxel_size": FloatProperty(name="Voxel size", default=0.02, min=1e-4, soft_max=1.0, precision=4, unit="LENGTH"),
        "shear": BoolProperty(name="Lean with the light", default=False,
                              description="Voxels lean along the sun's light: sharper at the same number of voxels"),
        "method": EnumProperty(name="Method", items=_methods, description="Of the baker"),
        "where": EnumProperty(name="Where", items=(
            ("EVERYWHERE", "Everywhere", "Anything can be moved anywhere"),
            ("RECEIVERS", "At receivers", "A band around the receivers: quicker, and smaller"),
            ("MEDIA", "In media", "Where light can be seen in the water")), default="EVERYWHERE"),
        "band": IntProperty(name="Band", default=2, min=1, max=64, description="Voxels around receivers"),
        "quadrature": EnumProperty(name="Points per layer", items=(
            ("AUTO", "By the light", "As many as the slant of the light asks for"),
            ("1", "1", ""), ("2", "2", ""), ("4", "4", ""), ("6", "6", ""), ("8", "8", ""), ("12", "12", "")),
            default="AUTO"),
        "tolerance": FloatProperty(name="Tolerance", default=0.25, min=0.001, max=16.0, precision=3,
                                   description="Of refinement [voxels]"),
        "prefilter": BoolProperty(name="Prefilter", default=False, description="Sharper receivers, less exact media"),
        "grid_caustic": BoolProperty(name="Caustic", description="Also write the method's own indicator of focus"),
        "grid_arrival_time": BoolProperty(name="Arrival time", description="Also write when light arrives [m of path]"),
        "medium_from": EnumProperty(name="Medium", items=(
            ("MATERIAL", "From the material", "Absorption and scatter nodes of the water's Volume"),
            ("SCENE", "Own", "The values below")), default="MATERIAL"),
        "absorption": FloatVectorProperty(name="Absorption", default=(0.0, 0.0, 0.0), description="Per metre; R, G, B", **per_metre),
        "scattering": FloatVectorProperty(name="Scattering", default=(0.05, 0.05, 0.05), description="Per metre; R, G, B", **per_metre),
        "anisotropy": FloatProperty(name="Anisotropy", default=0.8, min=-0.99, max=0.99, description="Henyey and Greenstein's g"),
        "folder": StringProperty(name="Folder", default="//photic", subtype="DIR_PATH", description="Of baked volumes",
                                 options={"ANIMATABLE"} | compat.relative_path()),
        "preview_after_bake": BoolProperty(name="Show when baked", default=True),
        "show_medium": BoolProperty(name="Light in the water", default=True, update=_preview_changed,
                                    description="Show the volume's light scattered by the medium"),
        "match_cycles": BoolProperty(
            name="Match Cycles", default=True, update=_preview_changed,
            description="Cycles and EEVEE leave radiance as it is where it leaves the water; light on what is under water is "
                        "divided by its refractive index squared, as they do. Right for a camera in air"),
        "look_up": EnumProperty(name="Look up", items=(
            ("AUTO", "Automatic", "At vertices where a mesh is denser than the voxels, at pixels elsewhere"),
            ("PIXELS", "At pixels", "In a slice atlas, for each pixel that is shaded"),
            ("VERTICES", "At vertices", "By Geometry Nodes' Sample Grid, however dense a mesh is")), default="AUTO",
            description="How receivers get their light; Show, or Bake, applies it"),
        "strength": FloatProperty(name="Strength", default=1.0, min=0.0, soft_max=10.0, update=_preview_changed,
                                  description="Multiplies the light; 1 is right"),
        # Of the last bake
        "volume": PointerProperty(name="Light volume", type=bpy.types.Object),
        "volume_file": StringProperty(name="Volume file", subtype="FILE_PATH", options=compat.relative_path()),
        "atlas_file": StringProperty(name="Atlas", subtype="FILE_PATH", options=compat.relative_path()),
        "sequence_start": IntProperty(),
        "sequence_count": IntProperty(),
        "level": FloatProperty(),
        "ior": FloatProperty(default=1.0),
        "has_density": BoolProperty(),
        "baked_absorption": FloatVectorProperty(size=3),
        "baked_scattering": FloatVectorProperty(size=3),
        "baked_anisotropy": FloatProperty(),
        "previewing": BoolProperty(),
        "message": StringProperty(),
        "forms": StringProperty(),      # what the water was last baked, or looked at, as
        "estimate": StringProperty(),
        "light_errors": StringProperty(),       # how far light on receivers is off, as the last bake measured it
    }
    for name, group in method_options.classes().items():
        own[f"options_{name}"] = PointerProperty(type=group)
    return own


_registered = []


def register():
    # Files hold the number: it must mean the same method after the catalogue has grown.
    _method_items[:] = [("auto", "Automatic", "The first that can bake the scene", 0)] + [
        (method.name, method.name.capitalize(), method.summary, 1 + zlib.crc32(method.name.encode()) % 2 ** 30)
        for method in method_options.methods()]
    group = type("PhoticScene", (bpy.types.PropertyGroup,), {"__annotations__": _annotations()})
    bpy.utils.register_class(group)
    _registered.append(group)
    bpy.types.Scene.photic = PointerProperty(type=group)


def unregister():
    del bpy.types.Scene.photic
    bpy.utils.unregister_class(_registered.pop())

