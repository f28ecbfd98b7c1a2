# SPDX-License-Identifier: GPL-3.0-or-later
"""Glass whose index of refraction varies: bodies that `photic voxelise` makes into samples, volumes of samples that are given,
and two lenses by formula (docs/scene.md, media whose index varies).
"""
import dataclasses
import hashlib
import json
import math
import pathlib
import re

import numpy

from . import toml_text
from .program import BakerError

SHARP, SMOOTHED, FILE, LENS, ROD = "SHARP", "SMOOTHED", "FILE", "LENS", "ROD"

VOXELS_ACROSS = 128         # of a body's longest side, where the artist says nothing
SMOOTH_VOXELS = 1.0         # deviation of the Gaussian over its faces, likewise
MOST_SMOOTH_VOXELS = 100.0  # that `photic voxelise` takes
FACE_WIDTH = 2.563          # deviations from 10 to 90 % of a face's jump
WIDE = 0.02                 # of a body's longest side: a Gaussian from which on its faces are seen as soft
THICK = 2.5                 # deviations: bodies that keep their index in the middle
RIM = 0.5                   # of the difference of n^2 that is left of it at a smoothed face
REACH = 4.0                 # deviations that a Gaussian is laid over
SAMPLES_FORM = 1            # grows when the same bodies are to be made into other samples
SHEAR = 1e-4                # cosine between axes up to which they count as upright
UNROUND = 0.02              # of the radius: facets and rounding
CHANNELS_NM = (611.4, 549.1, 464.3)     # of red, green and blue, as the baker has them
LINES_NM = {"F": 486.13, "d": 587.56, "C": 656.27}
SAMPLES = re.compile(r"\b[0-9a-f]{16}\.vdb\b")


@dataclasses.dataclass(frozen=True)
class Graded:
    """How light goes through one object, as the artist set it; lengths in metres, 0 where nothing was said."""
    kind: str
    voxel_size: float = 0.0
    smooth: float = 0.0         # deviation of the Gaussian over its faces
    file: str = ""              # absolute
    grid: str = ""              # of the index; "": the one that is found
    absorption_grid: str = ""   # "": the material's own absorption
    faces: bool = False         # light is refracted and reflected at the mesh too
    focus: float = 0.0          # of a rod: behind its face, within it


def voxel_size(graded, low, high):
    """Of a body's samples [m]: the artist's, or that which its longest side asks for."""
    return float(f"{graded.voxel_size or float((high - low).max()) / VOXELS_ACROSS:.4g}")


def smooth_metres(graded, low, high):
    """Deviation of the Gaussian over a body's faces [m]: the artist's, or a voxel."""
    return graded.smooth or SMOOTH_VOXELS * voxel_size(graded, low, high)


def channel_indices(ior, abbe):
    """(red, green, blue) of a glass that parts colours, or (n,). Cauchy's formula through an Abbe number, as the baker's."""
    if isinstance(ior, tuple):
        return tuple(map(float, ior))
    if abbe <= 0:
        return (float(ior),)
    inverse = {line: 1 / nm ** 2 for line, nm in LINES_NM.items()}
    b = (ior - 1) / abbe / (inverse["F"] - inverse["C"])
    return tuple(float(ior + b * (1 / nm ** 2 - inverse["d"])) for nm in CHANNELS_NM)


def placement(matrix, name):
    """`position`, `rotation` and `scale` of a scene file by a 4 x 4 world matrix. Raises BakerError for a sheared one."""
    axes, position = numpy.array(matrix, dtype=float)[:3, :3], numpy.array(matrix, dtype=float)[:3, 3]
    scale = numpy.linalg.norm(axes, axis=0)
    if not (scale > 0).all():
        raise BakerError(f"'{name}' has a scale of 0, which leaves its index volume no room; scale it up", name)
    if numpy.linalg.det(axes) < 0:
        scale[0] *= -1
    turned = axes / scale
    if numpy.abs(turned.T @ turned - numpy.eye(3)).max() > SHEAR:
        raise BakerError(f"'{name}' is sheared by the scale of its parents, and an index volume can be moved, turned and scaled "
                         "alone; clear the parent and keep the transform, or apply the parents' scale", name)
    level = math.hypot(turned[0, 0], turned[1, 0])
    if level > 1e-9:
        x, z = math.atan2(turned[2, 1], turned[2, 2]), math.atan2(turned[1, 0], turned[0, 0])
    else:       # straight up or down: one of the two turns does for both
        x, z = math.atan2(-turned[1, 2], turned[1, 1]), 0.0
    angles = (x, math.atan2(-turned[2, 0], level), z)
    return {"position": position.tolist(), "rotation": [math.degrees(a) for a in angles], "scale": scale.tolist()}


def lens(name, positions):
    """A Luneburg lens that fills a ball. Raises BakerError for what is no ball."""
    low, high = positions.min(axis=0), positions.max(axis=0)
    sides, center = high - low, (low + high) / 2
    radius = float(sides.mean()) / 2
    if sides.max() - sides.min() > 2 * UNROUND * radius or numpy.linalg.norm(positions - center, axis=1).max() > (1 + UNROUND) * radius:
        size = " x ".join(f"{side:.3g}" for side in sides)
        raise BakerError(f"'{name}' is no ball ({size} m), and a Luneburg lens is; scale it evenly, or use a sphere", name)
    return {"kind": "luneburg", "center": center.tolist(), "radius": radius}


