# SPDX-License-Identifier: GPL-3.0-or-later
"""Says node trees as expressions: each call adds a node and returns the socket that holds its value."""
from .. import compat

COLUMN = 180.0      # [px] between nodes
ROW = 60.0


class Builder:
    """Adds nodes to a tree, all of them tagged as ours. Arguments are sockets, numbers or tuples."""

    def __init__(self, tree, origin=(0.0, 0.0)):
        self.tree = tree
        self._origin = origin
        self._count = 0

    def node(self, kind, name="", **settings):
        node = self.tree.nodes.new(kind)
        compat.mark(node)
        if name:
            node.name = node.label = name
        for key, value in settings.items():
            setattr(node, key, value)
        # Row by row: an artist who opens the group sees an order, if not a drawing.
        node.location = (self._origin[0] + COLUMN * (self._count // 8), self._origin[1] - ROW * (self._count % 8))
        node.hide = True
        self._count += 1
        return node

    def plug(self, value, socket):
        if hasattr(value, "is_output"):
            self.tree.links.new(value, socket)
        elif value is not None:
            socket.default_value = value

    def math(self, operation, *arguments, clamp=False):
        node = self.node("ShaderNodeMath", operation=operation, use_clamp=clamp)
        for argument, socket in zip(arguments, node.inputs):
            self.plug(argument, socket)
        return node.outputs[0]

    def vector(self, operation, *arguments, scale=None):
        """A vector operation; DOT_PRODUCT and LENGTH return a number."""
        node = self.node("ShaderNodeVectorMath", operation=operation)
        for argument, socket in zip(arguments, node.inputs):
            self.plug(argument, socket)
        if scale is not None:
            self.plug(scale, node.inputs["Scale"])
        return node.outputs["Value" if operation in ("DOT_PRODUCT", "LENGTH") else "Vector"]

    def split(self, vector):
        node = self.node("ShaderNodeSeparateXYZ")
        self.plug(vector, node.inputs[0])
        return tuple(node.outputs)

    def join(self, x, y, z):
        node = self.node("ShaderNodeCombineXYZ")
        for value, socket in zip((x, y, z), node.inputs):
            self.plug(value, socket)
        return node.outputs[0]

    def value(self, name, number):
        """A named number, that is changed without building anew."""
        node = self.node("ShaderNodeValue", name)
        node.outputs[0].default_value = number
        return node.outputs[0]

    def between(self, value, low, high):
        """1 where low <= value <= high, otherwise 0."""
        return self.math("COMPARE", value, (low + high) / 2, (high - low) / 2)
