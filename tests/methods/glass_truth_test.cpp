// SPDX-License-Identifier: Apache-2.0
// Tubes through lenses and off mirrors against rays that are followed here, by formulas of their own: how far voxel
// averages are off, and that they converge.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "bake/methods/beams.h"
#include "tests/methods/glass_scene.h"
#include "tests/support/closed_forms.h"

namespace photic {
namespace {

using test::GlassScene;

/// Voxel averages of irradiance from rays with a power: exact path lengths in each voxel.
class RayField {
public:
    explicit RayField(const GridFrame& frame) : frame_(frame), size_(frame.max - frame.min + 1) {
        values_.resize(static_cast<std::size_t>(size_.x) * size_.y * size_.z);
    }

    /// @param length  of the ray [m]; infinity: to the grid's end
    void add(const glm::dvec3& origin, const glm::dvec3& direction, double length, double power) {
        const glm::dvec3 p = frame_.indexFromWorld(origin) - glm::dvec3(frame_.min) + 0.5;
        const glm::dvec3 d = frame_.indexDirection(direction);
        double at = 0, end = length;
        for (int k = 0; k < 3; ++k) {
            if (std::fabs(d[k]) < 1e-12) {
                if (p[k] <= 0 || p[k] >= size_[k]) return;
                continue;
            }
            const double low = (0 - p[k]) / d[k], high = (size_[k] - p[k]) / d[k];
            at = std::max(at, std::min(low, high)), end = std::min(end, std::max(low, high));
        }
        const double volume = frame_.voxelVolume();
        while (at < end - 1e-12) {
            const glm::dvec3 inside = p + d * (at + 1e-9);
            glm::ivec3 cell(glm::floor(inside));
            cell = glm::clamp(cell, glm::ivec3(0), size_ - 1);
            double next = end;
            for (int k = 0; k < 3; ++k)
                if (std::fabs(d[k]) >= 1e-12) next = std::min(next, ((d[k] > 0 ? cell[k] + 1 : cell[k]) - p[k]) / d[k]);
            next = std::max(next, at + 1e-9);
            values_[index(cell)] += power * (next - at) / volume;
            at = next;
        }
    }

