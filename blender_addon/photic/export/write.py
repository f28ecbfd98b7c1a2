# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns what was collected into a scene file with its meshes."""
import dataclasses
import pathlib

import numpy

from ..core import height_file, mesh_file, roles, toml_text
from ..core.program import BakerError
from . import collect, graded


def _box_of(settings, scene):
    """Keys of [domain]: the artist's box, or that the baker finds it. Raises BakerError without anything to bake."""
    if settings.domain_from == "CUSTOM":
        low, high = numpy.array(settings.domain_min), numpy.array(settings.domain_max)
        if not (high > low).all():
            raise BakerError(f"The domain's box is empty: from {tuple(low)} to {tuple(high)}; draw it larger")
        return {"min": low.tolist(), "max": high.tolist()}
    if scene.of(roles.REFRACTOR, roles.MIRROR):
        return {"fit": "light"}
    if scene.rough:
        name, words = scene.rough[0]
        raise BakerError(f"Nothing in the scene bends light: {words}", name)
    raise BakerError("Nothing in the scene bends light: add water or glass (a material with transmission), a mirror, "
                     "or choose a role in Object Properties > Photic")


def scene_text(settings, scene, folder, methods):
    """A SceneText for the baker; meshes are written into `folder`. `methods` is the catalogue, for their own options."""
    if not scene.lights:
        raise BakerError("There is no light in the scene that is baked; add a Sun, or a lamp")
    box = _box_of(settings, scene)
    for note in graded.check(settings, scene):
        if note not in scene.notes:
            scene.notes.append(note)
    bent = graded.media(scene, folder)
    text = toml_text.SceneText()
    text.volumes = bent.volumes
    sized = {"voxel_size": float(f"{settings.voxel_size:.6g}")} if settings.size_by == "VOXEL" else {"resolution": settings.resolution}
    text.add("[domain]", {**box, **sized, "shear": "light" if settings.shear else "none"})
    for name, table in scene.lights:
        text.add("[[light]]", table, name)
    media = _media(scene, bent)
    for table, owner in media.tables:
        text.add("[[medium]]", table, owner)
    for item in scene.items:
        if item.is_graded() and not item.is_body():
            continue
        if item.grid:
            text.add("[[surface]]", _height_field(item, folder, media), item.object_name)
            continue
        # Without the flag the baker keeps the edges that the file's normals say.
        creased = item.is_creased()
        file = mesh_file.write_ply(folder, item.mesh.positions, item.mesh.triangles, item.mesh.normals if creased else None)
        shape = {"name": item.name, "file": file, **({} if creased else {"smooth": item.mesh.smooth_share >= 0.5})}
        if item.role == roles.REFRACTOR:
            text.add("[[surface]]", {**shape, "kind": "mesh", **_refractor(item, media)}, item.object_name)
        elif item.role == roles.MIRROR:
            text.add("[[surface]]", {**shape, "kind": "mesh", "event": "mirror", "colour": list(item.optics.colour)}, item.object_name)
        else:
            text.add("[[object]]", {**shape, "role": item.role.lower()}, item.object_name)
    if scene.medium.present() and not media.tables:
        text.add("[medium]", _attenuation(scene.medium))
    _bake_tables(settings, scene, text, methods)
    return text


@dataclasses.dataclass
class _Media:
    """[[medium]] tables, and which item names which of them. Without closed bodies there are none: numbers will do."""
    tables: list = dataclasses.field(default_factory=list)      # (table, object to blame)
    of_item: dict = dataclasses.field(default_factory=dict)


def _media(scene, bent):
    """Where bodies overlap, the smaller one is what is there: the ice in the water, the wine that reaches into its glass.
    `bent` has those whose index varies."""
    media = _Media(of_item=dict(bent.of_item))
    bodies = [item for item in scene.items if item.is_body()]
    if not bodies and not bent.tables:
        return media

    def box(item):
        low, high = item.mesh.bounds()
        return float((high - low).prod())

    water = next((item for item in scene.items if item.is_open()), None)
    if water is not None:
        media.tables.append(({"name": "water", **_index(water), **_attenuation(scene.medium)}, water.object_name))
    priorities = {}
    for priority, item in enumerate(sorted(bodies, key=box, reverse=True), start=1):
        if id(item) in bent.of_item:
            priorities[bent.of_item[id(item)]] = {"priority": priority}
            continue
        name = f"inside of {item.name}"
        media.tables.append(({"name": name, **_index(item), **_attenuation(item.optics.medium), "priority": priority}, item.object_name))
        media.of_item[id(item)] = name
    media.tables += [({**table, **priorities.get(table["name"], {})}, owner) for table, owner in bent.tables]
    return media


def _index(item):
    ior, abbe = item.optics.ior, item.abbe
    if isinstance(ior, tuple):
        return {"ior": [float(n) for n in ior]}
    return {"abbe": [float(ior), abbe]} if abbe > 0 else {"ior": float(ior)}


def _attenuation(medium):
    if not medium.present():
        return {}
    scattered = {"scattering": list(medium.scattering), "anisotropy": medium.anisotropy} if any(medium.scattering) else {}
    return {"absorption": list(medium.absorption), **scattered}


def _refractor(item, media):
    """What lies behind a refractor, and what light does at it. Of an open one only what goes through is baked."""
    if item.is_body():
        return {"inside": media.of_item[id(item)], "event": "both"}
    if media.tables:
        return {"inside": "water", "event": "refract"}
    return {"event": "refract", "ior_above": 1.0, "ior_below": item.mean_ior()}


def _height_field(item, folder, media):
    grid = item.grid
    moved = {"displacement": True} if grid.moves else {}
    return {"name": item.name, "kind": "height_field", "file": height_file.write_exr(folder, grid.heights, grid.moves),
            "texels": "corners", **moved, "size": list(grid.size), "center": list(grid.center), "outside": "none",
            "event": "refract", **({"below": "water"} if media.tables else {"ior_above": 1.0, "ior_below": item.mean_ior()})}


def has_density(scene):
    """Whether the baker says where the medium is. A graded body alone has no surface that it could be below: the light that
    has been bent is shown in all of the haze."""
    bending = scene.of(roles.REFRACTOR)
    return scene.medium.present() and not (bending and all(item.is_graded() and not item.is_body() for item in bending))


def _bake_tables(settings, scene, text, methods):
    grids = ["irradiance", "direction"] + [grid for grid in ("caustic", "arrival_time") if getattr(settings, f"grid_{grid}")]
    if has_density(scene):
        grids.append("density")
    points = {} if settings.quadrature == "AUTO" else {"quadrature": int(settings.quadrature)}
    text.add("[bake]", {"method": graded.method_for(settings.method, scene), "grids": grids, "where": settings.where.lower(),
                        "band": settings.band, **points, "tolerance": settings.tolerance, "prefilter": settings.prefilter})
    for method in methods:
        chosen = getattr(settings, f"options_{method.name}", None)
        if chosen is None:
            continue
        changed = {option.name: getattr(chosen, option.name) for option in method.options
                   if chosen.is_property_set(option.name)}
        if method.name == graded.METHODS[0] and "rim" not in changed and graded.rim_for(scene) is not None:
            changed["rim"] = graded.rim_for(scene)
        if changed:
            text.add(f"[bake.{method.name}]", changed)


def write(text, folder, name):
    """Writes `name`.toml, only when it differs from what is there; returns its path."""
    target = pathlib.Path(folder) / f"{name}.toml"
    content = str(text)
    try:
        if target.read_text(encoding="utf-8") == content:
            return target
    except OSError:
        pass
    target.write_text(content, encoding="utf-8")
    return target
