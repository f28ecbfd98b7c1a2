# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading node trees through reroutes and groups."""

from .. import compat


def is_ours(item):
    """Whether the add-on made this node, group, material, image or object."""
    return compat.is_marked(item)


def active_output(tree, target=None):
    """The material output that is rendered, or None."""
    if target is not None:
        return tree.get_output_node(target)
    return tree.get_output_node("CYCLES") or tree.get_output_node("ALL") or tree.get_output_node("EEVEE")


def outputs(tree):
    """Every material output in the tree."""
    return [node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial"]


def source(socket_in):
    """The output socket that feeds an input, through reroutes and muted links; None when nothing does."""
    while socket_in is not None and socket_in.is_linked:
        link = socket_in.links[0]
        if link.is_muted or not link.is_valid:
            return None
        if link.from_node.bl_idname != "NodeReroute":
            return link.from_socket
        socket_in = link.from_node.inputs[0]
    return None


def group_source(group_node, output_socket):
    """What feeds `output_socket` of a group from the inside."""
    for node in group_node.node_tree.nodes:
        if node.bl_idname == "NodeGroupOutput" and node.is_active_output:
            inner = next((s for s in node.inputs if s.identifier == output_socket.identifier), None)
            return source(inner)
    return None


def upstream(origin, kinds, depth=64):
    """The first node of these kinds behind an output socket, itself included, or None."""
    if origin is None or depth == 0:
        return None
    node = origin.node
    if node.bl_idname in kinds:
        return node
    if node.bl_idname == "ShaderNodeGroup" and node.node_tree:
        found = upstream(group_source(node, origin), kinds, depth - 1)
        if found is not None:
            return found
    return next((found for socket_in in node.inputs
                 if (found := upstream(source(socket_in), kinds, depth - 1)) is not None), None)


def constant(socket_in):
    """The number of a Value node that feeds a socket, or None."""
    origin = source(socket_in)
    if origin is not None and origin.node.bl_idname == "ShaderNodeValue":
        return float(origin.default_value)
    return None
