# SPDX-License-Identifier: GPL-3.0-or-later
"""Showing a baked volume: the volume object, its groups, wrapped receivers, quiet suns; and all of it undone."""
import os
import re

import bpy
import mathutils
import numpy

from .. import compat
from ..core import atlas as atlas_file
from ..core import baked_files, roles
from ..core.program import BakerError
from ..export import collect, lights
from ..nodes import graph, groups, medium, receiver, sample, vertices, wrap

LATE = "photic_late"        # custom property of volume objects [m]
VOXELS_PER_STEP = 2.0      # of Cycles; its steps are jittered: longer ones make thin sheets of light noisy
DENSE_EDGE = 0.2            # voxels: light looked up at vertices that are so near is within 1 % of light looked up at pixels


def load(context):
    """The volume object with the baked file; made when missing. Raises BakerError when the file is gone or no volume."""
    scene, settings = context.scene, context.scene.photic
    if not settings.volume_file:
        raise BakerError("Nothing has been baked yet; press Bake")
    path = bpy.path.abspath(settings.volume_file)
    if not os.path.exists(path):
        path = _newer(settings)
    if not path:
        raise BakerError(f"The volume '{bpy.path.abspath(settings.volume_file)}' is gone; bake again, or set where it is and press Load")
    obj = settings.volume
    if obj is None or obj.name not in scene.objects or obj.type != "VOLUME":
        data = bpy.data.volumes.new(f"{scene.name} light")
        obj = bpy.data.objects.new(data.name, data)
        compat.mark(obj)
        compat.mark(data)
        scene.collection.objects.link(obj)
        settings.volume = obj
        obj[LATE] = (0.0, 0.0, 0.0)
    data = obj.data
    data.grids.unload()
    data.is_sequence = False
    data.filepath = settings.volume_file
    data.render.space = "WORLD"         # or an object's scale changes the density
    data.render.clipping = 0.0          # or dim light is gone
    data.render.precision = "FULL"
    if not data.grids.load():
        raise BakerError(f"Blender cannot read '{path}': {data.grids.error_message}")
    _place(obj)
    if settings.sequence_count:         # only now: a volume that was never evaluated looks for frame 0
        data.is_sequence = True
        data.frame_start, data.frame_duration = settings.sequence_start, settings.sequence_count
        data.frame_offset = settings.sequence_start - 1
        context.view_layer.update()
    obj.hide_render = True
    obj.display_type = "BOUNDS"
    return obj


def _newer(settings):
    """Where the volume is gone: that of the newest bake beside it, which another file may have made; "" without one."""
    gone = baked_files.of(bpy.path.abspath(settings.volume_file))
    newest = baked_files.newest(gone.folder, gone.stem) if gone else None
    if newest is None or bool(settings.sequence_count) != bool(re.search(r"\.\d+\.vdb$", str(newest.files()[-1]))):
        return ""
    was = gone.name
    for name in ("volume_file", "atlas_file"):
        setattr(settings, name, getattr(settings, name).replace(was, newest.name))
    path = bpy.path.abspath(settings.volume_file)
    return path if os.path.exists(path) else ""


def _place(obj):
    """Moves the object back by the half voxel, along its own axes, that the engines show its grids late by.

    The object's frame is then not the light's: (0, 0, 0) of the light is at obj[LATE] in it, wherever it is moved and turned.
    """
    index_axes = obj.data.grids[0].matrix_object.to_3x3()
    late = index_axes @ mathutils.Vector((0.5, 0.5, 0.5)) if compat.half_voxel_late() else mathutils.Vector()
    change = mathutils.Vector(obj.get(LATE, (0.0, 0.0, 0.0))) - late
    obj.matrix_basis = obj.matrix_basis @ mathutils.Matrix.Translation(change)
    obj[LATE] = tuple(late)


def update_numbers(settings):
    """After Strength, Match Cycles or Light in the water was changed."""
    obj = settings.volume
    if obj is None:
        return
    numbers = numbers_of(settings)
    for kind in ("Receiver", vertices.RECEIVER):
        tree = bpy.data.node_groups.get(groups.named(kind, obj))
        if tree:
            receiver.set_numbers(tree, settings.level, numbers["under_water"], numbers["strength"])
    tree = bpy.data.node_groups.get(groups.named("Medium", obj))
    if tree:
        medium.set_numbers(tree, **numbers)
    if settings.previewing:
        obj.hide_render = not shows_medium(settings)


def shows_medium(settings):
    return settings.show_medium and any(settings.baked_scattering)


def numbers_of(settings):
    """Radiance that leaves index n towards air is divided by n^2; renderers don't, so the light in the water is."""
    ior = settings.ior if settings.ior > 0 else 1.0
    return {"under_water": 1 / ior ** 2 if settings.match_cycles else 1.0, "strength": settings.strength}