def rod(name, positions, axis, ior, graded):
    """A rod lens along `axis` (unit), whose index falls towards its rim. Raises BakerError where it would fall to nothing."""
    along = positions @ axis
    length = float(along.max() - along.min())
    center = (positions.min(axis=0) + positions.max(axis=0)) / 2
    center = center + axis * ((along.max() + along.min()) / 2 - center @ axis)
    away = positions - center
    radius = float(numpy.linalg.norm(away - numpy.outer(away @ axis, axis), axis=1).max())
    focus = graded.focus or length
    g = math.pi / 2 / focus
    if g * radius >= 0.999:
        raise BakerError(f"'{name}' has a radius of {radius:.3g} m and should focus {focus:.3g} m behind its face, where its index would "
                         f"fall to nothing; choose a Focus of more than {1.01 * math.pi / 2 * radius:.3g} m, or make it thinner", name)
    cut = {} if graded.faces else {"radius": radius, "length": length}
    return {"kind": "selfoc", "center": center.tolist(), "axis": axis.tolist(), "n0": ior, "g": g, **cut}


# Voxelising

@dataclasses.dataclass(frozen=True)
class Solid:
    """A closed body that is made into samples."""
    owner: str                  # object to blame
    file: str                   # its mesh, in the folder of the scene file
    indices: tuple              # of one channel, or of three
    absorption: tuple = (0.0, 0.0, 0.0)


@dataclasses.dataclass(frozen=True)
class Volume:
    """Samples that the baker makes of bodies: a file named after what is in it, so that what is there need not be made."""
    owners: tuple
    table: pathlib.Path         # of the bodies, for `photic voxelise`
    target: pathlib.Path

    @property
    def arguments(self):
        return ("voxelise", str(self.table), "-o", str(self.target))

    @property
    def names(self):
        return " and ".join(f"'{owner}'" for owner in self.owners)

    def is_there(self):
        return self.target.exists()


def volumes(folder, solids, size, smooth):
    """One Volume, or three where a body parts colours; their tables are written. `size` and `smooth` in metres; of bodies that
    overlap the last one is there. Raises BakerError for a Gaussian that is too wide."""
    sigma = smooth / size
    if sigma > MOST_SMOOTH_VOXELS:
        raise BakerError(f"'{solids[0].owner}' is smoothed over {smooth:.3g} m with samples of {size:.3g} m; use samples of "
                         f"{smooth / MOST_SMOOTH_VOXELS:.3g} m or more", solids[0].owner)
    owners = tuple(dict.fromkeys(solid.owner for solid in solids))
    made = []
    for channel in range(max(len(solid.indices) for solid in solids)):
        lines = [f"voxel_size = {toml_text.value_text(size)}", f"smooth = {toml_text.value_text(sigma)}"]
        for solid in solids:
            table = {"name": solid.owner, "file": solid.file, "ior": solid.indices[min(channel, len(solid.indices) - 1)],
                     **({"absorption": list(solid.absorption)} if any(solid.absorption) else {})}
            lines += ["[[solid]]"] + [f"{key} = {toml_text.value_text(value)}" for key, value in table.items()]
        content = "\n".join(lines) + "\n"
        name = hashlib.sha256(json.dumps([SAMPLES_FORM, content]).encode()).hexdigest()[:16]
        volume = Volume(owners, pathlib.Path(folder) / f"{name}.solids.toml", pathlib.Path(folder) / f"{name}.vdb")
        volume.table.write_text(content, encoding="utf-8")
        made.append(volume)
    return made


def groups(boxes):
    """Which boxes (low, high) touch one another: lists of their numbers. Bodies that touch share their samples, or each would
    have air at the other's face."""
    of = list(range(len(boxes)))

    def first(i):
        while of[i] != i:
            i = of[i]
        return i

    for i, (low, high) in enumerate(boxes):
        for j in range(i):
            if (low <= boxes[j][1]).all() and (high >= boxes[j][0]).all():
                of[max(first(i), first(j))] = min(first(i), first(j))
    found = {}
    for i in range(len(boxes)):
        found.setdefault(first(i), []).append(i)
    return list(found.values())


def tidy(folder):
    """Removes samples, and tables of their bodies, that no scene file in the folder speaks of any more."""
    folder = pathlib.Path(folder)
    spoken_of = set()
    for path in folder.glob("*.toml"):
        if not path.name.endswith(".solids.toml"):
            spoken_of.update(SAMPLES.findall(path.read_text(encoding="utf-8")))
    for path in [*folder.glob("*.vdb"), *folder.glob("*.solids.toml")]:
        samples = f"{path.name.split('.')[0]}.vdb"
        if SAMPLES.fullmatch(samples) and samples not in spoken_of:
            try:
                path.unlink()
            except OSError:     # in use, or not ours to remove: it stays
                pass
