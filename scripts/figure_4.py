#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/figure_4.py [--photic PROGRAM] [--out FOLDER]: figure 4 of Ernst, Akenine-Moller and Jensen 2005, with tubes beside it.

A sea of 64 x 64 points under a slanting sun, its light on a plane half-way down the caustic volumes, 256 x 256 pixels.
Left: plain prisms. Each volume cuts its three bent sides into two triangles by itself, along the diagonal from its own
first corner, so that neighbours cut the side they share along different diagonals, and leave gaps and overlaps. Right:
`beams` with the same 64 x 64 points. Writes figure_4.png into FOLDER (default: .), and prints what gaps and overlaps do."""
import argparse
import csv
import math
import os
import struct
import subprocess
import tempfile
import zlib

HERE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
POINTS, PIXELS, SIDE = 64, 256, 4.0  # [m] of water
DEPTH, BOTTOM = 0.7, 1.4             # of the plane, and where volumes end [m]
INDEX, SUN = 1.333, (0.5, 0.2, -0.85)
WAVES = [(0.10, 2.0, (1, 0.3)), (0.05, 0.9, (-0.4, 1)), (0.02, 0.45, (0.8, -0.7))]  # amplitude, wavelength, direction


def unit(v):
    length = math.sqrt(sum(x * x for x in v))
    return tuple(x / length for x in v)


def water(x, y):
    """Height and slopes."""
    h = sx = sy = 0.0
    for amplitude, wavelength, direction in WAVES:
        d, k = unit(direction), 2 * math.pi / wavelength
        phase = k * (d[0] * x + d[1] * y)
        h += amplitude * math.cos(phase)
        sx -= amplitude * k * d[0] * math.sin(phase)
        sy -= amplitude * k * d[1] * math.sin(phase)
    return h, sx, sy


def ray(x, y):
    """Where light enters the water, and where it is at a depth."""
    h, sx, sy = water(x, y)
    n, d = unit((-sx, -sy, 1.0)), unit(SUN)
    cosine = -sum(a * b for a, b in zip(n, d))
    bent = math.sqrt(1 - (1 - cosine * cosine) / INDEX ** 2)
    t = [a / INDEX + (cosine / INDEX - bent) * b for a, b in zip(d, n)]
    return (x, y, h), lambda depth: tuple(p + t_ * (h + depth) / -t[2] for p, t_ in zip((x, y, h), t))


def area(polygon):
    return 0.5 * sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(polygon, polygon[1:] + polygon[:1]))


def inside(polygon, x, y):
    hit = False
    for (ax, ay, *_), (bx, by, *_) in zip(polygon, polygon[1:] + polygon[:1]):
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            hit = not hit
    return hit


class Picture:
    """The middle of the plane: sums of light, and how many volumes of one orientation cover each pixel."""
    def __init__(self):
        self.light, self.low, self.step = [0.0] * PIXELS ** 2, -0.25 * SIDE, 0.5 * SIDE / PIXELS
        self.covered = [0] * PIXELS ** 2

    def centre(self, i):
        return self.low + (i + 0.5) * self.step

    def add(self, polygon, value, sign):
        xs, ys = [p[0] for p in polygon], [p[1] for p in polygon]
        first = lambda v: max(0, math.ceil((v - self.low) / self.step - 0.5))
        last = lambda v: min(PIXELS - 1, math.floor((v - self.low) / self.step - 0.5))
        for j in range(first(min(ys)), last(max(ys)) + 1):
            for i in range(first(min(xs)), last(max(xs)) + 1):
                if inside(polygon, self.centre(i), self.centre(j)):
                    self.light[j * PIXELS + i] += value
                    self.covered[j * PIXELS + i] += sign


def volumes():
    """Corners of each caustic volume: rays of three neighbouring points, and the light across it."""
    at = [[ray(SIDE * (i / (POINTS - 1) - 0.5), SIDE * (j / (POINTS - 1) - 0.5)) for i in range(POINTS)] for j in range(POINTS)]
    for j in range(POINTS - 1):
        for i in range(POINTS - 1):
            for corners in ((at[j][i], at[j][i + 1], at[j + 1][i + 1]), (at[j][i], at[j + 1][i + 1], at[j + 1][i])):
                # Seen along the sun, what a triangle takes of it; Fresnel's loss is all but even, and left out.
                d = unit(SUN)
                a, b, c = ((p[0] - p[2] * d[0] / d[2], p[1] - p[2] * d[1] / d[2]) for p, _ in corners)
                yield [way for _, way in corners], abs(area([a, b, c])) * abs(d[2])


def drawn():
    prisms, exact = Picture(), Picture()
    part = 0.5  # DEPTH over BOTTOM, on the average
    for ways, power in volumes():
        here = [way(DEPTH) for way in ways]
        spread = area([p[:2] for p in here])
        if abs(spread) < 1e-9:
            continue
        sign = 1 if spread > 0 else -1
        exact.add(here, power / abs(spread), sign)
        # Half-way between where a volume begins and where it ends, its sides' diagonals lie half-way between their ends.
        top, end = [way(2 * DEPTH - BOTTOM) for way in ways], [way(BOTTOM) for way in ways]
        bent = []
        for k in range(3):
            n = (k + 1) % 3
            bent += [here[k], tuple((1 - part) * a + part * b for a, b in zip(top[k], end[n]))]
        prisms.add(bent, power / abs(spread), sign)
    return prisms, exact


def tubes(photic, folder, places):
    waves = ", ".join(f"{{ amplitude = {a}, wavelength = {w}, direction = [{d[0]}, {d[1]}], phase = {math.pi / 2} }}" for a, w, d in WAVES)
    scene, volume, points = (os.path.join(folder, n) for n in ("sea.toml", "sea.vdb", "points.csv"))
    cell = 0.5 * SIDE / PIXELS
    half = SIDE / 4 + 4 * cell
    with open(scene, "w", encoding="utf-8") as file:
        file.write(f"""photic = 1
