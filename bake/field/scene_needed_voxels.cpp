// SPDX-License-Identifier: Apache-2.0
#include "bake/field/scene_needed_voxels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr double kTolerance = 1e-6;  // [voxels]

// Points p with |axis . p - middle| <= radius.
struct Slab {
    glm::dvec3 axis{0};
    double middle = 0, radius = 0;
};

struct Interval {
    double min, max;
};

// The z for which (x, y, z) lies in a slab, cut with `z`; empty when min > max.
void cut(Interval& z, const Slab& slab, double x, double y) {
    const double offset = slab.middle - slab.axis.x * x - slab.axis.y * y;
    if (std::fabs(slab.axis.z) < 1e-12) {
        if (std::fabs(offset) > slab.radius) z = {1, 0};
        return;
    }
    const double a = (offset - slab.radius) / slab.axis.z, b = (offset + slab.radius) / slab.axis.z;
    z.min = std::max(z.min, std::min(a, b));
    z.max = std::min(z.max, std::max(a, b));
}

int firstInside(double z) { return static_cast<int>(std::ceil(z - kTolerance)); }
int lastInside(double z) { return static_cast<int>(std::floor(z + kTolerance)); }

// Voxels whose centre is within `band` of the plane in the maximum norm of index space: |m . p - c| <= band |m|_1.
void addPlane(NeededVoxels& needed, const Plane& plane, double band) {
    const GridFrame& frame = needed.frame();
    const glm::dvec3 m = frame.indexNormal(plane.normal);
    const Slab slab{m, glm::dot(plane.normal, plane.point - frame.origin_world),
                    (band + kTolerance) * (std::fabs(m.x) + std::fabs(m.y) + std::fabs(m.z))};

    // Columns that the plane misses altogether are skipped by rows: x and y play the part of z in the slab.
    const double reach = slab.radius + std::max(std::fabs(m.z * frame.min.z), std::fabs(m.z * frame.max.z));
    for (int x = frame.min.x; x <= frame.max.x; ++x) {
        Interval rows{double(frame.min.y), double(frame.max.y)};
        cut(rows, {glm::dvec3(m.x, 0, m.y), slab.middle, reach}, x, 0);
        for (int y = firstInside(rows.min); y <= lastInside(rows.max); ++y) {
            Interval z{double(frame.min.z), double(frame.max.z)};
            cut(z, slab, x, y);
            if (z.min <= z.max + kTolerance) needed.addColumn(x, y, firstInside(z.min), lastInside(z.max));
        }
    }
}

// Voxels whose centre is within `band` of a triangle in the maximum norm of index space: those in the Minkowski sum of
// the triangle and a cube. Its faces are normal to the 13 axes of the separating-axis test [Akenine-Moller 2001], and
// every axis is a slab, so a column's part of it is one interval.
void addTriangle(NeededVoxels& needed, const std::array<glm::dvec3, 3>& v, double band) {
    const GridFrame& frame = needed.frame();
    const double half = band + kTolerance;
    const glm::dvec3 low = glm::min(glm::min(v[0], v[1]), v[2]) - half,
                     high = glm::max(glm::max(v[0], v[1]), v[2]) + half;
    if (!(high.z >= frame.min.z && low.z <= frame.max.z)) return;  // a NaN ends here too
    const Interval xs{std::max(low.x, double(frame.min.x)), std::min(high.x, double(frame.max.x))};
    const Interval ys{std::max(low.y, double(frame.min.y)), std::min(high.y, double(frame.max.y))};
    if (!(xs.min <= xs.max && ys.min <= ys.max)) return;

    std::array<Slab, 10> slabs;
    std::size_t count = 0;
    const auto addSlab = [&](const glm::dvec3& axis) {
        const double size = std::fabs(axis.x) + std::fabs(axis.y) + std::fabs(axis.z);
        if (size < 1e-12) return;  // parallel edges: another axis covers it
        const double a = glm::dot(axis, v[0]), b = glm::dot(axis, v[1]), c = glm::dot(axis, v[2]);
        const double min = std::min({a, b, c}), max = std::max({a, b, c});
        slabs[count++] = {axis, 0.5 * (min + max), 0.5 * (max - min) + half * size};
    };
    addSlab(glm::cross(v[1] - v[0], v[2] - v[0]));
    for (std::size_t e = 0; e < 3; ++e) {
        const glm::dvec3 edge = v[(e + 1) % 3] - v[e];
        addSlab({0, -edge.z, edge.y});
        addSlab({edge.z, 0, -edge.x});
        addSlab({-edge.y, edge.x, 0});
    }
    for (int x = static_cast<int>(std::ceil(xs.min)); x <= static_cast<int>(std::floor(xs.max)); ++x)
        for (int y = static_cast<int>(std::ceil(ys.min)); y <= static_cast<int>(std::floor(ys.max)); ++y) {
            Interval z{std::max(low.z, double(frame.min.z)), std::min(high.z, double(frame.max.z))};
            for (std::size_t s = 0; s < count && z.min <= z.max; ++s) cut(z, slabs[s], x, y);
            if (z.min <= z.max)
                needed.addColumn(x, y, static_cast<int>(std::ceil(z.min)), static_cast<int>(std::floor(z.max)));
        }
}

