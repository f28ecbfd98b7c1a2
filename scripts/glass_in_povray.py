# SPDX-License-Identifier: Apache-2.0
"""The scenes of examples/glass for POV-Ray, and look-ups beside its photons: the part of scripts/measure_glass that asks for it."""
import csv
import math
import os
import re
import struct
import subprocess
import sys

HERE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
RECEIVER = ", receiver"  # ends the name of an example whose look-ups are compared


# POV-Ray: a receiver seen straight on, one pixel a sample. The light that comes straight is taken off as a second picture has
# it, without photons, in which what bends light is black.
class PovScene:
    def __init__(self, light, body, material, receiver, corner, right, up, normal, edits=(), spacings=(0.004, 0.002, 0.001), brightness=0.05):
        """corner, right, up: of the piece of the receiver that is seen; right x up points at the eye, along normal."""
        self.light, self.body, self.material, self.receiver = light, body, material, receiver
        self.corner, self.right, self.up, self.normal = corner, right, up, normal
        self.edits, self.spacings, self.brightness = edits, spacings, brightness


GLASS = "finish { ambient 0 diffuse 0 reflection { 0, 1 fresnel on } conserve_energy } interior { ior IOR } pigment { rgbt 1 } photons { target reflection on refraction on collect off }"
MIRROR = "finish { ambient 0 diffuse 0 reflection 0.9 } pigment { rgb 0 } photons { target reflection on refraction off collect off }"
FLOOR = "plane { z, 0 pigment { rgb 1 } finish { ambient 0 diffuse 1 } photons { collect on } }"


def sun(x, y, z):
    return f"light_source {{ <{-100 * x}, {-100 * y}, {-100 * z}> rgb L parallel point_at <0, 0, 0> photons {{ refraction on reflection on }} }}"


def ply(name):
    """Vertices and triangles of a binary PLY of make_meshes.py."""
    with open(os.path.join(HERE, "examples", "glass", name + ".ply"), "rb") as file:
        data = file.read()
    head, body = data.split(b"end_header\n", 1)
    vertices, faces = (int(re.search(rb"element %s (\d+)" % what, head)[1]) for what in (b"vertex", b"face"))
    points = [struct.unpack_from("<3f", body, 12 * i) for i in range(vertices)]
    return points, [struct.unpack_from("<3i", body, 12 * vertices + 13 * i + 1) for i in range(faces)]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def mesh2(name, smooth_below=None):
    """The same triangles for POV-Ray. smooth_below: degrees; normals are averaged over flatter edges, as creases leave them."""
    points, triangles = ply(name)
    flat = []
    for a, b, c in triangles:
        n = cross([points[b][i] - points[a][i] for i in range(3)], [points[c][i] - points[a][i] for i in range(3)])
        length = math.sqrt(sum(v * v for v in n)) or 1.0
        flat.append([v / length for v in n])
    vector = lambda v: f"<{v[0]:.9g},{v[1]:.9g},{v[2]:.9g}>"
    listed = lambda what, items: f"{what} {{ {len(items)}, {','.join(items)} }}"
    out = [listed("vertex_vectors", [vector(p) for p in points])]
    index = listed("face_indices", [f"<{a},{b},{c}>" for a, b, c in triangles])
    if smooth_below is None:
        return f"mesh2 {{ {out[0]} {index} inside_vector <0.3, 0.2, 1> REST }}"
    around, least = {}, math.cos(math.radians(smooth_below))
    for k, triangle in enumerate(triangles):
        for v in triangle:
            around.setdefault(v, []).append(k)
    normals = []
    for k, triangle in enumerate(triangles):
        for v in triangle:
            n = [0.0, 0.0, 0.0]
            for other in around[v]:
                if sum(p * q for p, q in zip(flat[k], flat[other])) > least:
                    t = triangles[other]
                    at = t.index(v)
                    e = [[points[t[(at + j) % 3]][i] - points[v][i] for i in range(3)] for j in (1, 2)]
                    lengths = [math.sqrt(sum(x * x for x in d)) for d in e]
                    angle = math.acos(max(-1.0, min(1.0, sum(p * q for p, q in zip(*e)) / (lengths[0] * lengths[1]))))
                    n = [x + angle * y for x, y in zip(n, flat[other])]
            normals.append(n)
    out.append(listed("normal_vectors", [vector(n) for n in normals]))
    out.append(index)
    out.append(listed("normal_indices", [f"<{3 * k},{3 * k + 1},{3 * k + 2}>" for k in range(len(triangles))]))
    return f"mesh2 {{ {' '.join(out)} inside_vector <0.3, 0.2, 1> REST }}"