def show(context):
    """Wraps the receivers and shows the medium. Returns what could not be shown, in words. Doing it twice is doing it once."""
    scene, settings = context.scene, context.scene.photic
    volume_object = settings.volume or load(context)
    layout = atlas_file.read(bpy.path.abspath(settings.atlas_file))
    sequence = (settings.sequence_start, settings.sequence_count) if settings.sequence_count else None
    numbers = numbers_of(settings)
    sample_group = sample.build_group(volume_object, layout, tuple(volume_object[LATE]), sequence)
    receiver_group = receiver.build_group(volume_object, sample_group, settings.level, **numbers)
    _dress_volume(settings, volume_object, layout)

    hide(context, keep_volume=True)
    skipped = []
    materials = {obj: list(_materials_of(obj, skipped)) for obj in scene.objects
                 if collect.role_of(obj) in (roles.RECEIVER, roles.MOVABLE)}
    by_vertices = _dense(context, materials, DENSE_EDGE * min(layout.voxel_size))
    if by_vertices:
        light_group = vertices.build_light(volume_object, layout.scale)
        vertex_group = receiver.build_group(volume_object, vertices.build_sample(volume_object, tuple(volume_object[LATE])),
                                            settings.level, **numbers, kind=vertices.RECEIVER)
        for obj in by_vertices:
            vertices.add(obj, light_group)
    at_vertices = {material for obj in by_vertices for material in materials[obj]}
    for material in {material for of_one in materials.values() for material in of_one}:
        wrap.wrap(material, vertex_group if material in at_vertices else receiver_group)
    _see_through(scene)
    _quiet_suns(scene, skipped)
    _quiet_caustics(scene)
    _march(scene)
    settings.previewing = True
    return skipped


def _dense(context, materials, longest):
    """The receivers, of those whose materials are given, that look light up at their vertices: a material does the same on
    all objects that have it."""
    settings = context.scene.photic
    if settings.look_up == "PIXELS" or not vertices.can_look_up(settings.volume):
        return []
    depsgraph = context.evaluated_depsgraph_get()
    limit = longest if settings.look_up == "AUTO" else float("inf")
    chosen = {obj for obj in materials if vertices.is_dense(obj, depsgraph, limit)}
    while True:
        others = {material for obj, of_one in materials.items() if obj not in chosen for material in of_one}
        kept = {obj for obj in chosen if not others.intersection(materials[obj])}
        if kept == chosen:
            return list(chosen)
        chosen = kept


def _dress_volume(settings, volume_object, layout):
    found = roles.Medium(tuple(settings.baked_absorption), tuple(settings.baked_scattering), settings.baked_anisotropy)
    material = medium.build_material(volume_object, found, layout, settings.has_density, **numbers_of(settings))
    data = volume_object.data
    if not data.materials:
        data.materials.append(material)
    data.materials[0] = material
    data.render.step_size = VOXELS_PER_STEP * min(layout.voxel_size)
    volume_object.hide_render = not shows_medium(settings)


def _materials_of(obj, skipped):
    """An object's materials that can be wrapped; one without any gets a plain one."""
    if obj.data is not None and len(obj.material_slots) == 0:
        if obj.data.library or obj.data.override_library:
            skipped.append(f"'{obj.name}' is linked and has no material; it shows no light")
            return
        obj.data.materials.append(wrap.plain_material())
        obj.data["photic_slot"] = 1
    for slot in obj.material_slots:
        if slot.material is None:
            slot.material = wrap.plain_material()
        if slot.material.library:
            local = _local_copy(obj, slot)
            if local is None:
                skipped.append(f"the material '{slot.material.name}' of '{obj.name}' is linked from another file; make it local "
                               "to see light on it")
                continue
        yield slot.material


def _local_copy(obj, slot):
    """A linked material can't be changed: the object (local, or overridden) gets a copy of its own; None when it can't."""
    linked = slot.material
    name = f"{linked.name} (Photic)"
    copy = next((m for m in bpy.data.materials if m.library is None and m.get("photic_copy_of") == linked.name), None)
    if copy is None:
        copy = linked.copy()
        copy.name = name
        copy["photic_copy_of"] = linked.name
    try:
        slot.link = "OBJECT"
        slot.material = copy
    except (AttributeError, RuntimeError):
        pass
    return copy if slot.material == copy else None


def hide(context, keep_volume=False):
    """Takes the preview away: materials, suns and settings as they were."""
    settings = context.scene.photic
    for material in list(bpy.data.materials):
        if material.library is None and not graph.is_ours(material):
            wrap.unwrap(material)
            _restore(material)
    for obj in context.scene.objects:
        _undress(obj)
        vertices.remove(obj)
    for copy in [m for m in bpy.data.materials if "photic_copy_of" in m.keys()]:
        bpy.data.materials.remove(copy)
    plain = bpy.data.materials.get(wrap.plain_material().name)
    bpy.data.materials.remove(plain)
    for light in bpy.data.lights:
        _restore(light)
    _restore(context.scene)
    if not keep_volume and settings.volume:
        settings.volume.hide_render = True
    settings.previewing = False