    /// Relative L1 of a field.
    double off(const LightField& field) const {
        double apart = 0, sum = 0;
        for (int x = 0; x < size_.x; ++x)
            for (int y = 0; y < size_.y; ++y)
                for (int z = 0; z < size_.z; ++z) {
                    const glm::ivec3 voxel = frame_.min + glm::ivec3(x, y, z);
                    apart += std::fabs(field.irradiance(voxel) - values_[index({x, y, z})]),
                        sum += values_[index({x, y, z})];
                }
        return apart / sum;
    }

private:
    std::size_t index(const glm::ivec3& c) const {
        return (static_cast<std::size_t>(c.x) * size_.y + c.y) * size_.z + c.z;
    }
    GridFrame frame_;
    glm::ivec3 size_;
    std::vector<double> values_;
};

/// Relative L1 at three resolutions, each twice the one before: of a bake as it is by default, and of a careful one.
struct Errors {
    std::vector<double> by_default, careful;
    void add(GlassScene& glass, const RayField& truth) {
        glass.scene.bake.quadrature = 0;  // what a scene file has when it says nothing
        by_default.push_back(truth.off(glass.bake(beamsMethod()).field));
        glass.scene.bake.quadrature = 4, glass.scene.bake.tolerance = 0.05;
        careful.push_back(truth.off(glass.bake(beamsMethod()).field));
    }
    /// @param slope  that the careful one's fall with at least, from the first to the last
    void expect(double finest_by_default, double finest_careful, double slope) const {
        for (const auto* errors : {&by_default, &careful})
            std::printf("relative L1: %.4f %.4f %.4f\n", (*errors)[0], (*errors)[1], (*errors)[2]);
        EXPECT_LT(by_default.back(), finest_by_default);
        EXPECT_LT(careful.back(), finest_careful);
        EXPECT_GT(std::log2(careful.front() / careful.back()) / 2, slope);
        EXPECT_GT(by_default.front(), by_default.back());
    }
};

constexpr int kCells[] = {16, 32, 64};
constexpr int kRaysACell = 30;  // along a side

// Paraxially the focus lies n R / 2 (n - 1) from the centre; rays farther out cross before, and their envelope is
// bright.
TEST(GlassTruth, ABallLens) {
    constexpr double radius = 0.4, index = 1.5;
    const glm::dvec3 centre(0.03, -0.02, 0.35);
    Errors errors;
    for (const int cells : kCells) {
        GlassScene glass(cells);
        glass.addSphere(centre, radius, SurfaceEvent::Refract);
        glass.scene.bake.bounces = 2;
        RayField truth(glass.frame);
        const int rays = kRaysACell * cells;
        for (int i = 0; i < rays; ++i)
            for (int j = 0; j < rays; ++j) {
                const glm::dvec2 q = (glm::dvec2(i, j) + 0.5) / double(rays) * 2.0 - 1.0;
                const double sine = glm::length(q);
                if (sine >= 1) continue;
                const double cosine = std::sqrt(1 - sine * sine);
                const double through = truth::fresnelTransmittance(cosine, 1, index);
                const glm::dvec3 normal(q, cosine), down(0, 0, -1);
                const glm::dvec3 first = centre + radius * normal;
                const double inner = std::sqrt(1 - sine * sine / index / index);
                const glm::dvec3 bent = glm::normalize(down / index + (cosine / index - inner) * normal);
                const double chord = 2 * radius * inner;
                const double power = 4.0 * radius * radius / rays / rays;
                truth.add(first, bent, chord, power * through);
                const glm::dvec3 second = first + chord * bent, out = (second - centre) / radius;
                const glm::dvec3 leaving = glm::normalize(index * bent + (cosine - index * inner) * out);
                truth.add(second, leaving, INFINITY, power * through * through);
            }
        errors.add(glass, truth);
    }
    // The ball of three voxels' radius is launched as finely as one of four: it has less left to fall by.
    errors.expect(0.006, 0.002, 0.5);
}

// A bowl whose mirror sends all of the sun through one point.
TEST(GlassTruth, AParabolicMirror) {
    constexpr double focal = 0.7, rim = 0.6;
    const glm::dvec3 bottom(0.01, 0.02, -0.71);
    Errors errors;
    for (const int cells : kCells) {
        GlassScene glass(cells);
        const int rings = 2 * cells, columns = 6 * cells;
        TriangleMesh bowl;
        for (int r = 0; r <= rings; ++r)
            for (int c = 0; c < columns; ++c) {
                const double q = rim * r / rings, a = 2 * std::numbers::pi * c / columns;
                bowl.positions.push_back(bottom + glm::dvec3(q * std::cos(a), q * std::sin(a), q * q / (4 * focal)));
                bowl.normals.push_back(
                    glm::normalize(glm::dvec3(-q * std::cos(a) / (2 * focal), -q * std::sin(a) / (2 * focal), 1)));
            }
        const auto at = [&](int r, int c) { return static_cast<std::uint32_t>(r * columns + c % columns); };
        for (int r = 0; r < rings; ++r)
            for (int c = 0; c < columns; ++c) {
                if (r > 0) bowl.triangles.push_back({at(r, c), at(r + 1, c), at(r, c + 1)});
                bowl.triangles.push_back({at(r + 1, c), at(r + 1, c + 1), at(r, c + 1)});
            }
        Surface& mirror = glass.add(std::move(bowl), SurfaceEvent::Mirror);
        mirror.closed = false, mirror.center = bottom;
        glass.scene.bake.bounces = 1;
        RayField truth(glass.frame);
        const int rays = kRaysACell * cells;
        for (int i = 0; i < rays; ++i)
            for (int j = 0; j < rays; ++j) {
                const glm::dvec2 q = ((glm::dvec2(i, j) + 0.5) / double(rays) * 2.0 - 1.0) * rim;
                const double r2 = glm::dot(q, q);
                if (r2 >= rim * rim) continue;
                const glm::dvec3 p = bottom + glm::dvec3(q, r2 / (4 * focal));
                const glm::dvec3 focus = bottom + glm::dvec3(0, 0, focal);
                truth.add(p, glm::normalize(focus - p), INFINITY, 4.0 * rim * rim / rays / rays);
            }
        errors.add(glass, truth);
    }
    errors.expect(0.006, 0.002, 0.75);
}

// Inside of half a ring, under a slanting sun: the nephroid, drawn out along the height. What meets the ring again is
// not followed.
TEST(GlassTruth, ARing) {
    constexpr double radius = 0.7, low = -0.55, high = 0.35, widest = 80 * std::numbers::pi / 180;
    const glm::dvec3 sun = glm::normalize(glm::dvec3(1, 0, -0.35)), axis(-0.1, 0.01, 0);
    Errors errors;
    for (const int cells : kCells) {
        GlassScene glass(cells, sun);
        const int columns = 6 * cells, rows = cells;
        TriangleMesh ring;
        for (int r = 0; r <= rows; ++r)
            for (int c = 0; c <= columns; ++c) {
                const double a = widest * (2.0 * c / columns - 1), z = low + (high - low) * r / rows;
                ring.positions.push_back(axis + glm::dvec3(radius * std::cos(a), radius * std::sin(a), z));
                ring.normals.emplace_back(-std::cos(a), -std::sin(a), 0);
            }
        const auto at = [&](int r, int c) { return static_cast<std::uint32_t>(r * (columns + 1) + c); };
        for (int r = 0; r < rows; ++r)
            for (int c = 0; c < columns; ++c) {
                ring.triangles.push_back({at(r, c), at(r + 1, c), at(r, c + 1)});
                ring.triangles.push_back({at(r + 1, c), at(r + 1, c + 1), at(r, c + 1)});
            }
        Surface& mirror = glass.add(std::move(ring), SurfaceEvent::Mirror);
        mirror.closed = false;
        glass.scene.bake.bounces = 1;
        RayField truth(glass.frame);
        const int rays = 3 * kRaysACell * cells / 2;  // with fewer their own noise shows
        for (int i = 0; i < rays; ++i)
            for (int j = 0; j < rays; ++j) {
                const double a = widest * (2 * (i + 0.5) / rays - 1), z = low + (high - low) * (j + 0.5) / (rays);
                const glm::dvec3 normal(-std::cos(a), -std::sin(a), 0);
                const glm::dvec3 p = axis - radius * normal + glm::dvec3(0, 0, z);
                const double facing = -glm::dot(sun, normal);
                const double area = radius * 2 * widest / rays * (high - low) / (rays);
                const glm::dvec3 out = sun + 2 * facing * normal;
                // A chord of the circle, to where it meets it again, if the ring is there.
                const double across = 2 * radius * facing / (out.x * out.x + out.y * out.y);
                const glm::dvec3 again = p + across * out;
                const double angle = std::atan2(again.y - axis.y, again.x - axis.x);
                const bool meets = std::fabs(angle) < widest && again.z > low && again.z < high;
                truth.add(p, out, meets ? across : INFINITY, facing * area);
            }
        errors.add(glass, truth);
    }
    errors.expect(0.018, 0.005, 0.6);
}

// The direction that light leaves a prism in, one wavelength at a time.
TEST(GlassTruth, APrismAtFiveWavelengths) {
    // Schott N-SF11, whose terms are public.
    const RefractiveIndex flint =
        RefractiveIndex::sellmeier({1.73759695, 0.313747346, 1.89878101}, {0.013188707, 0.0623068142, 155.23629});
    const double half = 30 * std::numbers::pi / 180;
    double last = 0;
    for (const double nm : {404.7, 486.1, 546.1, 587.6, 656.3}) {
        const double n = flint.at(nm), entry = 65 * std::numbers::pi / 180;
        // Of an edge up along y between faces whose outer normals are (-cos, 0, sin) and (cos, 0, sin) of `half`.
        const glm::dvec3 left(-std::cos(half), 0, std::sin(half)), right(std::cos(half), 0, std::sin(half));
        const glm::dvec3 tangent(std::sin(half), 0, std::cos(half));  // up along the left face
        const glm::dvec3 sun = -std::cos(entry) * left + std::sin(entry) * tangent;
        GlassScene glass(32, sun);
        glass.scene.media[1].ior = n;
        TriangleMesh prism;
        for (const double y : {-0.3, 0.3})
            for (const glm::dvec2 q :
                 {glm::dvec2(-0.3 * std::tan(half), -0.2), glm::dvec2(0.3 * std::tan(half), -0.2), glm::dvec2(0, 0.1)})
                prism.positions.emplace_back(q.x - 0.4, y, q.y);
        prism.triangles = {{0, 1, 2}, {3, 5, 4}, {0, 2, 5}, {0, 5, 3}, {1, 4, 5}, {1, 5, 2}, {0, 3, 4}, {0, 4, 1}};
        Surface& surface = glass.add(withFacetNormals(prism), SurfaceEvent::Refract);
        surface.smooth = false;
        glass.scene.bake.bounces = 2;
        const BakeResult baked = glass.bake(beamsMethod());
        const double inner = std::asin(std::sin(entry) / n), second = 2 * half - inner;
        const double leaving = std::asin(n * std::sin(second));
        const double deviation = entry + leaving - 2 * half;
        // Where the ray that enters the middle of the left face has come to, half a metre behind the right one.
        const glm::dvec3 top(-0.4, 0, 0.1), middle = top - 0.5 * 0.3 / std::cos(half) * tangent;
        const glm::dvec3 inside = -std::cos(inner) * left + std::sin(inner) * tangent;
        const glm::dvec3 leaves = middle + glm::dot(top - middle, right) / glm::dot(inside, right) * inside;
        const glm::dvec3 down_right(std::sin(half), 0, -std::cos(half));
        const glm::dvec3 out = std::cos(leaving) * right + std::sin(leaving) * down_right;
        const glm::ivec3 voxel(glm::round(glass.frame.indexFromWorld(leaves + 0.5 * out)));
        const glm::dvec3 flux = baked.field.flux(voxel);
        ASSERT_GT(glm::length(flux), 0);
        const double turned = std::acos(glm::dot(glm::normalize(flux), sun));
        EXPECT_NEAR(turned, deviation, 2e-4) << nm;
        EXPECT_LT(nm == 404.7 ? 0.0 : turned - last, 1e-9) << "red is bent less";
        last = turned;
    }
}

}  // namespace
}  // namespace photic
