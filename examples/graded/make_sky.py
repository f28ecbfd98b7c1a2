#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A panorama of a meadow before hills under an evening sun, as a camera would capture it in many exposures: writes sky.exr beside itself, linear,
1024 x 512 floats, longitude and latitude, Z up. The sun is 10,000 times as bright as the sky. `make_sky.py 8` writes sky.0001.exr to sky.0008.exr
instead, smaller ones, in which clouds go by."""
import math
import pathlib
import struct
import sys

WIDTH, HEIGHT = 1024, 512
SUN_AZIMUTH, SUN_HEIGHT = math.radians(152), math.radians(17)
SUN = (math.cos(SUN_HEIGHT) * math.cos(SUN_AZIMUTH), math.cos(SUN_HEIGHT) * math.sin(SUN_AZIMUTH), math.sin(SUN_HEIGHT))


def mix(a, b, t):
    return tuple(x + (y - x) * t for x, y in zip(a, b))


def step(low, high, x):
    t = min(1.0, max(0.0, (x - low) / (high - low)))
    return t * t * (3 - 2 * t)


def hashed(i, j):
    n = (i * 374761393 + j * 668265263) & 0xFFFFFFFF
    n = ((n ^ (n >> 13)) * 1274126177) & 0xFFFFFFFF
    return ((n ^ (n >> 16)) & 0xFFFF) / 65535.0


def noise(x, y, period):
    """Smooth, from 0 to 1; repeats along x after a whole number."""
    i, j = math.floor(x), math.floor(y)
    u, v = x - i, y - j
    u, v = u * u * (3 - 2 * u), v * v * (3 - 2 * v)
    rows = [hashed(i % period, j + k) * (1 - u) + hashed((i + 1) % period, j + k) * u for k in (0, 1)]
    return rows[0] * (1 - v) + rows[1] * v


def lumps(x, y, period, octaves):
    return sum(noise(x * 2 ** o, y * 2 ** o, period * 2 ** o) * 0.5 ** (o + 1) for o in range(octaves))


def sky(direction, turn, up, time):
    high = step(0, 0.9, direction[2])
    light = mix((0.95, 0.72, 0.52), (0.16, 0.30, 0.62), high ** 0.6)
    near = max(0.0, sum(a * b for a, b in zip(direction, SUN)))
    light = tuple(c + g * (0.5 * near ** 6 + 6 * near ** 400) for c, g in zip(light, (1.0, 0.62, 0.30)))
    # Banks of cloud, brighter towards the sun.
    cover = step(0.46, 0.66, lumps(turn * 10 + time, up * 9 + 0.7 * time, 10, 5)) * step(0.03, 0.15, direction[2]) * (1 - 0.5 * high)
    light = mix(light, mix((0.52, 0.50, 0.56), (1.9, 1.35, 0.95), near ** 2), 0.85 * cover)
    if near > math.cos(math.radians(0.9)):
        light = (9000.0, 6400.0, 3600.0)
    return light


def ground(direction, turn):
    """Grass and a path of gravel, seen from a man's height."""
    distance = min(60.0, -1.0 / min(-1e-3, direction[2]))
    x, y = distance * math.cos(turn * 2 * math.pi), distance * math.sin(turn * 2 * math.pi)
    blades = lumps(x * 3 + 512, y * 3 + 512, 1 << 20, 4)
    light = mix((0.045, 0.075, 0.018), (0.17, 0.19, 0.055), blades)
    if abs(y + 0.6 * math.sin(x * 0.5)) < 0.55:
        light = mix((0.22, 0.19, 0.15), (0.36, 0.32, 0.26), blades)
    return mix(light, (0.42, 0.36, 0.30), step(5, 60, distance) * 0.8)


def pixel(x, y, width, height, time):
    up = (0.5 - (y + 0.5) / height) * math.pi
    turn = (0.5 - (x + 0.5) / width) % 1.0
    azimuth = turn * 2 * math.pi
    direction = (math.cos(up) * math.cos(azimuth), math.cos(up) * math.sin(azimuth), math.sin(up))
    if direction[2] <= -0.01:
        return ground(direction, turn)
    light = sky(direction, turn, max(up, 0.0), time) if up > 0 else (0.4, 0.34, 0.28)
    # Two ridges, and trees along the nearer one; a pixel that one goes through is mixed.
    half = 0.5 * math.pi / height
    for top, period, colour, rough in ((0.05, 24, (0.10, 0.085, 0.09), 0.14), (0.0, 90, (0.022, 0.028, 0.018), 0.07)):
        edge = top + rough * (lumps(turn * period, 7.5, period, 5) - 0.3)
        light = mix(light, colour, step(edge + half, edge - half, up))
    return mix(ground(direction, turn), light, step(-0.01, 0.0, direction[2]))


def attribute(name, kind, data):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data


def write(name, width, height, time):
    # OpenEXR, one part, scan lines of 32-bit floats, nothing compressed.
    channels = b"".join(c + b"\0" + struct.pack("<iiii", 2, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = struct.pack("<ii", 20000630, 2) + attribute("channels", "chlist", channels) + attribute("compression", "compression", b"\0")
    head += attribute("dataWindow", "box2i", box) + attribute("displayWindow", "box2i", box) + attribute("lineOrder", "lineOrder", b"\0")
    head += attribute("pixelAspectRatio", "float", struct.pack("<f", 1)) + attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    size = 12 * width
    first = len(head) + 8 * height
    out = [head, struct.pack(f"<{height}Q", *(first + y * (size + 8) for y in range(height)))]
    for y in range(height):
        row = [pixel(x, y, width, height, time) for x in range(width)]
        out.append(struct.pack("<ii", y, size) + b"".join(struct.pack(f"<{width}f", *(p[c] for p in row)) for c in (2, 1, 0)))
    (pathlib.Path(__file__).resolve().parent / name).write_bytes(b"".join(out))
    print(f"{name}: {width} x {height}")


def main():
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 0
    if frames == 0:
        write("sky.exr", 1024, 512, 0.0)
    for frame in range(frames):
        write(f"sky.{frame + 1:04d}.exr", 512, 256, 0.25 * frame)


if __name__ == "__main__":
    main()
