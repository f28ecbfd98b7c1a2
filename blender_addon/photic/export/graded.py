# SPDX-License-Identifier: GPL-3.0-or-later
"""[[medium]] tables of what was collected with an index that varies, and what is wrong with it, in words."""
import dataclasses
import os

import numpy
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ..core import graded, mesh_file, roles
from ..core.program import BakerError

METHODS = ("wavefront", "photons")      # that follow light through such media; the first by itself
VERTICES_LOOKED_AT = 64                 # of a body, to find out what it stands in


@dataclasses.dataclass
class Media:
    """Tables, of which item by whose faces they are bounded, and the samples that have to be made before a bake."""
    tables: list = dataclasses.field(default_factory=list)      # (table, object to blame)
    of_item: dict = dataclasses.field(default_factory=dict)     # id of an item with faces -> its medium's name
    volumes: list = dataclasses.field(default_factory=list)


def items_of(scene):
    return [item for item in scene.items if item.is_graded()]


def method_for(chosen, scene):
    """The baker's method. Raises BakerError for one that knows no such media."""
    bent = items_of(scene)
    if not bent or chosen in METHODS:
        return chosen
    if chosen != "auto":
        raise BakerError(f"The method {chosen.capitalize()} can't bend light in '{bent[0].name}', whose index varies; choose Method > "
                         "Automatic, Wavefront or Photons, or make it a sharp body", bent[0].object_name)
    return METHODS[0]


def rim_for(scene):
    """From which share of the largest difference of n^2 on light counts as bent; None: as the method has it.

    A wide Gaussian reaches far around a body, where the renderer's own sun shines too: what counts then begins at the face, and
    the rest is left to the sun. Not of thin walls, which keep too little of their index to be told from a rim."""
    bent = items_of(scene)
    if not bent or any(item.graded.kind != graded.SMOOTHED for item in bent) or not any(map(_is_wide, bent)):
        return None
    if any(item.mesh.thickness() < graded.THICK * graded.smooth_metres(item.graded, *item.mesh.bounds()) for item in bent):
        return None
    contrasts = [abs(item.mean_ior() ** 2 - 1) for item in bent]
    return graded.RIM * min(contrasts) / max(contrasts) if max(contrasts) > 0 else None


def _is_wide(item):
    low, high = item.mesh.bounds()
    return graded.smooth_metres(item.graded, low, high) > graded.WIDE * float((high - low).max())


def check(settings, scene):
    """Raises BakerError for what can't be baked; returns what will not be as it seems, (object's name, words) each."""
    bent = items_of(scene)
    if not bent:
        return []
    method_for(settings.method, scene)
    if settings.shear:
        raise BakerError(f"'{bent[0].name}' has an index that varies, which leaning voxels do not know; switch Domain > Lean with the "
                         "light off", bent[0].object_name)
    said = []
    for item in bent:
        _check_mesh(item)
        if item.graded.kind == graded.FILE:
            _check_file(item)
        said += _within(item, scene)
    return said + _overlaps(bent) + _soft(scene)


def _check_mesh(item):
    closed = item.mesh.closed
    if item.graded.kind == graded.SMOOTHED and not closed:
        raise BakerError(f"'{item.name}' has holes, and nothing can be filled with samples that has no inside; close the mesh, or "
                         "let light go through it as a sharp body", item.object_name)
    if item.graded.faces and not closed:
        raise BakerError(f"'{item.name}' has holes: with Sharp faces the volume is what lies inside of its mesh; close it, or "
                         "switch Sharp faces off", item.object_name)


def _check_file(item):
    path = item.graded.file
    if not path:
        raise BakerError(f"'{item.name}' has no index volume yet; choose its File in Object Properties > Photic", item.object_name)
    if not os.path.isfile(path):
        raise BakerError(f"The index volume '{path}' of '{item.name}' is gone; choose its File anew in Object Properties > Photic",
                         item.object_name)


