# SPDX-License-Identifier: GPL-3.0-or-later
"""Binary PLY files, named after what is in them: what has not changed is not written again."""
import hashlib
import os
import pathlib

import numpy


def write_ply(folder, positions, triangles):
    """Writes vertices [m] (n x 3, float64) and triangles (m x 3, int32); returns the file's name in `folder`."""
    positions = numpy.ascontiguousarray(positions, dtype="<f8")
    rows = numpy.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    rows["count"] = 3
    rows["corners"] = triangles
    header = ("ply\nformat binary_little_endian 1.0\n"
              f"element vertex {len(positions)}\nproperty double x\nproperty double y\nproperty double z\n"
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
