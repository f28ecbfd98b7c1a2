# SPDX-License-Identifier: GPL-3.0-or-later
"""The groups of one light volume: made when missing, emptied and filled again when they are there, so that links stay."""
import bpy

from .. import compat


def named(kind, volume_object):
    return f"Photic {kind}: {volume_object.name}"


def fresh(name, inputs, outputs, kind="ShaderNodeTree"):
    """An empty node group of this name and these sockets, (type, name, default). Users of an old one keep it."""
    tree = bpy.data.node_groups.get(name)
    if tree is None or tree.library is not None or tree.bl_idname != kind:
        tree = bpy.data.node_groups.new(name, kind)
    compat.mark(tree)
    tree.animation_data_clear()
    tree.nodes.clear()
    if not _has(tree, inputs, outputs):
        compat.clear_sockets(tree)
        for kind, label, default in inputs:
            compat.add_socket(tree, "INPUT", kind, label, default)
        for kind, label, _ in outputs:
            compat.add_socket(tree, "OUTPUT", kind, label)
    return tree


def _has(tree, inputs, outputs):
    return (compat.socket_names(tree, "INPUT") == [i[1] for i in inputs]
            and compat.socket_names(tree, "OUTPUT") == [o[1] for o in outputs])


def drive_rotation(tree, node, volume_object):
    """Turns a Vector Rotate node with the volume: neither engine turns a vector attribute, or knows an atlas's axes."""
    for axis, kind in enumerate(("ROT_X", "ROT_Y", "ROT_Z")):
        curve = node.inputs["Rotation"].driver_add("default_value", axis)
        driver = curve.driver
        driver.type = "AVERAGE"     # no expression: runs where Python scripts in files are not trusted
        variable = driver.variables.new()
        variable.type = "TRANSFORMS"
        target = variable.targets[0]
        target.id = volume_object
        target.transform_type = kind
        target.rotation_mode = "XYZ"
        target.transform_space = "WORLD_SPACE"
        for modifier in list(curve.modifiers):
            curve.modifiers.remove(modifier)
