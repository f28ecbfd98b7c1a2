#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""examples/robotics/make_targets.py > targets.csv: points on a camera's target, at three depths.

A target has a level board, which a camera that looks down sees, and an upright one, which faces a camera that looks
along +y. Points are 4 cm apart.
"""
BOARDS = {"level": (0, 0, 1), "upright": (0, -1, 0)}
STEPS = range(-5, 6)

print("depth [m],board,x [m],y [m],z [m],nx,ny,nz")
for depth in (2, 5, 10):
    for board, normal in BOARDS.items():
        for i in STEPS:
            for j in STEPS:
                x, other = 0.04 * i, 0.04 * j
                y, z = (other, -depth) if board == "level" else (0.0, other - depth)
                print(f"{depth},{board},{x:.2f},{y:.2f},{z:.2f},{','.join(map(str, normal))}")
