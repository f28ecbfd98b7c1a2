# SPDX-License-Identifier: GPL-3.0-or-later
"""The diffuse colour of a material as a socket: what its own shaders would reflect of light that they were given."""
from .. import compat
from . import graph

MAX_DEPTH = 64


def diffuse(b, origin, depth=0):
    """(albedo, normal) behind a shader's output; each a socket, a colour or None. Adds nodes to the builder's tree.

    Mixes and sums of shaders become the same of their colours; metal, glass and emission reflect nothing diffusely.
    """
    if origin is None or depth > MAX_DEPTH:
        return None, None
    node = origin.node
    kind = node.bl_idname
    if kind == "ShaderNodeBsdfPrincipled":
        return _principled(b, node), _link_of(node.inputs.get("Normal"))
    if kind in ("ShaderNodeBsdfDiffuse", "ShaderNodeSubsurfaceScattering", "ShaderNodeBsdfVelvet", "ShaderNodeBsdfSheen",
                "ShaderNodeBsdfToon"):
        return _value_of(node.inputs["Color"]), _link_of(node.inputs.get("Normal"))
    if kind == "ShaderNodeMixShader":
        parts = [diffuse(b, graph.source(socket), depth + 1) for socket in node.inputs[1:3]]
        return _mix(b, _value_of(node.inputs[0]), parts[0][0], parts[1][0]), parts[0][1] or parts[1][1]
    if kind == "ShaderNodeAddShader":
        parts = [diffuse(b, graph.source(socket), depth + 1) for socket in node.inputs]
        colours = [part[0] for part in parts if part[0] is not None]
        total = b.vector("ADD", *colours) if len(colours) == 2 else (colours or [None])[0]
        return total, parts[0][1] or parts[1][1]
    if kind == "ShaderNodeGroup" and node.node_tree and not graph.is_ours(node):
        return _of_group(node, origin)
    return None, None


def _value_of(socket):
    """What feeds a socket, or what it is set to."""
    origin = graph.source(socket)
    if origin is not None:
        return origin
    value = socket.default_value
    return tuple(value) if hasattr(value, "__len__") else float(value)


def _link_of(socket):
    return graph.source(socket) if socket is not None else None


def _three(colour):
    return colour[:3] if isinstance(colour, tuple) else colour


def _principled(b, node):
    """base colour * (1 - metallic) * (1 - transmission)."""
    colour = _value_of(node.inputs["Base Color"])
    for name in ("Metallic", "Transmission"):
        amount = _value_of(compat.socket(node.inputs, name))
        if amount == 0.0:
            continue
        if amount == 1.0:
            return None
        left = b.math("SUBTRACT", 1.0, amount)
        colour = b.vector("SCALE", _three(colour), scale=left)
    return colour


def _mix(b, factor, first, second):
    if first is None and second is None:
        return None
    black = (0.0, 0.0, 0.0)
    first, second = (black if colour is None else _three(colour) for colour in (first, second))
    rest = b.math("SUBTRACT", 1.0, factor)
    return b.vector("ADD", b.vector("SCALE", first, scale=rest), b.vector("SCALE", second, scale=factor))


def _of_group(node, origin):
    """A group's own colours can't be linked from outside: its input named like one, or the plain colour inside."""
    for name in ("Base Color", "Color", "Albedo", "Diffuse"):
        socket = node.inputs.get(name)
        if socket is not None and socket.type == "RGBA":
            return _value_of(socket), None
    inner = graph.group_source(node, origin)
    if inner is not None:
        for name in ("Base Color", "Color"):
            socket = inner.node.inputs.get(name)
            if socket is not None and socket.type == "RGBA":
                return tuple(socket.default_value), None
    return None, None
