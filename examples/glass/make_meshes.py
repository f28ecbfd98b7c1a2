#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The meshes of examples/glass, from their dimensions: writes NAME.ply beside itself. [m], Z up, triangles outwards."""
import math
import pathlib
import struct

HERE = pathlib.Path(__file__).resolve().parent


def write(name, vertices, triangles):
    header = ("ply\nformat binary_little_endian 1.0\ncomment examples/glass/make_meshes.py\n"
              f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    data = b"".join(struct.pack("<3f", *v) for v in vertices)
    data += b"".join(struct.pack("<B3i", 3, *t) for t in triangles)
    (HERE / f"{name}.ply").write_bytes(header.encode() + data)
    print(f"{name}.ply: {len(triangles)} triangles")


def quads(rows, columns, wraps, at):
    """Two triangles a cell of a grid whose columns may close upon themselves."""
    out = []
    for j in range(rows):
        for i in range(columns):
            a, b = at(i, j), at((i + 1) % columns if wraps else i + 1, j)
            c, d = at((i + 1) % columns if wraps else i + 1, j + 1), at(i, j + 1)
            out += [(a, b, c), (a, c, d)]
    return out


def ring(radius=0.4, height=0.16, columns=64, rows=8):
    """An open band whose normals point to the axis: 2 x 64 x 8 triangles."""
    vertices = [(radius * math.cos(2 * math.pi * i / columns), -radius * math.sin(2 * math.pi * i / columns),
                 height * j / rows) for j in range(rows + 1) for i in range(columns)]
    write("ring", vertices, quads(rows, columns, True, lambda i, j: j * columns + i))


def revolved(name, profile, columns):
    """A solid of revolution. profile: (radius, height), counter-clockwise seen with the axis to the left, from axis to axis."""
    vertices, rings = [], []
    for r, z in profile:
        rings.append(len(vertices))
        if r == 0:
            vertices.append((0.0, 0.0, z))
        else:
            vertices += [(r * math.cos(2 * math.pi * i / columns), r * math.sin(2 * math.pi * i / columns), z)
                         for i in range(columns)]
    triangles = []
    for k in range(len(profile) - 1):
        for i in range(columns):
            n = (i + 1) % columns
            low, high = profile[k][0] > 0, profile[k + 1][0] > 0   # on the axis a ring is one point
            a, b = rings[k] + (i if low else 0), rings[k] + (n if low else 0)
            c, d = rings[k + 1] + (n if high else 0), rings[k + 1] + (i if high else 0)
            if low:
                triangles.append((a, b, c))
            if high:
                triangles.append((a, c, d))
    write(name, vertices, triangles)


def smooth(points, steps):
    """A Catmull-Rom curve through points."""
    out = []
    for k in range(len(points) - 1):
        p = [points[max(k - 1, 0)], points[k], points[k + 1], points[min(k + 2, len(points) - 1)]]
        for s in range(steps):
            t = s / steps
            out.append(tuple(0.5 * (2 * p[1][a] + (p[2][a] - p[0][a]) * t
                                    + (2 * p[0][a] - 5 * p[1][a] + 4 * p[2][a] - p[3][a]) * t * t
                                    + (3 * p[1][a] - p[0][a] - 3 * p[2][a] + p[3][a]) * t ** 3) for a in (0, 1)))
    return out + [points[-1]]


BOWL = [(0.0, 0.095), (0.016, 0.097), (0.030, 0.108), (0.038, 0.130), (0.0385, 0.155), (0.034, 0.180), (0.0315, 0.195)]
WALL = 0.0012       # of the bowl


def wine_glass(columns=96):
    """Foot, stem and bowl in one body; the wine overlaps the bowl by half of its wall, and its priority cuts it off."""
    outside = smooth([(0.034, 0.0), (0.034, 0.002), (0.020, 0.005), (0.006, 0.010), (0.004, 0.030), (0.004, 0.070),
                      (0.007, 0.088), (0.020, 0.094), (0.033, 0.107), (0.0395, 0.130), (0.0400, 0.155),
                      (0.0355, 0.180), (0.0330, 0.195)], 5)
    inside = smooth(list(reversed(BOWL)), 5)
    rim = [(0.5 * (outside[-1][0] + inside[0][0]), 0.1956)]
    revolved("wine_glass", [(0.0, 0.0)] + outside + rim + inside, columns)
    level = 0.150
    wet = [(r + (0.5 * WALL if r else 0.0), z - 0.5 * WALL) for r, z in smooth(BOWL, 5) if z < level]
    r_top = wet[-1][0]
    revolved("wine", wet + [(r_top, level), (0.0, level)], columns)


def disco_ball(radius=0.25, rings=16, tile=0.92):
    """Square mirrors, each flat on the ball: a ring of latitude has as many as fit, with gaps between. Behind them is a core."""
    vertices, triangles = [], []
    for j in range(rings):
        polar, half = math.pi * (j + 0.5) / rings, 0.5 * tile * math.pi * radius / rings
        count = max(3, int(2 * rings * math.sin(polar)))
        for i in range(count):
            turn = 2 * math.pi * i / count
            out = (math.sin(polar) * math.cos(turn), math.sin(polar) * math.sin(turn), math.cos(polar))
            east = (-math.sin(turn), math.cos(turn), 0.0)
            north = (-math.cos(polar) * math.cos(turn), -math.cos(polar) * math.sin(turn), math.sin(polar))
            n = len(vertices)
            vertices += [tuple(radius * out[k] + half * (x * east[k] + y * north[k]) for k in range(3))
                         for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            triangles += [(n, n + 1, n + 2), (n, n + 2, n + 3)]
    write("disco_ball", vertices, triangles)


def prism(side=0.12, length=0.30):
    """Equilateral, along y, one face down."""
    h = side * math.sqrt(3) / 2
    section = [(-side / 2, 0.0), (side / 2, 0.0), (0.0, h)]
    vertices = [(x, y, z) for y in (-length / 2, length / 2) for x, z in section]
    triangles = [(0, 1, 2), (3, 5, 4)]
    for i in range(3):
        n = (i + 1) % 3
        triangles += [(i, i + 3, n + 3), (i, n + 3, n)]
    write("prism", vertices, triangles)


def slab(name, low, high, cells, top, bottom):
    """A body between two heights over a rectangle of cells x cells; top and bottom: height at (i, j) of its corners."""
    n = cells + 1
    xs = [low[0] + (high[0] - low[0]) * i / cells for i in range(n)]
    ys = [low[1] + (high[1] - low[1]) * i / cells for i in range(n)]
    vertices = [(xs[i], ys[j], top(i, j)) for j in range(n) for i in range(n)]
    vertices += [(xs[i], ys[j], bottom(i, j)) for j in range(n) for i in range(n)]
    faces = quads(cells, cells, False, lambda i, j: j * n + i)
    triangles = faces + [(a + n * n, c + n * n, b + n * n) for a, b, c in faces]
    rim = ([i for i in range(n)] + [j * n + n - 1 for j in range(1, n)]
           + [(n - 1) * n + i for i in range(n - 2, -1, -1)] + [j * n for j in range(n - 2, 0, -1)])
    for k, a in enumerate(rim):
        b = rim[(k + 1) % len(rim)]
        triangles += [(a, a + n * n, b + n * n), (a, b + n * n, b)]
    write(name, vertices, triangles)


def box(name, low, high, waves=None, cells=1):
    """A box; its top may be a sum of waves over cells x cells."""
    def top(i, j):
        x = low[0] + (high[0] - low[0]) * i / cells
        y = low[1] + (high[1] - low[1]) * j / cells
        return high[2] + (waves(x, y) if waves else 0.0)
    slab(name, low, high, cells, top, lambda i, j: low[2])


def aquarium():
    def waves(x, y):
        return (0.0022 * math.sin(2 * math.pi * (x * 0.9 + y * 0.45) / 0.16)
                + 0.0012 * math.sin(2 * math.pi * (y * 0.8 - x * 0.6) / 0.10 + 1.0)
                + 0.0006 * math.sin(2 * math.pi * (x - 0.3 * y) / 0.07 + 2.0))
    box("tank", (-0.30, -0.20, 0.20), (0.30, 0.20, 0.56))
    box("tank_water", (-0.29, -0.19, 0.21), (0.29, 0.19, 0.50), waves, 48)
    # Down to below the waves, where water is what is there, and a hair narrower than the water, whose sides it must not
    # share.
    box("tank_air", (-0.2895, -0.1895, 0.48), (0.2895, 0.1895, 0.60))


def lens(cells=64, side=0.1, thickness=0.008, index=1.49, distance=0.25):
    """A slab whose back face throws a picture: where its Laplacian is what the picture asks of the light's density, for
    small bends (distance (index - 1) laplacian(h) = 1 - E). Solved by cosines, whose slopes vanish at the rim."""
    n = cells + 1
    letter = ["01110", "10001", "10001", "11110", "10000", "10000", "10000"]
    def wanted(x, y):     # a P of light, its strokes a little soft
        total = 0.0
        for j, line in enumerate(letter):
            for i, bit in enumerate(line):
                if bit == "1":
                    u, v = (x - (0.26 + 0.12 * i)) / 0.06, ((1 - y) - (0.14 + 0.12 * j)) / 0.06
                    total = max(total, 1 / (1 + math.exp(6 * (max(abs(u), abs(v)) - 1))))
        return 1 + 0.8 * total
    e = [[wanted((i + 0.5) / cells, (j + 0.5) / cells) for i in range(cells)] for j in range(cells)]
    mean = sum(map(sum, e)) / cells ** 2
    e = [[1 - v / mean for v in row] for row in e]
    basis = [[math.cos(math.pi * k * (i + 0.5) / cells) for i in range(cells)] for k in range(cells)]
    half = [[sum(b * v for b, v in zip(basis[k], row)) for k in range(cells)] for row in e]
    scale = [(1 if k == 0 else 2) / cells for k in range(cells)]
    spectrum = [[scale[k] * scale[m] * sum(basis[m][j] * half[j][k] for j in range(cells)) for k in range(cells)]
                for m in range(cells)]
    for m in range(cells):
        for k in range(cells):
            wave = (math.pi / side) ** 2 * (k * k + m * m)
            spectrum[m][k] = spectrum[m][k] / (-wave * distance * (index - 1)) if wave else 0.0
    at = [[math.cos(math.pi * k * i / cells) for i in range(n)] for k in range(cells)]
    rows = [[sum(spectrum[m][k] * at[k][i] for k in range(cells)) for i in range(n)] for m in range(cells)]
    heights = [[sum(rows[m][i] * at[m][j] for m in range(cells)) for i in range(n)] for j in range(n)]

    # Light comes down onto the flat face; the worked one looks at the wall below. Thicker where light is gathered.
    half = 0.5 * side
    slab("lens", (-half, -half), (half, half), cells, lambda i, j: thickness, lambda i, j: -heights[j][i])


if __name__ == "__main__":
    ring()
    wine_glass()
    disco_ball()
    prism()
    aquarium()
    lens()
