#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""examples/robotics/plot_light.py light.csv FRAMES_PER_SECOND > light.svg: the light on the targets over time.

Prints a table on stderr: mean, brightest and darkest point and the coefficient of variation (standard deviation over
mean), over all points and frames of each board.
"""
import csv
import math
import sys

COLOURS = {"2": "#0b7ea4", "5": "#2f9e44", "10": "#6741d9"}
WIDTH, HEIGHT, LEFT, BOTTOM, GAP = 760, 300, 62, 44, 34


def read(path):
    """Green irradiance of faces [W/m2] by board, depth and frame."""
    light = {}
    with open(path, encoding="utf-8") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            if row["place"] == "outside":
                sys.exit(f"frame {row['frame']}: a point at z = {row['z']} m lies outside the volume")
            frames = light.setdefault(row["board"], {}).setdefault(row["depth [m]"], {})
            frames.setdefault(int(row["frame"]), []).append(float(row["face_irradiance_g"]))
    return light


def polygon(points, style):
    return f'<polygon points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in points)}" {style}/>'


def polyline(points, style):
    return f'<polyline points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in points)}" fill="none" {style}/>'


def main():
    light, rate = read(sys.argv[1]), float(sys.argv[2])
    panel = (WIDTH - LEFT - GAP * len(light)) / len(light)
    points = [v for depths in light.values() for frames in depths.values() for values in frames.values() for v in values if v > 0]
    low, high = 10 ** math.floor(math.log10(min(points))), 10 ** math.ceil(math.log10(max(points)))
    ticks = [low * 10**i for i in range(round(math.log10(high / low)) + 1)]
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT + 30}" font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT + 30}" fill="white"/>']
    print("| board | depth [m] | mean [W/m²] | darkest | brightest | coefficient of variation |\n|---|---:|---:|---:|---:|---:|",
          file=sys.stderr)
    for number, (board, depths) in enumerate(light.items()):
        x0, y0 = LEFT + number * (panel + GAP), HEIGHT - BOTTOM
        first = min(min(frames) for frames in depths.values())
        last = max(max(frames) for frames in depths.values())
        across = lambda frame: x0 + (frame - first) / max(1, last - first) * panel
        up = lambda value: y0 - math.log(max(value, low) / low) / math.log(high / low) * (y0 - 34)
        out.append(f'<text x="{x0}" y="20" font-weight="bold">{board} board, green, W/m²</text>')
        for tick in ticks:
            y = up(tick)
            out.append(f'<line x1="{x0}" x2="{x0 + panel:.1f}" y1="{y:.1f}" y2="{y:.1f}" stroke="#ddd"/>')
            out.append(f'<text x="{x0 - 6}" y="{y + 4:.1f}" text-anchor="end">{tick:g}</text>')
        for depth, frames in depths.items():
            times, colour = sorted(frames), COLOURS.get(depth, "#444")
            band = [(across(t), up(max(frames[t]))) for t in times] + [(across(t), up(min(frames[t]))) for t in reversed(times)]
            out.append(polygon(band, f'fill="{colour}" fill-opacity="0.18"'))
            out.append(polyline([(across(t), up(sum(frames[t]) / len(frames[t]))) for t in times],
                                f'stroke="{colour}" stroke-width="2"'))
            values = [v for t in times for v in frames[t]]
            mean = sum(values) / len(values)
            spread = math.sqrt(sum((v - mean) ** 2 for v in values) / len(values))
            print(f"| {board} | {depth} | {mean:.1f} | {min(values):.1f} | {max(values):.1f} | {spread / mean:.2f} |", file=sys.stderr)
        out.append(f'<text x="{x0 + panel / 2:.1f}" y="{HEIGHT - 22}" text-anchor="middle">'
                   f'{(last - first) / rate:.2g} s, frames {first} to {last}</text>')
    for number, depth in enumerate(next(iter(light.values()))):
        x = LEFT + 70 * number
        out.append(f'<rect x="{x}" y="{HEIGHT}" width="12" height="12" fill="{COLOURS.get(depth, "#444")}"/>'
                   f'<text x="{x + 18}" y="{HEIGHT + 11}">{depth} m</text>')
    out.append(f'<text x="{LEFT + 230}" y="{HEIGHT + 11}">line: mean of the board; band: from its darkest to its brightest point</text>')
    print("\n".join(out + ["</svg>"]))


main()