NeededVoxels nearReceivers(const Scene& scene, const GridFrame& frame, Monitor& monitor) {
    NeededVoxels needed = NeededVoxels::none(frame);
    const double band = std::max(scene.bake.band, 1);
    bool any = false;
    for (const Object& object : scene.objects) {
        if (!object.receives()) continue;
        any = true;
        monitor.checkCancelled();
        if (const auto* plane = std::get_if<Plane>(&object.shape)) {
            addPlane(needed, *plane, band);
            continue;
        }
        const TriangleMesh& mesh = *std::get<std::shared_ptr<const TriangleMesh>>(object.shape);
        std::vector<glm::dvec3> index(mesh.positions.size());
        for (std::size_t i = 0; i < index.size(); ++i) index[i] = frame.indexFromWorld(mesh.positions[i]);
        for (const auto& t : mesh.triangles) addTriangle(needed, {index[t[0]], index[t[1]], index[t[2]]}, band);
    }
    if (!any)
        throw Error(
            ErrorCode::Input,
            "where = \"receivers\", but no object receives light; add an [[object]] with role = \"receiver\" or "
            "\"movable\", or use where = \"everywhere\"",
            scene.file);
    needed.finish();
    return needed;
}

// Upper bounds of the surfaces' height [m] over the cells of a lattice of pitch h that covers the domain and one cell
// more.
struct CellHeights {
    int x0, y0, nx, ny;
    double lowest, highest;
    std::vector<double> top;
    double& at(int x, int y) {
        return top[static_cast<std::size_t>(y - y0) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(x - x0)];
    }
    double at(int x, int y) const {
        x = std::clamp(x, x0, x0 + nx - 1), y = std::clamp(y, y0, y0 + ny - 1);
        return top[static_cast<std::size_t>(y - y0) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(x - x0)];
    }
};

// A surface without horizontal displacement: the largest of a cell's four corners; the caller's margin covers what lies
// between.
void raiseByCorners(CellHeights& cells, const HeightField& surface, double h) {
    const auto width = static_cast<std::size_t>(cells.nx + 1);
    std::vector<double> corners(width * static_cast<std::size_t>(cells.ny + 1));
    parallelFor(cells.ny + 1, [&](std::int64_t row) {
        SurfaceRow points;
        surface.row({cells.x0 * h, (cells.y0 + double(row)) * h}, h, width, points);
        std::copy(points.pz.begin(), points.pz.end(), corners.begin() + row * static_cast<std::int64_t>(width));
    });
    for (int y = 0; y < cells.ny; ++y)
        for (int x = 0; x < cells.nx; ++x) {
            const double* c = &corners[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)];
            double& top = cells.at(cells.x0 + x, cells.y0 + y);
            top = std::max({top, c[0], c[1], c[width], c[width + 1]});
        }
}

// A surface that moves sideways: two points a cell each way, each of which raises its cell and the eight around it.
void raiseByPoints(CellHeights& cells, const HeightField& surface, double h) {
    const int reach = static_cast<int>(std::ceil(surface.maxDisplacement() / h)) + 1;
    const auto width = static_cast<std::size_t>(2 * (cells.nx + 2 * reach));
    SurfaceRow points;
    for (int row = 0; row < 2 * (cells.ny + 2 * reach); ++row) {
        surface.row({(cells.x0 - reach + 0.25) * h, (cells.y0 - reach + 0.25 + 0.5 * row) * h}, 0.5 * h, width, points);
        for (std::size_t i = 0; i < width; ++i) {
            const int x = static_cast<int>(std::floor(points.px[i] / h)),
                      y = static_cast<int>(std::floor(points.py[i] / h));
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx)
                    if (x + dx >= cells.x0 && x + dx < cells.x0 + cells.nx && y + dy >= cells.y0 &&
                        y + dy < cells.y0 + cells.ny)
                        cells.at(x + dx, y + dy) = std::max(cells.at(x + dx, y + dy), points.pz[i]);
        }
    }
}

