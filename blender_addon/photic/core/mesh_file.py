# SPDX-License-Identifier: GPL-3.0-or-later
"""Binary PLY files, named after what is in them: what has not changed is not written again."""
import hashlib
import os
import pathlib

import numpy


def write_ply(folder, positions, triangles, normals=None):
    """Writes vertices [m] (n x 3, float64) and triangles (m x 3, int32); returns the file's name in `folder`. With
    `normals` of the triangles' corners (m x 3 x 3), a vertex is there once for each normal that it has."""
    names = ["x", "y", "z"]
    if normals is not None:
        names += ["nx", "ny", "nz"]
        places = numpy.concatenate([triangles.reshape(-1, 1), numpy.round(normals.reshape(-1, 3), 6)], axis=1)
        kept, of_corner = numpy.unique(places, axis=0, return_inverse=True)
        positions = numpy.concatenate([positions[kept[:, 0].astype(int)], kept[:, 1:]], axis=1)
        triangles = of_corner.reshape(-1, 3)
    positions = numpy.ascontiguousarray(positions, dtype="<f8")
    properties = "".join(f"property double {name}\n" for name in names)
    rows = numpy.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    rows["count"] = 3
    rows["corners"] = triangles
    header = ("ply\nformat binary_little_endian 1.0\n"
              f"element vertex {len(positions)}\n{properties}"
              f"element face {len(rows)}\nproperty list uchar int vertex_indices\nend_header\n").encode()
    digest = hashlib.sha256(header)
    digest.update(positions)
    digest.update(rows.tobytes())
    target = pathlib.Path(folder) / f"{digest.hexdigest()[:16]}.ply"
    if not target.exists():
        partial = target.with_suffix(f".{os.getpid()}.part")
        with open(partial, "wb") as out:
            out.write(header)
            out.write(positions)
            out.write(rows)
        os.replace(partial, target)
    return target.name
