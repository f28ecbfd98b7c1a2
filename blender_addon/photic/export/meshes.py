# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluated meshes, modifiers and all, as arrays in the world's frame."""
import dataclasses
import functools

import numpy

COSINE_OF_A_CREASE = 0.9990     # of 2.5 degrees: between a corner's normal and the mean of all at its vertex


@dataclasses.dataclass
class Mesh:
    positions: numpy.ndarray    # n x 3, world [m]
    triangles: numpy.ndarray    # m x 3
    smooth_share: float         # of the polygons that are shaded smooth
    normals: numpy.ndarray | None = None    # m x 3 x 3, unit, of each triangle's corners as Blender shades them

    def bounds(self):
        return self.positions.min(axis=0), self.positions.max(axis=0)

    def mean_normal(self):
        """Sum of the triangles' areas as vectors: 0 for a closed mesh."""
        a, b, c = (self.positions[self.triangles[:, i]] for i in range(3))
        return numpy.cross(b - a, c - a).sum(axis=0) / 2

    def area(self):
        a, b, c = (self.positions[self.triangles[:, i]] for i in range(3))
        return float(numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1).sum() / 2)

    def thickness(self):
        """Twice the volume over the area [m], of a closed mesh: a sheet's own, two thirds of a ball's radius."""
        a, b, c = (self.positions[self.triangles[:, i]] - self.positions.mean(axis=0) for i in range(3))
        return 2 * abs(float((a * numpy.cross(b, c)).sum())) / 6 / max(self.area(), 1e-300)

    @functools.cached_property
    def closed(self):
        """No edge of the mesh belongs to one triangle only. Positions in one place count as one vertex."""
        if not len(self.triangles):
            return False
        _, welded = numpy.unique(numpy.round(self.positions, 9), axis=0, return_inverse=True)
        corners = welded.reshape(-1)[self.triangles]
        edges = numpy.sort(numpy.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]), axis=1)
        _, count = numpy.unique(edges, axis=0, return_counts=True)
        return bool((count > 1).all())

    @functools.cached_property
    def creased(self):
        """Shaded smooth but for some of its edges: sharp ones, flat faces beside smooth ones, or custom normals."""
        if self.normals is None or not 0 < self.smooth_share:
            return False
        corners = self.triangles.reshape(-1)
        sums = numpy.zeros((len(self.positions), 3))
        numpy.add.at(sums, corners, self.normals.reshape(-1, 3))
        mean = sums / numpy.maximum(numpy.linalg.norm(sums, axis=1, keepdims=True), 1e-12)
        leaning = (mean[corners] * self.normals.reshape(-1, 3)).sum(axis=1)
        return bool((leaning < COSINE_OF_A_CREASE).any())

    def turned(self):
        """The other side out."""
        normals = None if self.normals is None else -self.normals[:, ::-1]
        return Mesh(self.positions, self.triangles[:, ::-1], self.smooth_share, normals)


def evaluated(object_evaluated, matrix_world, depsgraph):
    """The mesh of an evaluated object (or instance), or None when it has no faces. Mirroring matrices keep outsides out."""
    mesh = object_evaluated.to_mesh(preserve_all_data_layers=False, depsgraph=depsgraph)
    try:
        if mesh is None:
            return None
        mesh.calc_loop_triangles()
        count = len(mesh.loop_triangles)
        if count == 0:
            return None
        positions = numpy.empty(len(mesh.vertices) * 3)
        mesh.vertices.foreach_get("co", positions)
        triangles = numpy.empty(count * 3, dtype=numpy.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
        smooth = numpy.empty(len(mesh.polygons), dtype=bool)
        mesh.polygons.foreach_get("use_smooth", smooth)
        corners = numpy.empty(count * 3, dtype=numpy.int32)
        mesh.loop_triangles.foreach_get("loops", corners)
        normals = _corner_normals(mesh)[corners]
    finally:
        object_evaluated.to_mesh_clear()
    matrix = numpy.array(matrix_world, dtype=float)
    positions = positions.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
    triangles = triangles.reshape(-1, 3)
    normals = normals @ numpy.linalg.pinv(matrix[:3, :3])
    normals = (normals / numpy.maximum(numpy.linalg.norm(normals, axis=1, keepdims=True), 1e-12)).reshape(-1, 3, 3)
    if numpy.linalg.det(matrix[:3, :3]) < 0:
        triangles, normals = triangles[:, ::-1], normals[:, ::-1]
    return Mesh(positions, triangles, float(smooth.mean()), normals)


def _corner_normals(mesh):
    """Of each face corner, with sharp edges, auto smooth and custom normals. Blender 4.1 keeps them by itself."""
    normals = numpy.empty(len(mesh.loops) * 3, dtype=numpy.float32)
    # 4.0 has both, and its corner_normals are empty.
    if hasattr(mesh, "calc_normals_split"):
        mesh.calc_normals_split()
        mesh.loops.foreach_get("normal", normals)
    else:
        mesh.corner_normals.foreach_get("vector", normals)
    return normals.reshape(-1, 3).astype(float)
