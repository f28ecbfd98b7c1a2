#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""unity.py PHOTIC MCS MONO FOLDER: the recipe for Unity, followed: examples/engines/PhoticVolume.cs reads what `photic export`
writes, run by Mono with UnityStandIn.cs in the place of Unity, and PhoticIrradiance of Photic.hlsl, said here in Python,
must find the light that `photic sample` finds, at points and normals turned to Unity's axes."""
import array
import json
import pathlib
import random
import struct
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ENGINES = HERE.parents[1] / "examples/engines"
SCENE = """photic = 1
[domain]
min = [-1.0, -0.7, -1.2]
max = [0.8, 0.9, 0.1]
voxel_size = 0.05
[[light]]
type = "sun"
direction = [0.433, 0.25, -0.866]
irradiance = 800.0
[[surface]]
name = "water"
kind = "height_field"
size = [4.0, 4.0]
waves = [{ amplitude = 0.02, wavelength = 0.9, direction = 20.0 }]
"""


def run(*command, **more):
    return subprocess.run([str(part) for part in command], check=True, **more)


class Texture:
    """What Unity holds of a volume: halves, sampled trilinearly between clamped texels."""

    def __init__(self, path):
        data = path.read_bytes()
        self.counts = struct.unpack_from("<3i", data)
        self.size = struct.unpack_from("<3f", data, 12)
        rows = struct.unpack_from("<16f", data, 24)
        self.texture_from_world = [rows[4 * i:4 * i + 4] for i in range(4)]
        floats = array.array("f", data[88:])
        assert len(floats) == 4 * self.counts[0] * self.counts[1] * self.counts[2]
        self.texels = struct.unpack(f"<{len(floats)}e", struct.pack(f"<{len(floats)}e", *floats))

    def sample(self, place):
        low, share = [], []
        for t, n in zip(place, self.counts):
            x = t * n - 0.5
            low.append(int(x // 1)), share.append(x - x // 1)
        out = [0.0] * 4
        for corner in range(8):
            weight, index, stride = 1.0, 0, 1
            for a in range(3):
                bit = corner >> a & 1
                weight *= share[a] if bit else 1 - share[a]
                index += stride * min(max(low[a] + bit, 0), self.counts[a] - 1)
                stride *= self.counts[a]
            for c in range(4):
                out[c] += weight * self.texels[4 * index + c]
        return out

    def irradiance(self, world, normal):
        """PhoticIrradiance of Photic.hlsl, line by line."""
        place = [sum(row[i] * world[i] for i in range(3)) + row[3] for row in self.texture_from_world[:3]]
        fade = [min(max(min(t, 1 - t) * n + 0.5, 0), 1) for t, n in zip(place, self.size)]
        light = [value * fade[0] * fade[1] * fade[2] for value in self.sample(place)]
        return max(0.0, -sum(n * l for n, l in zip(normal, light)))


def main(photic, mcs, mono, folder):
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scene.toml").write_text(SCENE)
    run(photic, "bake", folder / "scene.toml", "-o", folder / "pool.vdb", "-q")
    run(photic, "export", folder / "pool.vdb", "-o", folder / "pool.vf", "-q")
    run(mcs, "-nologo", "-warnaserror", f"-out:{folder / 'unity.exe'}", HERE / "UnityStandIn.cs", ENGINES / "PhoticVolume.cs")
    run(mono, folder / "unity.exe", folder, "pool.vf", folder / "seen.bin")
    texture = Texture(folder / "seen.bin")

    # As Unity's own importer of .vf asks (VectorFieldImporter.cs): the length says that nothing follows the texels.
    texels = texture.counts[0] * texture.counts[1] * texture.counts[2]
    for name, word, channels in (("pool.vf", b"VF_F", 1), ("pool_flux.vf", b"VF_V", 3)):
        data = (folder / name).read_bytes()
        assert data[:4] == word and struct.unpack_from("<3H", data, 4) == texture.counts and len(data) == 10 + 4 * channels * texels, name

    rng = random.Random(5)
    points = []
    for _ in range(400):
        normal = [rng.gauss(0, 1) for _ in range(3)]
        length = sum(n * n for n in normal) ** 0.5
        points.append([rng.uniform(-1.0, 0.8), rng.uniform(-0.7, 0.9), rng.uniform(-1.2, 0.0), *(n / length for n in normal)])
    table = "\n".join(",".join(map(repr, point)) for point in points)
    sampled = run(photic, "sample", folder / "pool.vdb", "-", "--json", input=table, text=True, capture_output=True)
    truth = [point["face_irradiance"] / 800.0 for point in json.loads(sampled.stdout)["frames"][0]["points"]]
    pairs = [(point, light) for point, light in zip(points, truth) if light is not None]
    assert len(pairs) > 350, len(pairs)

    def off(axes):
        found = [texture.irradiance([p[a] for a in axes], [p[3 + a] for a in axes]) for p, _ in pairs]
        return sum(abs(a - b) for a, (_, b) in zip(found, pairs)) / sum(b for _, b in pairs)

    turned, as_it_is = off((0, 2, 1)), off((0, 1, 2))
    print(f"relative L1 {turned:.1e}; along Photic's axes {as_it_is:.2f}")
    assert turned < 1e-3, turned
    assert as_it_is > 0.2, "axes that are not turned should be found"


main(*sys.argv[1:])
