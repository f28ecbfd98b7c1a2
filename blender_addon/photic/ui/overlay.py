# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the custom domain's box in the 3D view."""
import itertools

import bpy

from .. import compat

COLOUR = (1.0, 0.75, 0.2, 0.9)
EDGES = [(a, b) for a, b in itertools.combinations(range(8), 2) if bin(a ^ b).count("1") == 1]

_handler = None


def corners(low, high):
    """The box's eight corners; bit i of a corner's number chooses the side along axis i."""
    return [tuple((high if number >> axis & 1 else low)[axis] for axis in range(3)) for number in range(8)]


def _draw():
    scene = bpy.context.scene
    settings = getattr(scene, "photic", None)
    if settings is None or settings.domain_from != "CUSTOM" or not settings.domain_shown:
        return
    import gpu
    from gpu_extras.batch import batch_for_shader
    shader = gpu.shader.from_builtin(compat.line_shader())
    points = corners(settings.domain_min, settings.domain_max)
    batch = batch_for_shader(shader, "LINES", {"pos": [points[i] for edge in EDGES for i in edge]})
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.blend_set("ALPHA")
    shader.bind()
    shader.uniform_float("color", COLOUR)
    batch.draw(shader)
    gpu.state.blend_set("NONE")
    gpu.state.depth_test_set("NONE")


def register():
    global _handler
    if not bpy.app.background and _handler is None:
        _handler = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister():
    global _handler
    if _handler is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handler, "WINDOW")
        _handler = None
