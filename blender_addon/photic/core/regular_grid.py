# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds out whether a mesh is a regular grid: water that can be baked as a smooth height field.

Two kinds are known: vertices that stand over a lattice along x and y, in any order; and vertices in the order of a grid
(Blender's Grid, and its Ocean) that moved sideways too, which is a height field with horizontal displacement.
"""
import dataclasses

import numpy

LEAST_SIDE = 4              # vertices a side, that a height map needs
UNEVEN = 1e-3               # of the spacing: what rounding moves vertices by
TURNED = 0.1                # slope of the lattice's axes against x and y: it becomes displacement
LARGEST_MOVE = 0.2          # of the patch's size: farther, the baker would have to look for light everywhere


class NotRegular(Exception):
    """Why a mesh is no height field, as the end of a sentence: "it is a mesh, as ..."."""


@dataclasses.dataclass
class Grid:
    """Samples from edge to edge of a patch. Row 0 is at the lowest y."""
    size: tuple             # [m]
    center: tuple           # [m], with the mean height
    heights: numpy.ndarray  # rows x columns [m], above the centre
    moves: tuple            # (along x, along y) [m], or None

    @property
    def shape_words(self):
        rows, columns = self.heights.shape
        return f"{columns} × {rows}"


def find(positions, triangles):
    """The grid that a mesh is; positions n x 3 [m], triangles m x 3. Raises NotRegular."""
    columns, rows = (_lattice_along(positions[:, axis]) for axis in (0, 1))
    if columns is not None and rows is not None:
        return _upright(positions, triangles, columns, rows)
    return _displaced(positions, triangles)


def _lattice_along(values):
    """(index of each value, count, first, spacing) when values stand in even steps; None when they don't."""
    values = values.astype(float)
    extent = values.max() - values.min()
    ordered = numpy.sort(values)
    starts = numpy.concatenate([[True], numpy.diff(ordered) > 1e-5 * extent])
    count = int(starts.sum())
    if count < 2 or extent <= 0:
        return None
    spacing = extent / (count - 1)
    steps = (values - ordered[0]) / spacing
    index = numpy.rint(steps).astype(numpy.int64)
    if numpy.abs(steps - index).max() > max(UNEVEN, 1e-5 * (count - 1)) or not numpy.bincount(index, minlength=count).all():
        return None
    return index, count, float(ordered[0]), float(spacing)


def _upright(positions, triangles, columns, rows):
    (i, width, x, dx), (j, height, y, dy) = columns, rows
    if width * height > len(positions):
        raise NotRegular("its grid has gaps")
    place, z = j * width + i, positions[:, 2]
    heights = numpy.full(width * height, numpy.nan)
    heights[place] = z
    if numpy.isnan(heights).any():
        raise NotRegular("its grid has gaps")
    if numpy.abs(z - heights[place]).max() > 1e-6 * max(dx, dy) + 1e-6 * numpy.abs(z).max():
        raise NotRegular("it has points above each other")
    _check(i, j, width, height, triangles)
    heights = heights.reshape(height, width)
    level = float(heights.mean())
    size = ((width - 1) * dx, (height - 1) * dy)
    return Grid(size, (x + size[0] / 2, y + size[1] / 2, level), heights - level, None)


def _displaced(positions, triangles):
    i, j, width, height = _order(len(positions), triangles)
    _check(i, j, width, height, triangles)
    # The lattice that is nearest; the rest is displacement. For an ocean that repeats it is the ocean's own.
    design = numpy.stack([i, j, numpy.ones(len(i))], axis=1)
    solution, *_ = numpy.linalg.lstsq(design, positions[:, :2], rcond=None)
    axes = solution[:2]                                     # row: along i, along j; column: x, y
    if abs(axes[0, 0]) < abs(axes[0, 1]):                   # rows run along y
        i, j, width, height, axes = j, i, height, width, axes[::-1]
    if abs(axes[0, 1]) > TURNED * abs(axes[0, 0]) or abs(axes[1, 0]) > TURNED * abs(axes[1, 1]):
        raise NotRegular("its grid is turned about the vertical, away from x and y")
    if axes[0, 0] < 0:
        i = width - 1 - i
    if axes[1, 1] < 0:
        j = height - 1 - j
    dx, dy = abs(axes[0, 0]), abs(axes[1, 1])
    size = ((width - 1) * dx, (height - 1) * dy)
    middle = positions[:, :2].mean(axis=0)                  # of the lattice too: least squares keeps the mean
    order = numpy.argsort(j * width + i)
    field = positions[order].reshape(height, width, 3)
    steps_x, steps_y = numpy.arange(width) - (width - 1) / 2, numpy.arange(height) - (height - 1) / 2
    along_x, along_y = field[..., 0] - middle[0] - dx * steps_x, field[..., 1] - middle[1] - dy * steps_y[:, None]
    if max(numpy.abs(along_x).max() / size[0], numpy.abs(along_y).max() / size[1]) > LARGEST_MOVE:
        raise NotRegular("its vertices are too far from a grid along x and y")
    _refuse_folds(positions, triangles)
    level = float(field[..., 2].mean())
    return Grid(size, (float(middle[0]), float(middle[1]), level), field[..., 2] - level, (along_x, along_y))


def _order(count, triangles):
    """Column and row of each vertex when they are numbered row by row."""
    edges = numpy.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(numpy.int64)
    steps = numpy.flatnonzero(numpy.bincount(numpy.abs(edges[:, 0] - edges[:, 1])))
    # Along a row 1; to the next row the width, and across a cell one more or less.
    for width in steps[1:3] if len(steps) in (3, 4) and steps[0] == 1 else ():
        width = int(width)
        if count % width == 0 and set(steps.tolist()) <= {1, width - 1, width, width + 1}:
            number = numpy.arange(count)
            return number % width, number // width, width, count // width
    raise NotRegular("its vertices are no regular grid")


def _check(i, j, width, height, triangles):
    """Every cell has its two triangles, and there are no others."""
    if width < LEAST_SIDE or height < LEAST_SIDE:
        raise NotRegular(f"a grid of {width} × {height} is too small for a height map, which needs {LEAST_SIDE} a side")
    (low_i, high_i, sum_i), (low_j, high_j, sum_j) = (_over_corners(index, triangles) for index in (i, j))
    if (high_i - low_i).max() != 1 or (high_j - low_j).max() != 1:
        raise NotRegular("its triangles join more than neighbours")
    # The corner that a triangle lacks: those of a cell's two are opposite to each other.
    lacks_i, lacks_j = 2 - (sum_i - 3 * low_i), 2 - (sum_j - 3 * low_j)
    cell = low_j * (width - 1) + low_i
    cells = (width - 1) * (height - 1)
    whole = len(triangles) == 2 * cells and all(
        (numpy.bincount(cell, weights, minlength=cells) == wanted).all()
        for weights, wanted in ((None, 2), (lacks_i, 1), (lacks_j, 1)))
    if not whole:
        raise NotRegular("its grid has gaps")


def _over_corners(index, triangles):
    """(least, greatest, sum) over each triangle's corners."""
    a, b, c = (index[triangles[:, corner]] for corner in range(3))
    return numpy.minimum(numpy.minimum(a, b), c), numpy.maximum(numpy.maximum(a, b), c), a + b + c


def _refuse_folds(positions, triangles):
    a, b, c = (positions[triangles[:, corner], :2] for corner in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    if not ((area > 0).all() or (area < 0).all()):
        raise NotRegular("its waves break: the surface folds over itself")