def pov_scenes():
    both = ('inside = "', 'event = "both"\ninside = "')  # POV-Ray's glass reflects too
    one_index = [both, (r"cauchy = \[.*\].*", "ior = 1.74"), (r'(?s)type = "spot".*?blend = 0.1', 'type = "sun"\nangular_diameter = 0\ndirection = [0.8616, 0, 0.5075]')]
    return {
        "glass_ball": PovScene(sun(0.55, 0.1, -1), "sphere { <0, 0, 0.25>, 0.15 REST }", GLASS.replace("IOR", "1.5"), FLOOR,
                               (-0.35, -0.35, 0), (0.9, 0, 0), (0, 0.7, 0), (0, 0, 1)),
        "ring": PovScene(sun(0.8, 0.25, -0.75), "cylinder { <0, 0, 0>, <0, 0, 0.16>, 0.4 open REST }", MIRROR, FLOOR,
                         (-0.58, -0.58, 0), (1.16, 0, 0), (0, 1.16, 0), (0, 0, 1), [(r"colour = \[.*\].*", "colour = 0.9")], (0.0016, 0.0008, 0.0004)),
        "mirror_sphere": PovScene("light_source { <-0.7, -0.5, 1.2> rgb L*20000 fade_distance 0.01 fade_power 2 photons { refraction on reflection on } }",
                                  "sphere { <0.1, 0.1, 0.4>, 0.4 REST }", MIRROR,
                                  "plane { z, 2 pigment { rgb 1 } finish { ambient 0 diffuse 1 } photons { collect on } }",
                                  (-1.45, -1.45, 2), (2.9, 0, 0), (0, 2.9, 0), (0, 0, -1), [("colour = 0.95", "colour = 0.9")], (0.01, 0.005, 0.0025)),
        "prism": PovScene(sun(0.8616, 0, 0.5075), mesh2("prism"), GLASS.replace("IOR", "1.74"),
                          "plane { x, 0.8 pigment { rgb 1 } finish { ambient 0 diffuse 1 } photons { collect on } }",
                          (0.8, -0.165, -0.6), (0, 0.33, 0), (0, 0, 0.72), (-1, 0, 0), one_index, (0.002, 0.001, 0.0005)),
        "discoball": PovScene("light_source { <-1.8, -1.2, 2.4> rgb L*20000 fade_distance 0.01 fade_power 2 photons { refraction on reflection on } }",
                              "union { object { " + mesh2("disco_ball").replace("REST", "translate <0, 0, 1.8>") + " REST } }"
                              " sphere { <0, 0, 1.8>, 0.245 pigment { rgb 0 } finish { ambient 0 diffuse 0 } }", MIRROR, FLOOR,
                              (-1.9, -1.9, 0), (3.8, 0, 0), (0, 3.8, 0), (0, 0, 1),
                              [("scattering = 0.06", "scattering = 0"), (r'(?s)type = "spot".*?blend = 0.3', 'type = "point"\nposition = [-1.8, -1.2, 2.4]\npower = 6000')],
                              (0.002, 0.001, 0.0005)),
        "lens_check": PovScene(sun(0, 0, -1), mesh2("lens", 40), GLASS.replace("IOR", "1.49"),
                               "plane { z, -0.25 pigment { rgb 1 } finish { ambient 0 diffuse 1 } photons { collect on } }",
                               (-0.075, -0.075, -0.25), (0.15, 0, 0), (0, 0.15, 0), (0, 0, 1), [both], (0.0004, 0.0002, 0.0001)),
        "wine_glass": PovScene(sun(1, 0.12, -0.72), mesh2("wine_glass", 40), GLASS.replace("IOR", "1.52"), FLOOR,
                               (-0.07, -0.09, 0), (0.42, 0, 0), (0, 0.2, 0), (0, 0, 1),
                               [(r'(?s)\[\[surface\]\]\nname = "wine".*?event = "both"\n', "")], (0.001, 0.0005, 0.00025)),
        "aquarium": PovScene("light_source { <-0.25, -1.35, 1.1> rgb L*20000 fade_distance 0.01 fade_power 2 photons { refraction on reflection on } }",
                             mesh2("tank_water", 40), GLASS.replace("IOR", "1.333"), FLOOR, (-0.7, -0.5, 0), (1.4, 0, 0), (0, 1.2, 0), (0, 0, 1),
                             [(r'(?s)\[\[surface\]\]\nname = "(tank|air)".*?smooth = false\n', ""), ("absorption = .*", ""),
                              (r'(?s)type = "spot".*?blend = 0.4', 'type = "point"\nposition = [-0.25, -1.35, 1.1]\npower = 600')], (0.004, 0.002, 0.001)),
    }


PIXELS = 90  # along the piece's right side


