#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""make_arch.py: writes arch.obj beside itself: the underside of a bridge's arch over a canal, its faces towards the water."""
import math
import os

RADIUS, SPRING, HALF_LENGTH, SEGMENTS = 2.0, 0.35, 1.5, 48  # [m]; where the arch begins above the water


def main():
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "arch.obj"), "w", encoding="ascii") as out:
        out.write("# made by make_arch.py\n")
        for i in range(SEGMENTS + 1):
            angle = math.pi * i / SEGMENTS
            x, z = RADIUS * math.cos(angle), SPRING + 0.8 * RADIUS * math.sin(angle)
            for y in (-HALF_LENGTH, HALF_LENGTH):
                out.write(f"v {x:.4f} {y:.4f} {z:.4f}\n")
        for i in range(SEGMENTS):
            a = 2 * i + 1
            out.write(f"f {a} {a + 1} {a + 3} {a + 2}\n")


main()
