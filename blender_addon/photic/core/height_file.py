# SPDX-License-Identifier: GPL-3.0-or-later
"""Float EXR height maps, named after what is in them: what has not changed is not written again.

By hand, as Blender's own writer needs an image data block for each: one part of scan lines, without compression
(openexr.com, "OpenEXR File Layout").
"""
import hashlib
import os
import pathlib
import struct

import numpy

HEIGHT, ALONG_X, ALONG_Y = "G", "R", "B"    # channels, as in the maps that Blender's Ocean modifier bakes
FLOAT = 2                                   # OpenEXR's pixel type


def write_exr(folder, heights, moves=None):
    """Writes heights [m] (rows x columns, row 0 at the lowest y) and, when given, the displacement along x and y.

    Returns the file's name in `folder`.
    """
    layers = {HEIGHT: heights} if moves is None else {HEIGHT: heights, ALONG_X: moves[0], ALONG_Y: moves[1]}
    names = sorted(layers)                  # as readers want them
    rows, columns = heights.shape
    lines = numpy.empty(rows, dtype=[("y", "<i4"), ("bytes", "<i4"), ("values", "<f4", (len(names), columns))])
    lines["y"] = numpy.arange(rows)
    lines["bytes"] = len(names) * columns * 4
    for number, name in enumerate(names):
        lines["values"][:, number] = layers[name][::-1]     # the top row is first
    header = _header(names, columns, rows)
    offsets = len(header) + 8 * rows + lines.dtype.itemsize * numpy.arange(rows, dtype="<u8")
    content = header + offsets.astype("<u8").tobytes() + lines.tobytes()
    target = pathlib.Path(folder) / f"{hashlib.sha256(content).hexdigest()[:16]}.exr"
    if not target.exists():
        partial = target.with_suffix(f".{os.getpid()}.part")
        partial.write_bytes(content)
        os.replace(partial, target)
    return target.name


def _header(names, columns, rows):
    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    window = struct.pack("<4i", 0, 0, columns - 1, rows - 1)
    channels = b"".join(name.encode() + b"\0" + struct.pack("<iB3xii", FLOAT, 0, 1, 1) for name in names) + b"\0"
    return (b"\x76\x2f\x31\x01" + struct.pack("<i", 2)
            + attribute("channels", "chlist", channels) + attribute("compression", "compression", b"\0")
            + attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
            + attribute("lineOrder", "lineOrder", b"\0") + attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0))
            + attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0))
            + attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)) + b"\0")