class Pov:
    def __init__(self, bench):
        self.bench, self.out = bench, bench.given.out

    def places(self, scene):
        long = lambda v: math.sqrt(sum(x * x for x in v))
        rows = round(PIXELS * long(scene.up) / long(scene.right))
        at = lambda i, j: tuple(c + r * (i + 0.5) / PIXELS + u * (1 - (j + 0.5) / rows) for c, r, u in zip(scene.corner, scene.right, scene.up))
        return rows, [at(i, j) for j in range(rows) for i in range(PIXELS)]

    def picture(self, name, scene, text):
        rows, _ = self.places(scene)
        path, image = os.path.join(self.out, name + ".pov"), os.path.join(self.out, name + ".ppm")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        seconds = self.bench.user_seconds(["povray", f"+I{path}", f"+O{image}", "+FP16", f"+W{PIXELS}", f"+H{rows}", "-D", "-A", "+WT1", "File_Gamma=1.0"])
        with open(image, "rb") as file:
            data = file.read()
        head = re.match(rb"P6\s+(?:#[^\n]*\s+)*(\d+)\s+(\d+)\s+(\d+)\s", data)
        if not head or (int(head[1]), int(head[2])) != (PIXELS, rows):
            sys.exit(f"{image}: not the picture that was asked for")
        wide, raw = int(head[3]) > 255, data[head.end():]
        value = (lambda k: (raw[2 * k] << 8 | raw[2 * k + 1]) / 65535) if wide else (lambda k: raw[k] / 255)
        return seconds, [value(3 * k) for k in range(PIXELS * rows)]

    def render(self, name, scene, spacing):
        rows, _ = self.places(scene)
        vector = lambda v: f"<{v[0]:.9g}, {v[1]:.9g}, {v[2]:.9g}>"
        middle = [c + 0.5 * (r + u) + 0.0005 * n for c, r, u, n in zip(scene.corner, scene.right, scene.up, scene.normal)]
        body = f"""camera {{ orthographic location {vector(middle)} direction {vector([-n for n in scene.normal])} right {vector(scene.right)} up {vector(scene.up)} }}
{scene.light}
{scene.receiver}
"""
        begin = "#version 3.7;\n#declare L = {level};\nglobal_settings {{ assumed_gamma 1 max_trace_level 12 adc_bailout 1e-4 {photons} }}\n"
        level, photons = scene.brightness, f"photons {{ spacing {spacing} max_trace_level 12 autostop 0 }}"
        seconds, light = self.picture(name, scene, begin.format(level=level, photons=photons) + body + scene.body.replace("REST", scene.material))
        black = "pigment { rgb 0 } finish { ambient 0 diffuse 0 }"
        _, direct = self.picture(name + "_direct", scene, begin.format(level=level, photons="") + body + scene.body.replace("REST", black))
        if max(light) >= 1:
            print(f"  {name}: {sum(v >= 1 for v in light)} pixels are too bright for the picture", flush=True)
        return seconds, [a - b for a, b in zip(light, direct)]

    def looked_up(self, volume, scene):
        _, places = self.places(scene)
        points = os.path.join(self.out, "points.csv")
        with open(points, "w", encoding="utf-8") as file:
            file.write("x,y,z,nx,ny,nz\n")
            for place in places:
                file.write(",".join(f"{v:.9g}" for v in (*place, *scene.normal)) + "\n")
        done = subprocess.run([self.bench.given.photic, "sample", volume, points], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True)
        rows = csv.DictReader(line for line in done.stdout.splitlines() if not line.startswith("#"))
        names = [n for n in rows.fieldnames if n.startswith("face_irradiance")]  # one, or one a channel
        return [sum(float(row[n] or 0) for n in names) / len(names) for row in rows]  # nothing is kept where all is dark

    def blocks(self, light, rows):
        """Means over 3 x 3 pixels."""
        return [sum(light[(j + b) * PIXELS + i + a] for b in range(3) for a in range(3)) / 9
                for j in range(0, rows - 2, 3) for i in range(0, PIXELS - 2, 3)]

    def run(self, only):
        table = []
        for example, scene in pov_scenes().items():
            if only and example not in only:
                continue
            toml = self.bench.scene(example)
            with open(toml, encoding="utf-8") as file:
                text = file.read()
            for what, by in scene.edits:
                text, count = re.subn(what, by, text)
                if count == 0:
                    sys.exit(f"{example}: nothing to change for POV-Ray where {what} was")
            with open(toml, "w", encoding="utf-8") as file:
                file.write(text)
            rows, _ = self.places(scene)
            careful = ["--quadrature", "4", "--tolerance", "0.1", "--where", "receivers"]
            _, _, fine = self.bench.bake(toml, example + "_fine", careful, resolution=384)
            truth = self.blocks(self.looked_up(fine, scene), rows)

            def error(light, scaled):
                blocks = self.blocks(light, rows)
                scale = sum(truth) / sum(blocks) if scaled else 1
                return sum(abs(scale * a - b) for a, b in zip(blocks, truth)) / sum(truth)

            for resolution in (64, 128):
                seconds, _, volume = self.bench.bake(toml, example + "_lookup", ["--where", "receivers"], self.bench.given.tries, resolution)
                e = error(self.looked_up(volume, scene), False)
                table.append([example, f"beams, {resolution} voxels, band", f"{seconds:.2f}", f"{100 * e:.2g} %"])
                self.bench.points.append((example + RECEIVER, "beams", f"{resolution} voxels", seconds, e))
            for spacing in scene.spacings:
                seconds, light = self.render(f"{example}_{spacing}", scene, spacing)
                e = error(light, True)
                table.append([example, f"POV-Ray, spacing {spacing}", f"{seconds:.2f}", f"{100 * e:.2g} %"])
                self.bench.points.append((example + RECEIVER, "POV-Ray", f"spacing {spacing}", seconds, e))
            for row in table:
                if row[0] == example:
                    print("| " + " | ".join(row) + " |", flush=True)
        return table
