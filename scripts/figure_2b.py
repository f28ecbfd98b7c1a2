#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/figure_2b.py > docs/pictures/figure_2b.svg: figure 2b of Mercier's report, beside the exact front.

Blue: water z = A cos(k x). Orange: rays of vertical light, refracted into n = 1.33. Red: exact fronts of those rays, at
equal optical paths. Green, dashed: fronts of an infinite index (parallel curves of the surface) whose depths are scaled,
as the report proposes, by the factor that brings their focus to the right depth, n / (n - 1). Violet, dotted: parallel
curves of the surface itself flattened by (n - 1) / n, which keeps both focus and front to first order in the slope.
"""
import math

A, K, N = 0.06, 2 * math.pi, 1.33
US = [i / 200 - 1 for i in range(401)]
LEVELS = [0.2, 0.4, 0.6, 0.8, 1.0]  # depths of the front of flat water


def surface(u):
    return A * math.cos(K * u), -A * K * math.sin(K * u)


def ray(u, n):
    """Where light from above goes on: point, and direction of travel."""
    h, slope = surface(u)
    beta = math.atan(slope)
    alpha = beta - (0.0 if math.isinf(n) else math.asin(math.sin(beta) / n))
    return u, h, math.sin(alpha), -math.cos(alpha)


def front(level):
    """n1 (-h) + n s = n level: the arrival of flat water at that depth."""
    points = []
    for u in US:
        x, h, dx, dz = ray(u, N)
        s = level + h / N
        points.append((x + s * dx, h + s * dz))
    return points


SCALE = N / (N - 1)


def scaled(level):
    """Parallel curves at level / SCALE, depths times SCALE."""
    points = []
    for u in US:
        x, h, dx, dz = ray(u, math.inf)
        points.append((x + level / SCALE * dx, (h + level / SCALE * dz) * SCALE))
    return points


def flattened(level):
    """Parallel curves of the surface flattened by SCALE."""
    points = []
    for u in US:
        h, slope = (v / SCALE for v in surface(u))
        length = math.hypot(1, slope)
        points.append((u + level * slope / length, h - level / length))
    return points


def misfit(curves):
    """Mean distance in depth to the exact fronts over |x| < 0.5."""
    total = count = 0
    for level in LEVELS:
        other = curves(level)
        for x, z in front(level):
            if abs(x) < 0.5:
                total += abs(min(other, key=lambda p: abs(p[0] - x))[1] - z)
                count += 1
    return total / count


def path(points, style):
    d = " ".join(f"{'M' if i == 0 else 'L'}{380 + 340 * x:.1f} {60 - 340 * z:.1f}" for i, (x, z) in enumerate(points))
    return f'<path d="{d}" fill="none" {style}/>'


print('<svg xmlns="http://www.w3.org/2000/svg" width="760" height="460" viewBox="0 0 760 460" font-family="sans-serif" font-size="13">')
print('<rect width="100%" height="100%" fill="white"/>')
for i in range(0, 401, 8):
    x, h, dx, dz = ray(US[i], N)
    print(path([(x, h), (x + 1.1 * dx, h + 1.1 * dz)], 'stroke="#f0a030" stroke-width="0.7"'))
for level in LEVELS:
    print(path(front(level), 'stroke="#c02020" stroke-width="1.6"'))
    print(path(scaled(level), 'stroke="#208040" stroke-width="1.4" stroke-dasharray="6 4"'))
    print(path(flattened(level), 'stroke="#8030a0" stroke-width="2" stroke-dasharray="1.5 3.5"'))
print(path([(u, surface(u)[0]) for u in US], 'stroke="#2050c0" stroke-width="2.4"'))
print(f'<text x="20" y="434">red: exact fronts, n = {N}; green: parallel curves, depths scaled by {SCALE:.2f} (mean misfit '
      f'{misfit(scaled):.4f} of a wavelength);</text>')
print(f'<text x="20" y="452">violet: parallel curves of the surface flattened by as much (misfit {misfit(flattened):.4f})</text>\n</svg>')
