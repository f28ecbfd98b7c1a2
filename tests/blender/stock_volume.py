# SPDX-License-Identifier: Apache-2.0
"""A stock scene, without anything of Photic's but the file, of which a stock Principled Volume shows the grid `density`.

    blender -b --factory-startup -P tests/blender/stock_volume.py -- ENGINE FILE.vdb
"""
import pathlib
import sys

import bpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "examples" / "blender")]

import scenes                   # noqa: E402  pylint: disable=wrong-import-position
from support import render      # noqa: E402  pylint: disable=wrong-import-position


def main(engine, path):
    scene = scenes.empty()
    data = bpy.data.volumes.new("Stock")
    data.filepath = path
    material = scenes.with_nodes(bpy.data.materials.new("Stock"))
    tree = material.node_tree
    tree.nodes.clear()
    shader, out = tree.nodes.new("ShaderNodeVolumePrincipled"), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Emission Strength"].default_value = 1.0
    tree.links.new(shader.outputs[0], out.inputs["Volume"])
    data.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("Stock", data))
    scenes.camera((0, -6, 0), (0, 0, 0), orthographic=1)
    print("shown:", bool(render(engine, 8)[..., 3].max() > 0.01))


main(*sys.argv[sys.argv.index("--") + 1:])
