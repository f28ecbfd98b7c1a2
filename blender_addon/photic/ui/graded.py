# SPDX-License-Identifier: GPL-3.0-or-later
"""How light goes through an object of glass, on its panel."""
from ..core import graded

SHOWN = {
    graded.SMOOTHED: ("voxel_size", "smooth"),
    graded.FILE: ("file", "grid", "absorption_grid", "faces"),
    graded.LENS: (),
    graded.ROD: ("focus", "faces"),
}


def draw(layout, obj):
    settings = obj.photic.graded
    layout.prop(settings, "through")
    if settings.through == graded.SHARP:
        layout.prop(obj.photic, "surface")
    for name in SHOWN.get(settings.through, ()):
        layout.prop(settings, name)
    if settings.through in (graded.SHARP, graded.SMOOTHED, graded.ROD):
        layout.prop(obj.photic, "ior")
    if settings.through in (graded.SHARP, graded.SMOOTHED):
        layout.prop(obj.photic, "abbe")
    if settings.through != graded.SHARP:
        layout.label(text="Blender draws it by its material alone", icon="INFO")