def _within(item, scene):
    """Sharp glass and water are what is there, wherever a graded body reaches into them."""
    said = []
    some = item.mesh.positions[::max(1, len(item.mesh.positions) // VERTICES_LOOKED_AT)]
    for other in scene.of(roles.REFRACTOR):
        if other.is_graded():
            continue
        low, high = other.mesh.bounds()
        near = some[((some[:, :2] >= low[:2]) & (some[:, :2] <= high[:2])).all(axis=1)]
        if not len(near):
            continue
        tree = BVHTree.FromPolygons(other.mesh.positions.tolist(), other.mesh.triangles.tolist())
        covered = sum(_faces_above(tree, place, high[2] - low[2] + 1.0) % 2 for place in near)
        if not covered:
            continue
        what = f"the glass '{other.name}'" if other.is_body() else f"the water '{other.name}'"
        if covered == len(some):
            raise BakerError(f"'{item.name}' lies in {what}, which is what is there, so that its index would bend no light; move it "
                             "out, or make it a sharp body", item.object_name)
        said.append((item.object_name, f"'{item.name}' reaches into {what}, which is what is there: its index bends light outside of it "
                                       "only"))
    return said


def _faces_above(tree, place, step):
    """How many faces lie straight above a place."""
    count, origin = 0, Vector(place)
    while count < 64:
        hit, _, _, _ = tree.ray_cast(origin, Vector((0, 0, 1)))
        if hit is None:
            return count
        count, origin = count + 1, hit + Vector((0, 0, 1e-6 * step))
    return count


def _overlaps(bent):
    """Bodies that are smoothed together are one; of others the first is what is there."""
    said = []
    for i, first in enumerate(bent):
        for second in bent[i + 1:]:
            if first.graded.kind == second.graded.kind == graded.SMOOTHED:
                continue
            (low, high), (other_low, other_high) = first.mesh.bounds(), second.mesh.bounds()
            if (low < other_high).all() and (high > other_low).all():
                inner, outer = sorted((first, second), key=_size)
                said.append((inner.object_name, f"the boxes of '{inner.name}' and '{outer.name}' overlap: where both have an index, "
                                                f"that of '{inner.name}' is what is there"))
    return said


def _soft(scene):
    if rim_for(scene) is not None:
        return []
    return [(item.object_name, f"the soft faces of '{item.name}' reach some {1000 * 2 * item.graded.smooth:.3g} mm around it, where "
                               "Blender's own sun shines too: a ring around its shadow is too bright; make Soft faces smaller")
            for item in items_of(scene) if item.graded.kind == graded.SMOOTHED and _is_wide(item)]


def _size(item):
    low, high = item.mesh.bounds()
    return float((high - low).prod())


def words(item):
    """What an item is baked as."""
    low, high = item.mesh.bounds()
    kind = item.graded.kind
    behind = ", behind its own faces" if item.graded.faces else ""
    if kind == graded.SMOOTHED:
        size, smooth = graded.voxel_size(item.graded, low, high), graded.smooth_metres(item.graded, low, high)
        return (f"'{item.name}' is baked as samples of its index of {1000 * size:.3g} mm, its faces "
                f"{1000 * graded.FACE_WIDTH * smooth:.3g} mm wide")
    if kind == graded.FILE:
        return f"'{item.name}' is baked as the index volume '{os.path.basename(item.graded.file)}'{behind}"
    return f"'{item.name}' is baked as a {'Luneburg' if kind == graded.LENS else 'rod'} lens{behind}"


def media(scene, folder):
    """Tables for the baker, the smaller first, which is what is there; meshes of bodies are written into `folder`."""
    made = Media()
    bent = sorted(items_of(scene), key=_size)
    for group in _smoothed(bent):
        _add_smoothed(group, folder, made, scene)
    for item in bent:
        if item.graded.kind != graded.SMOOTHED:
            name = f"index of {item.name}"
            made.tables.append(({"name": name, **_table(item)}, item.object_name))
            if item.graded.faces:
                made.of_item[id(item)] = name
    made.tables.sort(key=lambda made_of: [item.object_name for item in bent].index(made_of[1]))
    return made


def _smoothed(bent):
    bodies = [item for item in bent if item.graded.kind == graded.SMOOTHED]
    boxes = []
    for item in bodies:
        low, high = item.mesh.bounds()
        reach = graded.REACH * graded.smooth_metres(item.graded, low, high) + 2 * graded.voxel_size(item.graded, low, high)
        boxes.append((low - reach, high + reach))
    return [[bodies[i] for i in group] for group in graded.groups(boxes)]


def _add_smoothed(group, folder, made, scene):
    """Bodies that touch, the smallest first: one medium."""
    size = min(graded.voxel_size(item.graded, *item.mesh.bounds()) for item in group)
    smooth = min(graded.smooth_metres(item.graded, *item.mesh.bounds()) for item in group)
    solids = [graded.Solid(item.object_name, mesh_file.write_ply(folder, item.mesh.positions, item.mesh.triangles),
                           graded.channel_indices(item.optics.ior, item.abbe), tuple(item.optics.medium.absorption))
              for item in reversed(group)]
    volumes = graded.volumes(folder, solids, size, smooth)
    made.volumes += volumes
    files = [volume.target.name for volume in volumes]
    absorbs = any(any(solid.absorption) for solid in solids)
    scattering = _scattering(group, scene)
    table = {"name": "index of " + " and ".join(item.name for item in group), "index": files if len(files) > 1 else files[0],
             **({"absorption_volume": files[0]} if absorbs else {}), **scattering}
    made.tables.append((table, group[0].object_name))


def _scattering(group, scene):
    """Of all bodies that share their samples: that of the largest."""
    mediums = [item.optics.medium for item in group]
    if any(medium.scattering != mediums[-1].scattering for medium in mediums):
        note = (group[0].object_name, f"'{group[0].name}' touches '{group[-1].name}', and is baked with its scattering")
        if note not in scene.notes:
            scene.notes.append(note)
    medium = mediums[-1]
    return {"scattering": list(medium.scattering), "anisotropy": medium.anisotropy} if any(medium.scattering) else {}


def _table(item):
    bent, medium = item.graded, item.optics.medium
    if bent.kind == graded.LENS:
        index = graded.lens(item.object_name, item.mesh.positions)
    elif bent.kind == graded.ROD:
        axis = numpy.array(item.matrix)[:3, 2]
        index = graded.rod(item.object_name, item.mesh.positions, axis / numpy.linalg.norm(axis), item.mean_ior(), bent)
    else:
        place = graded.placement(item.matrix, item.object_name)
        index = {"file": bent.file, **({"grid": bent.grid} if bent.grid else {}), **place}
        if bent.absorption_grid:
            absorption = {"absorption_volume": {"file": bent.file, "grid": bent.absorption_grid, **place}}
            scattered = {"scattering": list(medium.scattering), "anisotropy": medium.anisotropy} if any(medium.scattering) else {}
            return {"index": index, **absorption, **scattered}
    if not medium.present():
        return {"index": index}
    scattered = {"scattering": list(medium.scattering), "anisotropy": medium.anisotropy} if any(medium.scattering) else {}
    return {"index": index, "absorption": list(medium.absorption), **scattered}
