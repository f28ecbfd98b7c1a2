#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The bodies of examples/graded, from their dimensions: writes NAME.ply and NAME.csv beside itself. [m], Z up, triangles outwards."""
import math
import pathlib
import struct

HERE = pathlib.Path(__file__).resolve().parent


def write(name, vertices, triangles):
    header = ("ply\nformat binary_little_endian 1.0\ncomment examples/graded/make_bodies.py\n"
              f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    data = b"".join(struct.pack("<3f", *v) for v in vertices)
    data += b"".join(struct.pack("<B3i", 3, *t) for t in triangles)
    (HERE / f"{name}.ply").write_bytes(header.encode() + data)
    print(f"{name}.ply: {len(triangles)} triangles")


def rounded_cube(side=1.0, radius=0.16, cells=14):
    """A cube whose edges and corners are round: points of a box's faces, pulled onto the ball around the nearest point within."""
    vertices, number, triangles = [], {}, []

    def point(p):
        key = tuple(round(c * cells) for c in p)
        if key not in number:
            half = 0.5 * side
            at = [c * side - half for c in p]
            core = [max(-half + radius, min(half - radius, c)) for c in at]
            way = [a - c for a, c in zip(at, core)]
            length = sum(w * w for w in way) ** 0.5
            number[key] = len(vertices)
            vertices.append(tuple(c + radius * w / length for c, w in zip(core, way)))
        return number[key]

    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for top in (0, 1):
            for i in range(cells):
                for j in range(cells):
                    corners = []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        p = [0.0, 0.0, 0.0]
                        p[axis], p[u], p[v] = top, a / cells, b / cells
                        corners.append(point(p))
                    if not top:
                        corners.reverse()
                    triangles += [(corners[0], corners[1], corners[2]), (corners[0], corners[2], corners[3])]
    write("rounded_cube", vertices, triangles)


# Each letter as bars (x, z, x, z) on a field of 4 wide and 6 high.
LETTERS = {
    "P": [(0, 0, 1, 6), (1, 5, 3, 6), (1, 2.5, 3, 3.5), (3, 3, 4, 5.5)],
    "H": [(0, 0, 1, 6), (3, 0, 4, 6), (1, 2.5, 3, 3.5)],
    "O": [(0, 0.5, 1, 5.5), (3, 0.5, 4, 5.5), (0.5, 0, 3.5, 1), (0.5, 5, 3.5, 6)],
    "T": [(1.5, 0, 2.5, 5), (0, 5, 4, 6)],
    "I": [(1.5, 0, 2.5, 6)],
    "C": [(0, 0.5, 1, 5.5), (0.5, 0, 4, 1), (0.5, 5, 4, 6)],
}


SIDES = ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def block(size=(1.5, 0.4, 0.6)):
    """A box around the origin."""
    x, y, z = (0.5 * s for s in size)
    vertices = [(a, b, c) for c in (-z, z) for a, b in ((-x, -y), (x, -y), (x, y), (-x, y))]
    write("block", vertices, [t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))])


def letters(word="PHOTIC", unit=0.042, depth=0.1):
    """Upright letters around the origin that are read along +y, each of boxes that overlap."""
    vertices, triangles = [], []
    left = -0.5 * unit * (5 * len(word) - 1)
    for k, letter in enumerate(word):
        for x0, z0, x1, z1 in LETTERS[letter]:
            n = len(vertices)
            vertices += [(left + unit * (5 * k + x), y, unit * (z - 3)) for z in (z0, z1)
                         for x, y in ((x0, -depth / 2), (x1, -depth / 2), (x1, depth / 2), (x0, depth / 2))]
            for a, b, c, d in SIDES:
                triangles += [(n + a, n + b, n + c), (n + a, n + c, n + d)]
    write("letters", vertices, triangles)


def resin(points=48, radius=0.37, height=0.98):
    """The profile of a drop, narrow above: radius and height."""
    lines = ["# radius, height [m]: examples/graded/make_bodies.py"]
    for k in range(points + 1):
        angle = math.pi * k / points
        lines.append(f"{max(0.0, radius * math.sin(angle) * (1 + 0.3 * math.cos(angle))):.5f}, "
                     f"{-0.42 + 0.5 * height * (1 - math.cos(angle)):.5f}")
    (HERE / "resin.csv").write_text("\n".join(lines) + "\n")
    print(f"resin.csv: {points + 1} points")


rounded_cube()
resin()
block()
letters()
