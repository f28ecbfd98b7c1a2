# SPDX-License-Identifier: GPL-3.0-or-later
"""The slice atlas's sidecar (docs/schemas/atlas.md)."""
import dataclasses
import json
import pathlib

from .program import BakerError

VERSION = 1


@dataclasses.dataclass(frozen=True)
class Atlas:
    """Where each voxel is in the picture. Voxel (i, j, k), from 0, is centred at origin + (i, j, k) * voxel_size."""
    image: str                  # path of the EXR
    rgb_image: str              # path of the coloured one, or ""
    image_2: str                # the second lobe's, or ""
    rgb_image_2: str
    width: int
    height: int
    columns: int
    slices: int
    slice_width: int
    slice_height: int
    origin: tuple               # [m] of voxel (0, 0, 0)
    voxel_size: tuple           # [m]
    scale: float                # [W/m2] that stored values are multiplied by
    ior: float                  # of the medium


def read(path):
    """Raises BakerError when there is no atlas at `path` or it is of another version."""
    path = pathlib.Path(path)
    try:
        sidecar = json.loads(path.read_text(encoding="utf-8"))
        if sidecar["photic_atlas"] != VERSION:
            raise BakerError(f"'{path}' is an atlas of version {sidecar['photic_atlas']}, and this add-on reads {VERSION}")
        matrix = sidecar["world_from_index"]

        def beside(key):
            name = sidecar.get(key)
            return str(path.parent / name) if name else ""
        return Atlas(
            image=str(path.parent / sidecar["image"]), rgb_image=beside("rgb_image"),
            image_2=beside("image_2"), rgb_image_2=beside("rgb_image_2"),
            width=sidecar["width"], height=sidecar["height"], columns=sidecar["columns"], slices=sidecar["slices"],
            slice_width=sidecar["slice_width"], slice_height=sidecar["slice_height"],
            origin=tuple(row[3] for row in matrix[:3]), voxel_size=tuple(matrix[i][i] for i in range(3)),
            scale=sidecar["scale"], ior=float(sidecar["metadata"].get("ior", 1.0)))
    except OSError as error:
        raise BakerError(f"The atlas '{path}' cannot be read ({error.strerror}); bake again") from error
    except (ValueError, KeyError, TypeError, IndexError) as error:
        raise BakerError(f"'{path}' is no atlas of Photic's; bake again") from error