def _undress(obj):
    for slot in obj.material_slots:
        material = slot.material
        if material is None:
            continue
        if material.name == wrap.plain_material().name:
            slot.material = None
        elif "photic_copy_of" in material.keys():
            slot.material = None
            slot.link = "DATA"
    if obj.data is not None and "photic_slot" in obj.data.keys():
        if len(obj.data.materials) and obj.data.materials[0] is None:
            obj.data.materials.pop(index=0)
        del obj.data["photic_slot"]


def _set(item, owner, path, name, value):
    """Changes item.path.name and remembers in the item what it was."""
    if not hasattr(owner, name) or getattr(owner, name) == value:
        return
    before = item["photic_settings"].to_dict() if "photic_settings" in item.keys() else {}
    before[f"{path}.{name}"] = getattr(owner, name)
    item["photic_settings"] = before
    setattr(owner, name, value)


def _restore(item):
    if "photic_settings" not in item.keys():
        return
    for key, value in item["photic_settings"].to_dict().items():
        path, _, name = key.rpartition(".")
        owner = getattr(item, path) if path else item
        if hasattr(owner, name):
            setattr(owner, name, type(getattr(owner, name))(value))
    del item["photic_settings"]


def _quiet_suns(scene, skipped):
    """The sun's own path-traced caustics would be counted twice, and are noise."""
    for obj in scene.objects:
        if obj.type != "LIGHT" or not lights.is_baked(obj):
            continue
        if obj.data.library:
            skipped.append(f"the light '{obj.name}' is linked: switch off its Multiple Importance in its own file")
        elif hasattr(obj.data, "cycles"):
            _set(obj.data, obj.data.cycles, "cycles", "use_multiple_importance_sampling", False)


def _quiet_caustics(scene):
    """Cycles' own noisy caustics, where a lamp is sampled at glass or metal that a bounced ray has hit."""
    if not hasattr(scene, "cycles"):
        return
    # Filter Glossy makes glass rough for light that has bounced, and lets the sun through it: 68 % too bright, as fireflies.
    _set(scene, scene.cycles, "cycles", "blur_glossy", 0.0)
    bending = [obj for obj in scene.objects if collect.role_of(obj) in (roles.REFRACTOR, roles.MIRROR)]
    if any(collect.role_of(obj) == roles.MIRROR for obj in bending):
        _set(scene, scene.cycles, "cycles", "caustics_reflective", False)
    if any((collect.optics_of(obj) or roles.Optics()).roughness > 0 for obj in bending if collect.role_of(obj) == roles.REFRACTOR):
        _set(scene, scene.cycles, "cycles", "caustics_refractive", False)


def _march(scene):
    """Cycles since 5.0 scatters along rays at random; a light volume is emission, which marching integrates without noise."""
    if hasattr(scene, "cycles"):
        _set(scene, scene.cycles, "cycles", "volume_biased", True)


def _see_through(scene):
    """EEVEE shows what lies behind water only when it is told to."""
    for name in compat.SCENE_SEE_THROUGH:
        _set(scene, scene.eevee, "eevee", name, True)
    for obj in scene.objects:
        if collect.role_of(obj) != roles.REFRACTOR:
            continue
        for slot in obj.material_slots:
            if slot.material and not slot.material.library:
                _set(slot.material, slot.material, "", compat.see_through(slot.material), True)
                if not _is_closed(obj):
                    wrap.make_thin(slot.material)


def _is_closed(obj):
    """Whether an object's mesh, before its modifiers, has no rim: glass, and not the surface of water."""
    mesh = obj.data
    if obj.type != "MESH" or not mesh.polygons or any(modifier.type == "OCEAN" for modifier in obj.modifiers):
        return False
    edges = numpy.empty(len(mesh.loops), dtype=numpy.int32)
    mesh.loops.foreach_get("edge_index", edges)
    return bool((numpy.bincount(edges) != 1).all())


def remove(context):
    """Everything of ours in this scene: the preview, the volume object, its groups, materials and images."""
    hide(context)
    settings = context.scene.photic
    obj, settings.volume = settings.volume, None
    settings.volume_file = settings.atlas_file = ""
    settings.sequence_count = 0
    if obj is None:
        return
    names = [groups.named(kind, obj) for kind in
             ("Receiver", "Medium", "Sample", vertices.RECEIVER, vertices.SAMPLE, vertices.LIGHT)]
    material = bpy.data.materials.get(groups.named("Medium", obj))
    data = obj.data
    bpy.data.objects.remove(obj)
    if data.users == 0:
        bpy.data.volumes.remove(data)
    if material:
        bpy.data.materials.remove(material)
    for name in names:
        tree = bpy.data.node_groups.get(name)
        if tree:
            bpy.data.node_groups.remove(tree)
    for image in [image for image in bpy.data.images if graph.is_ours(image) and image.users == 0]:
        bpy.data.images.remove(image)
