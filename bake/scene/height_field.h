// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace photic {

/// A point of a surface over a parameter plane.
struct SurfacePoint {
    glm::dvec3 position{0};  ///< world [m]
    glm::dvec3 normal{0};  ///< world, upwards (z > 0 unless it folds), d(position)/du x d(position)/dv, NOT normalised
};

/// Surface points as arrays, for vectorised tracing.
struct SurfaceRow {
    std::vector<double> px, py, pz, nx, ny, nz;
    void resize(std::size_t count) {
        for (auto* a : {&px, &py, &pz, &nx, &ny, &nz}) a->resize(count);
    }
};

/// A smooth surface z = h(x, y), or one with horizontal displacement, over the whole parameter plane
/// (u, v) in metres; what lies outside the patch follows the scene's `outside` setting.
/// Thread-safe for reading.
class HeightField {
public:
    virtual ~HeightField() = default;

    /// Position and normal at parameter (u, v) [m, world x and y before horizontal displacement].
    virtual SurfacePoint at(glm::dvec2 uv) const = 0;

    /// at() for u = start.x + i * step, v = start.y, i in [0, count); `out` is resized to count.
    /// Implementations vectorise; agrees with at() to 1e-12 of the surface's extent.
    virtual void row(glm::dvec2 start, double step, std::size_t count, SurfaceRow& out) const {
        out.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            const SurfacePoint p = at({start.x + step * static_cast<double>(i), start.y});
            out.px[i] = p.position.x, out.py[i] = p.position.y, out.pz[i] = p.position.z;
            out.nx[i] = p.normal.x, out.ny[i] = p.normal.y, out.nz[i] = p.normal.z;
        }
    }

    /// Lower and upper bound of z, and of |horizontal displacement| [m].
    virtual double minZ() const = 0;
    virtual double maxZ() const = 0;
    virtual double maxDisplacement() const { return 0; }
    /// A length [m] below which the surface is smooth: sample spacing of a map, shortest wavelength / 8 of a sum of
    /// sines. A flat surface returns +infinity.
    virtual double featureSize() const = 0;
};

}  // namespace photic