CellHeights cellHeights(const Scene& scene, double h) {
    CellHeights cells;
    const glm::dvec3 &min = scene.domain.min, &max = scene.domain.max;
    cells.x0 = static_cast<int>(std::floor(min.x / h)) - 1, cells.y0 = static_cast<int>(std::floor(min.y / h)) - 1;
    cells.nx = static_cast<int>(std::ceil(max.x / h)) + 1 - cells.x0,
    cells.ny = static_cast<int>(std::ceil(max.y / h)) + 1 - cells.y0;
    cells.lowest = std::numeric_limits<double>::infinity(), cells.highest = -cells.lowest;
    double meshes = -cells.lowest;
    for (const Surface& s : scene.surfaces) {
        double low = 0, high = 0;
        if (s.height_field) {
            low = s.height_field->minZ(), high = s.height_field->maxZ();
        } else {
            low = std::numeric_limits<double>::infinity(), high = -low;
            for (const auto& p : s.mesh->positions) low = std::min(low, p.z), high = std::max(high, p.z);
            meshes = std::max(meshes, high);  // light may pass under a mesh's open sides
            low = high;
        }
        cells.lowest = std::min(cells.lowest, low), cells.highest = std::max(cells.highest, high);
    }
    // Nothing to look up where the domain lies wholly below the surfaces.
    if (max.z <= cells.lowest) return cells;
    cells.top.assign(static_cast<std::size_t>(cells.nx) * static_cast<std::size_t>(cells.ny), meshes);
    for (const Surface& s : scene.surfaces) {
        if (!s.height_field) continue;
        if (s.height_field->maxDisplacement() > 0)
            raiseByPoints(cells, *s.height_field, h);
        else
            raiseByCorners(cells, *s.height_field, h);
    }
    return cells;
}

// The layers in which a leaning column overlaps [low, high] of one axis: cell + shift * k .. cell + 1 + shift * (k +
// 1).
void cutColumn(Interval& layers, double cell, double shift, double low, double high) {
    const double a = cell + std::min(shift, 0.0), b = cell + 1 + std::max(shift, 0.0);
    if (shift == 0) {
        if (b <= low || a >= high) layers = {1, 0};
        return;
    }
    const double k0 = (low - b) / shift, k1 = (high - a) / shift;
    layers.min = std::max(layers.min, std::min(k0, k1)), layers.max = std::min(layers.max, std::max(k0, k1));
}

NeededVoxels inMedium(const Scene& scene, const GridFrame& frame, Monitor& monitor) {
    if (scene.surfaces.empty())
        throw Error(ErrorCode::Input,
                    "where = \"media\", but there is no surface for the medium to lie below; add a [[surface]] or use "
                    "where = \"everywhere\"",
                    scene.file);
    const double h = frame.worldFromIndex()[0][0], layer = frame.worldFromIndex()[2][2];
    const double shift_x = frame.worldFromIndex()[2][0] / h, shift_y = frame.worldFromIndex()[2][1] / h;
    const CellHeights cells = cellHeights(scene, h);
    if (cells.top.empty() && shift_x == 0 && shift_y == 0) return NeededVoxels::everything(frame);

    // A voxel's bottom is at k * layer. Half a voxel of margin for what the cells' corners do not show.
    const int sure = std::min(frame.max.z, static_cast<int>(std::ceil(cells.lowest / layer)) - 1);
    const int possible = std::min(frame.max.z, static_cast<int>(std::ceil(cells.highest / layer + 0.5)) - 1);
    const glm::dvec3 low = scene.domain.min / glm::dvec3(h, h, layer) + kTolerance,
                     high = scene.domain.max / glm::dvec3(h, h, layer) - kTolerance;
    NeededVoxels needed = NeededVoxels::none(frame);
    for (int x = frame.min.x; x <= frame.max.x; ++x) {
        if ((x & 63) == 0) monitor.checkCancelled();
        for (int y = frame.min.y; y <= frame.max.y; ++y) {
            Interval layers{double(frame.min.z), double(possible)};
            cutColumn(layers, x, shift_x, low.x, high.x);
            cutColumn(layers, y, shift_y, low.y, high.y);
            const int first = static_cast<int>(std::ceil(layers.min)), last = static_cast<int>(std::floor(layers.max));
            if (first > last) continue;
            if (first <= sure) needed.addColumn(x, y, first, std::min(last, sure));
            if (cells.top.empty()) continue;
            for (int k = std::max(first, sure + 1); k <= last; ++k) {
                const double x_low = x + std::min(shift_x * k, shift_x * (k + 1)),
                             y_low = y + std::min(shift_y * k, shift_y * (k + 1));
                const int x1 = static_cast<int>(std::ceil(x_low + 1 + std::fabs(shift_x) - kTolerance)) - 1;
                const int y1 = static_cast<int>(std::ceil(y_low + 1 + std::fabs(shift_y) - kTolerance)) - 1;
                double top = -std::numeric_limits<double>::infinity();
                for (int cy = static_cast<int>(std::floor(y_low + kTolerance)); cy <= y1; ++cy)
                    for (int cx = static_cast<int>(std::floor(x_low + kTolerance)); cx <= x1; ++cx)
                        top = std::max(top, cells.at(cx, cy));
                if (k * layer < top + 0.5 * layer) needed.addColumn(x, y, k, k);
            }
        }
    }
    needed.finish();
    return needed;
}

}  // namespace

NeededVoxels sceneNeededVoxels(const Scene& scene, const GridFrame& frame, Monitor& monitor) {
    monitor.checkCancelled();
    switch (scene.bake.where) {
        case Where::Receivers:
            return nearReceivers(scene, frame, monitor);
        case Where::Media:
            return inMedium(scene, frame, monitor);
        case Where::Everywhere:
            break;
    }
    return NeededVoxels::everything(frame);
}

}  // namespace photic
