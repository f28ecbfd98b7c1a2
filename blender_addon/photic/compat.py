# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender renamed or changed from 3.4 to 5.2, each in one place.

Where a name can be asked for, it is; a version is compared only where nothing can be seen from outside.
"""
import math

import bpy

VOXELS_CENTRED_SINCE = (4, 5, 0)        # projects.blender.org, pull request 138449
UNIFORM_COLOR_SINCE = (4, 0, 0)         # "3D_UNIFORM_COLOR" before
EEVEE_NEXT = ((4, 2, 0), (5, 0, 0))     # from, and until before: the name of the engine that is called EEVEE in both other times
AREA_WATTS_SINCE = (4, 0, 0)            # projects.blender.org, issue 108505; 3.4 and 4.3 measured
SAMPLE_GRID_SINCE = (5, 0, 0)           # an experiment before, whose type is there and gives nothing
RELATIVE_PATHS_SINCE = (5, 0, 0)        # properties say whether they understand "//"


def half_voxel_late(version=None):
    """Whether the engines show voxel (i, j, k) centred at transform(i + 1/2, ...), and not at transform(i, ...) as OpenVDB
    has it. Measured in 3.4: both do, along all three axes, at any voxel size."""
    return tuple(version or bpy.app.version) < VOXELS_CENTRED_SINCE


def line_shader(version=None):
    """Name of the built-in shader that draws lines in one colour."""
    return "UNIFORM_COLOR" if tuple(version or bpy.app.version) >= UNIFORM_COLOR_SINCE else "3D_UNIFORM_COLOR"


def eevee_engine(version=None):
    """What scene.render.engine calls EEVEE."""
    first, after = EEVEE_NEXT
    return "BLENDER_EEVEE_NEXT" if first <= tuple(version or bpy.app.version) < after else "BLENDER_EEVEE"


def relative_path(version=None):
    """Options of a path property that understands "//", the .blend file's folder."""
    return {"PATH_SUPPORTS_BLEND_RELATIVE"} if tuple(version or bpy.app.version) >= RELATIVE_PATHS_SINCE else set()


# Marks of what the add-on made. Nodes have custom properties no more since 5.0, but still those that add-ons register.

OURS = "photic_made"


def register():
    bpy.types.Node.photic_made = bpy.props.BoolProperty(name="Made by Photic", options={"HIDDEN"})


def unregister():
    del bpy.types.Node.photic_made


def mark(item):
    try:
        item[OURS] = 1
    except TypeError:
        item.photic_made = True


def is_marked(item):
    try:
        return OURS in item.keys()
    except TypeError:
        return bool(getattr(item, "photic_made", False))


# Sockets of node groups: tree.inputs and tree.outputs until 4.0, tree.interface since.

def add_socket(tree, in_out, socket_type, name, default=None):
    """Adds a socket to a group; `in_out` is "INPUT" or "OUTPUT"."""
    if hasattr(tree, "interface"):
        item = tree.interface.new_socket(name, in_out=in_out, socket_type=socket_type)
    else:
        item = (tree.inputs if in_out == "INPUT" else tree.outputs).new(socket_type, name)
    if default is not None:
        item.default_value = default
    return item


def socket_names(tree, in_out):
    """Names of a group's sockets."""
    if hasattr(tree, "interface"):
        return [item.name for item in tree.interface.items_tree if item.item_type == "SOCKET" and item.in_out == in_out]
    return [item.name for item in (tree.inputs if in_out == "INPUT" else tree.outputs)]


def clear_sockets(tree):
    if hasattr(tree, "interface"):
        tree.interface.clear()
    else:
        tree.inputs.clear()
        tree.outputs.clear()


SOCKETS = {     # of shader nodes: the names that they have had, the newest first
    "Transmission": ("Transmission Weight", "Transmission"),
    "Specular": ("Specular IOR Level", "Specular"),
    "Factor": ("Factor", "Fac"),
}


def socket(sockets, name):
    """The socket that is called `name` in this Blender or was in an earlier one, or None."""
    for known in SOCKETS.get(name, (name,)):
        found = sockets.get(known)
        if found is not None:
            return found
    return None


def thickness(output_node):
    """The socket of a material output by which EEVEE (since 4.2) is told how thick a refracting object is, or None."""
    return output_node.inputs.get("Thickness")


# Node trees of materials, lights and worlds

def shader_tree(item):
    """The tree that renders a material, light or world, or None when it is rendered without nodes.

    `use_nodes` is true for good since 5.0, of lights since a version after it; it goes in 6.0."""
    tree = getattr(item, "node_tree", None)
    return tree if tree is not None and getattr(item, "use_nodes", True) else None


def switch_nodes(item, on):
    """Switches an item's nodes on or off, where that can be done."""
    if getattr(item, "use_nodes", on) != on:
        item.use_nodes = on


# Geometry Nodes

def samples_grids(version=None):
    """Whether nodes look grids of volumes up at vertices."""
    return tuple(version or bpy.app.version) >= SAMPLE_GRID_SINCE


# Lights

def area_share(version=None):
    """The part of its watts that an area light really sends."""
    return 1.0 if tuple(version or bpy.app.version) >= AREA_WATTS_SINCE else math.pi / 4


def light_level(light):
    """Watts (W/m2 of a sun) of a light by channel: its energy and colour, and since 4.5 its exposure and its temperature."""
    energy = light.energy * 2.0 ** getattr(light, "exposure", 0.0)
    tint = light.temperature_color if getattr(light, "use_temperature", False) else (1.0, 1.0, 1.0)
    return [energy * c * t for c, t in zip(light.color, tint)]


def is_normalized(light):
    """Whether a lamp's watts are all that it sends, and not watts per area, which it may be since 4.5."""
    return getattr(light, "normalize", True)


# Materials

def quiet_emission(material):
    """What keeps Cycles from sampling an emissive material as a lamp: [(owner, name, value)]."""
    cycles = getattr(material, "cycles", None)
    if hasattr(cycles, "emission_sampling"):        # since 3.5
        return [(cycles, "emission_sampling", "NONE")]
    if hasattr(cycles, "sample_as_light"):
        return [(cycles, "sample_as_light", False)]
    return []


def see_through(material):
    """Name of the setting by which EEVEE shows what lies behind a refracting material."""
    return "use_raytrace_refraction" if hasattr(material, "use_raytrace_refraction") else "use_screen_refraction"    # 4.2


SCENE_SEE_THROUGH = ("use_ssr", "use_ssr_refraction", "use_raytracing")     # of scene.eevee; the last since 4.2


def show_progress(layout, fraction, words):
    """A bar where layouts have one (since 4.0), otherwise the words."""
    if hasattr(layout, "progress"):
        layout.progress(factor=fraction, text=words)
    else:
        layout.label(text=words, icon="RENDER_ANIMATION")
