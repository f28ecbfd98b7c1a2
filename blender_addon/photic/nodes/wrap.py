# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the Receiver group behind a material's shaders, and takes it away again without a trace."""
import bpy

from .. import compat
from . import albedo, build, graph

BEFORE = "photic_before"    # custom property: a material's settings before it was wrapped
WRAPPER = "Photic Receiver"


def is_wrapped(material):
    tree = compat.shader_tree(material)
    return tree is not None and any(graph.is_ours(node) for node in tree.nodes)


def wrap(material, receiver_group):
    """Wraps every output of a material; a wrapped one is first unwrapped, so doing it twice is doing it once."""
    if graph.is_ours(material) and WRAPPER not in material.name:
        return
    unwrap(material)
    had_nodes = bool(material.node_tree and material.node_tree.nodes)
    used_nodes = compat.shader_tree(material) is not None
    before = {"use_nodes": int(used_nodes), "had_nodes": int(had_nodes)}
    if not used_nodes:
        compat.switch_nodes(material, True)
        if not had_nodes:
            _principled_of(material, tuple(material.diffuse_color), material.roughness, material.metallic)
    for owner, name, value in compat.quiet_emission(material):
        before[name] = getattr(owner, name)
        setattr(owner, name, value)
    material[BEFORE] = before

    tree = material.node_tree
    for output in graph.outputs(tree):
        link = output.inputs["Surface"].links[0] if output.inputs["Surface"].is_linked else None
        if link is None:
            continue
        b = build.Builder(tree, (output.location.x - 400, output.location.y - 260))
        group = b.node("ShaderNodeGroup", node_tree=receiver_group)
        group.label, group.hide, group.width = WRAPPER, False, 180
        group.location = (output.location.x, output.location.y - 160)
        origin = link.from_socket
        colour, normal = albedo.diffuse(b, graph.source(output.inputs["Surface"]))
        if colour is None:
            colour = (0.0, 0.0, 0.0, 1.0)
        elif isinstance(colour, tuple):
            colour = (*colour[:3], 1.0)
        b.plug(colour, group.inputs["Albedo"])
        if normal is not None:
            b.plug(normal, group.inputs["Normal"])
        tree.links.new(origin, group.inputs["Shader"])
        tree.links.new(group.outputs["Shader"], output.inputs["Surface"])


def unwrap(material):
    """Gives the outputs their own shaders back and removes every node of ours."""
    tree = compat.shader_tree(material)
    if tree is None:
        return
    for output in graph.outputs(tree):
        surface = output.inputs["Surface"]
        while surface.is_linked and graph.is_ours(surface.links[0].from_node):
            shader = surface.links[0].from_node.inputs["Shader"]
            if shader.is_linked:
                tree.links.new(shader.links[0].from_socket, surface)
            else:
                tree.links.remove(surface.links[0])
    for node in [node for node in tree.nodes if graph.is_ours(node)]:
        tree.nodes.remove(node)
    if BEFORE in material.keys():
        before = material[BEFORE].to_dict()
        for owner, name, _ in compat.quiet_emission(material):
            if name in before:
                setattr(owner, name, type(getattr(owner, name))(before[name]))
        del material[BEFORE]
        if not before["had_nodes"]:
            tree.nodes.clear()
        compat.switch_nodes(material, bool(before["use_nodes"]))


def make_thin(material):
    """Tells EEVEE (since 4.2) that what refracts is a surface with water behind it, and no slab of glass that turns light back
    to where it went: what is seen through it is misplaced otherwise. unwrap() takes the node away."""
    tree = compat.shader_tree(material)
    for output in graph.outputs(tree) if tree else ():
        socket = compat.thickness(output)
        if socket is not None and not socket.is_linked:
            b = build.Builder(tree, (output.location.x - 200, output.location.y - 120))
            b.plug(b.value("No thickness", 0.0), socket)


def _principled_of(material, colour, roughness, metallic):
    """What a material without nodes looks like, as nodes: the ones that Blender makes by itself."""
    principled = next((n for n in material.node_tree.nodes if n.bl_idname == "ShaderNodeBsdfPrincipled"), None)
    if principled is None:
        principled = material.node_tree.nodes.new("ShaderNodeBsdfPrincipled")
        output = material.node_tree.nodes.new("ShaderNodeOutputMaterial")
        material.node_tree.links.new(principled.outputs[0], output.inputs["Surface"])
    principled.inputs["Base Color"].default_value = colour
    principled.inputs["Roughness"].default_value = roughness
    principled.inputs["Metallic"].default_value = metallic


def plain_material():
    """A white material for receivers without any, which is removed with the preview."""
    name = f"{WRAPPER} (plain)"
    material = bpy.data.materials.get(name)
    if material is None:
        material = bpy.data.materials.new(name)
        compat.mark(material)
        compat.switch_nodes(material, True)
    return material
