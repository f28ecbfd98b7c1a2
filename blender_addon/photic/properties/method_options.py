# SPDX-License-Identifier: GPL-3.0-or-later
"""A property group for each of the baker's methods, made from its own catalogue: a new option needs no new add-on."""
import bpy

from . import preferences

INT_LIMIT = 2 ** 31 - 1     # of Blender's integers

_methods = ()
_classes = {}


def methods():
    """The catalogue that the groups were made from."""
    return _methods


def classes():
    """Method's name -> property group."""
    return dict(_classes)


def _property(option):
    """A Blender property like an option: same default, range, choices and help."""
    unit = f" [{option.unit}]" if option.unit else ""
    label = option.name.replace("_", " ").capitalize() + unit
    common = {"name": label, "description": option.help[:1].upper() + option.help[1:]}
    if option.type == "flag":
        return bpy.props.BoolProperty(default=bool(option.default), **common)
    if option.type == "choice":
        return bpy.props.EnumProperty(items=[(c, c.replace("_", " ").capitalize(), "") for c in option.choices],
                                      default=option.default, **common)
    limits = {key: value for key, value in (("min", option.min), ("max", option.max)) if value is not None}
    if option.type == "integer":
        limits = {key: int(max(-INT_LIMIT, min(INT_LIMIT, value))) for key, value in limits.items()}
        return bpy.props.IntProperty(default=int(option.default), **limits, **common)
    return bpy.props.FloatProperty(default=float(option.default), precision=4, **limits, **common)


def register():
    global _methods
    _methods = preferences.methods()
    for method in _methods:
        group = type(f"PhoticOptions_{method.name}", (bpy.types.PropertyGroup,), {
            "__annotations__": {option.name: _property(option) for option in method.options}, "__doc__": method.summary})
        bpy.utils.register_class(group)
        _classes[method.name] = group


def unregister():
    for group in _classes.values():
        bpy.utils.unregister_class(group)
    _classes.clear()