[domain]
min = [{-half}, {-half}, {-DEPTH - 2.5 * cell}]
max = [{half}, {half}, {-DEPTH + 2.5 * cell}]
voxel_size = {cell}
[[light]]
type = "sun"
angular_diameter = 0
direction = [{SUN[0]}, {SUN[1]}, {SUN[2]}]
irradiance = 1
[[surface]]
size = [{SIDE}, {SIDE}]
waves = [{waves}]
[bake]
grids = ["irradiance", "direction"]
""")
    subprocess.run([photic, "bake", scene, "-o", volume, "--force", "--quiet", "--measure", "no", "--f32", "--set", f"beams.mesh={POINTS}"], check=True)
    with open(points, "w", encoding="utf-8") as file:
        file.write("x,y,z,nx,ny,nz\n" + "".join(f"{x:.9g},{y:.9g},{-DEPTH},0,0,1\n" for x, y in places))
    rows = subprocess.run([photic, "sample", volume, points], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
    return [float(row["face_irradiance"] or 0) for row in csv.DictReader(r for r in rows if not r.startswith("#"))]


def write_png(path, panels, most):
    rows = []
    for j in range(PIXELS - 1, -1, -1):
        row = b""
        for k, panel in enumerate(panels):
            row += (b"\xff" * 8 if k else b"") + bytes(min(255, int(255 * (max(0.0, panel[j * PIXELS + i]) / most) ** (1 / 2.2))) for i in range(PIXELS))
        rows.append(b"\0" + row)
    chunk = lambda name, data: struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    head = struct.pack(">IIBBBBB", len(rows[0]) - 1, PIXELS, 8, 0, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"".join(rows), 9)) + chunk(b"IEND", b""))


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--photic", default=os.path.join(HERE, "build/release/bin/photic"))
    parser.add_argument("--out", default=".")
    given = parser.parse_args()
    prisms, exact = drawn()
    places = [(exact.centre(i), exact.centre(j)) for j in range(PIXELS) for i in range(PIXELS)]
    with tempfile.TemporaryDirectory() as folder:
        ours = tubes(given.photic, folder, places)
    scale = sum(exact.light) / sum(ours)  # Fresnel's loss
    # One volume more or less than the three rays of each corner say.
    wrong = [a - b for a, b in zip(prisms.covered, exact.covered)]
    share = lambda count: 100 * count / len(wrong)
    print(f"plain prisms: {share(sum(v < 0 for v in wrong)):.1f} % of the pixels lie in gaps, {share(sum(v > 0 for v in wrong)):.1f} % in overlaps")
    print(f"beams: {share(sum(v <= 0 for v in ours)):.1f} % of the pixels are without light")
    os.makedirs(given.out, exist_ok=True)
    most = 3 * sum(exact.light) / len(exact.light)
    write_png(os.path.join(given.out, "figure_4.png"), [prisms.light, [scale * v for v in ours]], most)


main()
