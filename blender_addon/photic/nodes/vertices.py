# SPDX-License-Identifier: GPL-3.0-or-later
"""Light at each vertex of a receiver: a modifier of Geometry Nodes' Sample Grid (since 5.0) puts flux into attributes, from which
the Receiver group reads it instead of the slice atlas.

The grid is the volume object's own, at the frame that is shown; whatever moves, the attributes follow. Flux, irradiance times
direction, is multiplied out on the grid and only then looked up, as docs/light_volume.md asks for.
"""
import numpy

from .. import compat
from . import build, graph, groups

MODIFIER = "Photic Light"
LIGHT, SAMPLE, RECEIVER = "Light at vertices", "Sample at vertices", "Receiver by vertices"     # kinds of groups
LOBES = ((" 2", "_2"), ("", ""))      # of the outputs' and the grids' names


def can_look_up(volume_object):
    """Whether this Blender looks grids up at vertices, and the volume has what it takes."""
    names = {grid.name for grid in volume_object.data.grids}
    return compat.samples_grids() and {"irradiance", "direction"} <= names


def is_dense(obj, depsgraph, longest):
    """Whether nearly all edges of an object's mesh are at most `longest` [m] in the world: then light between vertices is
    no more than that apart."""
    if obj.type != "MESH" or obj.library or obj.override_library or obj.data.library:
        return False
    evaluated = obj.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh()
    try:
        if mesh is None or not mesh.edges:
            return False
        places = numpy.empty(3 * len(mesh.vertices), dtype=numpy.float32)
        ends = numpy.empty(2 * len(mesh.edges), dtype=numpy.int32)
        mesh.vertices.foreach_get("co", places)
        mesh.edges.foreach_get("vertices", ends)
        world = places.reshape(-1, 3) @ numpy.array(obj.matrix_world.to_3x3(), dtype=numpy.float32).T
        lengths = numpy.linalg.norm(world[ends[0::2]] - world[ends[1::2]], axis=1)
        return bool(numpy.quantile(lengths, 0.95) <= longest)
    finally:
        evaluated.to_mesh_clear()


def build_light(volume_object, scale):
    """(Re)builds the modifier's group: attributes of flux [W/m2], and of irradiance in colours, by lobe."""
    tree = groups.fresh(groups.named(LIGHT, volume_object), [("NodeSocketGeometry", "Geometry", None)],
                        [("NodeSocketGeometry", "Geometry", None)], "GeometryNodeTree")
    b = build.Builder(tree)
    light = b.node("GeometryNodeObjectInfo", transform_space="ORIGINAL")
    light.inputs["Object"].default_value = volume_object
    own = b.node("GeometryNodeObjectInfo", transform_space="ORIGINAL")
    b.plug(b.node("GeometryNodeSelfObject").outputs[0], own.inputs["Object"])
    inverse = b.node("FunctionNodeInvertMatrix")
    b.plug(light.outputs["Transform"], inverse.inputs[0])
    into_light = b.node("FunctionNodeMatrixMultiply")
    b.plug(inverse.outputs[0], into_light.inputs[0])
    b.plug(own.outputs["Transform"], into_light.inputs[1])
    place = b.node("FunctionNodeTransformPoint")
    b.plug(b.node("GeometryNodeInputPosition").outputs[0], place.inputs["Vector"])
    b.plug(into_light.outputs[0], place.inputs["Transform"])

    geometry = b.node("NodeGroupInput").outputs["Geometry"]
    for _, suffix in lobes_of(volume_object):
        irradiance = _grid(b, light, "irradiance" + suffix, is_coloured(volume_object))
        mean = irradiance
        if is_coloured(volume_object):
            mean = b.vector("DOT_PRODUCT", irradiance, (1 / 3, 1 / 3, 1 / 3))
            geometry = _stored(b, geometry, "photic_rgb" + suffix, irradiance, place.outputs[0], scale)
        flux = b.vector("SCALE", _grid(b, light, "direction" + suffix, True), scale=mean)
        geometry = _stored(b, geometry, "photic_flux" + suffix, flux, place.outputs[0], scale)
    b.plug(geometry, b.node("NodeGroupOutput").inputs["Geometry"])
    return tree


def build_sample(volume_object, late):
    """(Re)builds the group that reads the attributes; its outputs are those of sample.build_group."""
    lobes = lobes_of(volume_object)
    sockets = [socket for out, _ in lobes
               for socket in (("NodeSocketVector", "Flux" + out, None), ("NodeSocketColor", "Colour" + out, None))]
    tree = groups.fresh(groups.named(SAMPLE, volume_object), [], [*sockets, ("NodeSocketVector", "Position", None)])
    b = build.Builder(tree)
    in_object = b.node("ShaderNodeTexCoord", "Position in the volume", object=volume_object).outputs["Object"]
    result = b.node("NodeGroupOutput")
    for out, suffix in lobes:
        b.plug(_attribute(b, "photic_flux" + suffix), result.inputs["Flux" + out])
        colour = (1.0, 1.0, 1.0, 1.0)
        if is_coloured(volume_object):
            rgb = _attribute(b, "photic_rgb" + suffix)
            mean = b.math("MAXIMUM", b.vector("DOT_PRODUCT", rgb, (1 / 3, 1 / 3, 1 / 3)), 1e-6)
            colour = b.vector("SCALE", rgb, scale=b.math("DIVIDE", 1.0, mean))
        b.plug(colour, result.inputs["Colour" + out])
    b.plug(b.vector("SUBTRACT", in_object, late), result.inputs["Position"])
    return tree


def add(obj, light_group):
    """Gives an object the modifier, after all others."""
    modifier = obj.modifiers.new(MODIFIER, "NODES")
    modifier.node_group = light_group
    modifier.show_expanded = False


def remove(obj):
    """Takes the modifier away."""
    for modifier in [m for m in obj.modifiers if m.type == "NODES" and m.node_group and graph.is_ours(m.node_group)]:
        obj.modifiers.remove(modifier)


def lobes_of(volume_object):
    """(suffix of outputs, suffix of grids) of each lobe that the volume has."""
    names = {grid.name for grid in volume_object.data.grids}
    return [(out, suffix) for out, suffix in reversed(LOBES) if "irradiance" + suffix in names]


def is_coloured(volume_object):
    return any(grid.name == "irradiance" and grid.channels == 3 for grid in volume_object.data.grids)


def _grid(b, light, name, is_vector):
    node = b.node("GeometryNodeGetNamedGrid", data_type="VECTOR" if is_vector else "FLOAT")
    node.inputs["Name"].default_value = name
    node.inputs["Remove"].default_value = False
    b.plug(light.outputs["Geometry"], node.inputs["Volume"])
    return node.outputs["Grid"]


def _stored(b, geometry, name, grid, place, scale):
    """The geometry with an attribute at its points: a grid of vectors, looked up trilinearly, times `scale`."""
    found = b.node("GeometryNodeSampleGrid", data_type="VECTOR")
    b.plug(grid, found.inputs["Grid"])
    b.plug(place, found.inputs["Position"])
    node = b.node("GeometryNodeStoreNamedAttribute", data_type="FLOAT_VECTOR", domain="POINT")
    node.inputs["Name"].default_value = name
    b.plug(geometry, node.inputs["Geometry"])
    b.plug(b.vector("SCALE", found.outputs["Value"], scale=scale), node.inputs["Value"])
    return node.outputs["Geometry"]


def _attribute(b, name):
    return b.node("ShaderNodeAttribute", attribute_type="GEOMETRY", attribute_name=name).outputs["Vector"]
