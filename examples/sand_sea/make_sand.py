#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""make_sand.py: writes sand.obj beside itself: a beach that falls away from 0.7 m of water to 1.7 m, with ripples a hand wide."""
import math
import os

SIDE, EXTENT = 97, 4.4  # points a side; metres

def height(x, y):
    """[m], Z up."""
    slope = -1.2 - 0.22 * x + 0.06 * math.sin(1.3 * x + 0.8) * math.cos(1.1 * y)
    bent = x + 0.12 * math.sin(1.7 * y) + 0.05 * math.sin(4.1 * y + 1.0)
    return slope + 0.022 * (1 - abs(math.sin(math.pi * bent / 0.24))) + 0.008 * math.sin(5.3 * y + 2.1 * x)


def main():
    places = [EXTENT * (i / (SIDE - 1) - 0.5) for i in range(SIDE)]
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "sand.obj"), "w", encoding="ascii") as out:
        out.write("# made by make_sand.py\n")
        for y in places:
            for x in places:
                out.write(f"v {x:.4f} {y:.4f} {height(x, y):.4f}\n")
        for j in range(SIDE - 1):
            for i in range(SIDE - 1):
                a = j * SIDE + i + 1
                out.write(f"f {a} {a + 1} {a + SIDE + 1} {a + SIDE}\n")


main()
