# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns what was collected into a scene file with its meshes."""
import pathlib

import numpy

from ..core import height_file, mesh_file, roles, toml_text
from ..core.program import BakerError
from . import collect


def domain_of(settings, scene):
    """Box [m] that will be baked: the artist's, or the automatic one. Raises BakerError without either."""
    if settings.domain_from == "CUSTOM":
        low, high = numpy.array(settings.domain_min), numpy.array(settings.domain_max)
        if not (high > low).all():
            raise BakerError(f"The domain's box is empty: from {tuple(low)} to {tuple(high)}; draw it larger")
        return low, high
    box = collect.automatic_domain(scene, settings.resolution)
    if box is None and scene.rough:
        name, words = scene.rough[0]
        raise BakerError(f"Nothing in the scene bends light: {words}", name)
    if box is None:
        raise BakerError("Nothing in the scene bends light: add water or glass (a material with transmission), a mirror, "
                         "or choose a role in Object Properties > Photic")
    return box


def scene_text(settings, scene, folder, methods):
    """A SceneText for the baker; meshes are written into `folder`. `methods` is the catalogue, for their own options."""
    if not scene.lights:
        raise BakerError("There is no sun in the scene; add a light of type Sun")
    low, high = domain_of(settings, scene)
    text = toml_text.SceneText()
    sized = {"voxel_size": float(f"{settings.voxel_size:.6g}")} if settings.size_by == "VOXEL" else {"resolution": settings.resolution}
    text.add("[domain]", {"min": low.tolist(), "max": high.tolist(), **sized,
                          "shear": "light" if settings.shear else "none"})
    for name, table in scene.lights:
        text.add("[[light]]", table, name)
    for item in scene.items:
        if item.grid:
            text.add("[[surface]]", _height_field(item, folder), item.object_name)
            continue
        file = mesh_file.write_ply(folder, item.mesh.positions, item.mesh.triangles)
        smooth = item.mesh.smooth_share >= 0.5
        if item.role == roles.REFRACTOR:
            text.add("[[surface]]", {"name": item.name, "kind": "mesh", "file": file, "smooth": smooth, "event": "refract",
                                     "ior_above": 1.0, "ior_below": float(item.optics.ior)}, item.object_name)
        elif item.role == roles.MIRROR:
            text.add("[[surface]]", {"name": item.name, "kind": "mesh", "file": file, "smooth": smooth, "event": "reflect"},
                     item.object_name)
        else:
            text.add("[[object]]", {"name": item.name, "file": file, "smooth": smooth, "role": item.role.lower()},
                     item.object_name)
    if scene.medium.present():
        text.add("[medium]", {"absorption": list(scene.medium.absorption), "scattering": list(scene.medium.scattering),
                              "anisotropy": scene.medium.anisotropy})
    _bake_tables(settings, scene, text, methods)
    return text


def _height_field(item, folder):
    grid = item.grid
    moved = {"displacement": True} if grid.moves else {}
    return {"name": item.name, "kind": "height_field", "file": height_file.write_exr(folder, grid.heights, grid.moves),
            "texels": "corners", **moved, "size": list(grid.size), "center": list(grid.center), "outside": "none",
            "event": "refract", "ior_above": 1.0, "ior_below": float(item.optics.ior)}


def _bake_tables(settings, scene, text, methods):
    grids = ["irradiance", "direction"] + [grid for grid in ("caustic", "arrival_time") if getattr(settings, f"grid_{grid}")]
    if scene.medium.present():
        grids.append("density")
    points = {} if settings.quadrature == "AUTO" else {"quadrature": int(settings.quadrature)}
    text.add("[bake]", {"method": settings.method, "grids": grids, "where": settings.where.lower(), "band": settings.band,
                        **points, "tolerance": settings.tolerance, "prefilter": settings.prefilter})
    for method in methods:
        chosen = getattr(settings, f"options_{method.name}", None)
        if chosen is None:
            continue
        changed = {option.name: getattr(chosen, option.name) for option in method.options
                   if chosen.is_property_set(option.name)}
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
