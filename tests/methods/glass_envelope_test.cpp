// SPDX-License-Identifier: Apache-2.0
// Where light goes through slabs and prisms, and where it is brightest inside of circular mirrors, at three
// resolutions.
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

constexpr int kCells[] = {16, 32, 64};

/// A ray and what of its power is left.
struct Ray {
    glm::dvec3 origin{0}, direction{0};
    double power = 0;
};

/// Snell's and Fresnel's laws at a plane, written out here. @param normal  against the ray
Ray throughPlane(const Ray& ray, const glm::dvec3& point, const glm::dvec3& normal, double from, double to) {
    const double along = glm::dot(point - ray.origin, normal) / glm::dot(ray.direction, normal);
    const double cosine = -glm::dot(ray.direction, normal), eta = from / to;
    const double inner = std::sqrt(1 - eta * eta * (1 - cosine * cosine));
    return {ray.origin + along * ray.direction, eta * ray.direction + (eta * cosine - inner) * normal,
            ray.power * truth::fresnelTransmittance(cosine, from, to)};
}

/// Two flat faces that a beam goes through, and the glass between.
struct TwoFaces {
    glm::dvec3 point[2], normal[2];  ///< against the light
    double ior = 1.5;
    Ray through(const Ray& ray) const {
        return throughPlane(throughPlane(ray, point[0], normal[0], 1, ior), point[1], normal[1], ior, 1);
    }
};

/// What a beam leaves on the grid's layer at z: power and its centre.
struct Landing {
    double power = 0;
    glm::dvec2 centre{0};
};

/// A spot so far away that its beam is all but parallel, as wide as the glass is high.
constexpr double kFar = 20, kRadius = 0.12;

Light farSpot(const glm::dvec3& direction, const glm::dvec3& aim) {
    Light spot;
    spot.name = "spot", spot.type = LightType::Spot, spot.direction = glm::normalize(direction);
    spot.position = aim - kFar * spot.direction;
    spot.power = glm::dvec3(4 * std::numbers::pi * kFar * kFar), spot.irradiance = glm::dvec3(1);
    spot.cone_angle_deg = 2 * std::atan(kRadius / kFar) * 180 / std::numbers::pi, spot.blend = 1;
    return spot;
}

/// The same beam as rays through the faces, to a level plane.
Landing landingOfRays(const Light& spot, const TwoFaces& faces, double z) {
    constexpr int kRays = 400;
    const glm::dvec3 across = glm::normalize(glm::cross(spot.direction, glm::dvec3(0, 1, 0))),
                     up = glm::cross(across, spot.direction);
    Landing out;
    for (int i = 0; i < kRays; ++i)
        for (int j = 0; j < kRays; ++j) {
            const glm::dvec2 q = ((glm::dvec2(i, j) + 0.5) / double(kRays) * 2.0 - 1.0) * kRadius;
            const glm::dvec3 to = kFar * spot.direction + q.x * across + q.y * up;
            const double length = glm::length(to), cosine = kFar / length;
            const double area = 4 * kRadius * kRadius / kRays / kRays;
            Ray ray{*spot.position, to / length,
                    spot.spotFalloff(cosine) * kFar * kFar * area * cosine / (length * length)};
            if (ray.power <= 0) continue;
            ray = faces.through(ray);
            const glm::dvec3 at = ray.origin + (z - ray.origin.z) / ray.direction.z * ray.direction;
            out.power += ray.power, out.centre += ray.power * glm::dvec2(at);
        }
    out.centre /= out.power;
    return out;
}

Landing landingInLayer(const LightField& field, int layer) {
    const GridFrame& f = field.frame();
    Landing out;
    const double side = f.worldFromIndex()[0][0];
    for (int x = f.min.x; x <= f.max.x; ++x)
        for (int y = f.min.y; y <= f.max.y; ++y) {
            const double power = -field.flux({x, y, layer}).z * side * side;
            out.power += power, out.centre += power * glm::dvec2(f.worldFromIndex(glm::dvec3(x, y, layer)));
        }
    out.centre /= out.power;
    return out;
}

void expectBeamsToLand(const TriangleMesh& body, const TwoFaces& faces, const glm::dvec3& direction,
                       const glm::dvec3& aim) {
    double last = 0;
    for (const int cells : kCells) {
        GlassScene glass(cells);
        glass.scene.lights = {farSpot(direction, aim)};
        glass.scene.media[1].ior = faces.ior;
        glass.add(body, SurfaceEvent::Refract).smooth = false;
        glass.scene.bake.bounces = 2;
        const BakeResult baked = glass.bake(beamsMethod());
        const int layer = -cells * 3 / 8;
        const double z = glass.frame.worldFromIndex({0, 0, layer}).z, voxel = 2.0 / cells;
        const Landing rays = landingOfRays(glass.scene.lights[0], faces, z), tubes = landingInLayer(baked.field, layer);
        const double off = glm::length(tubes.centre - rays.centre);
        std::printf("  %d cells: power off by %.1e, centre by %.1e voxels\n", cells, tubes.power / rays.power - 1,
                    off / voxel);
        EXPECT_NEAR(tubes.power / rays.power, 1, 2e-3);
        EXPECT_LT(off, 0.03 * voxel) << "of a beam that is two voxels wide at the coarsest";
        last = off / voxel;
    }
    EXPECT_LT(last, 0.005);
}

TEST(GlassEnvelope, ASlabShiftsABeamAsSnellSays) {
    TwoFaces faces;
    faces.point[0] = {0, 0, 0.4}, faces.point[1] = {0, 0, 0.1};
    faces.normal[0] = faces.normal[1] = {0, 0, 1};
    expectBeamsToLand(support::boxMesh({-0.9, -0.9, 0.1}, {0.9, 0.9, 0.4}), faces, {0.8, 0.1, -1}, {-0.4, 0, 0.4});
}

TEST(GlassEnvelope, APrismTurnsABeamAsSnellSays) {
    const double half = 15 * std::numbers::pi / 180;
    // An edge along y at the right; the faces above and below lean by half the angle.
    const glm::dvec3 edge(0.6, 0, 0.3);
    const double length = 1.3, thick = length * std::tan(half);
    TriangleMesh prism;
    for (const double y : {-0.9, 0.9})
        for (const glm::dvec2 q : {glm::dvec2(0, 0), glm::dvec2(-length, thick), glm::dvec2(-length, -thick)})
            prism.positions.push_back(edge + glm::dvec3(q.x, y, q.y));
    prism.triangles = {{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}};
    for (auto& t : prism.triangles) {
        // Outwards, whatever the order above.
        const glm::dvec3 middle = edge + glm::dvec3(-2 * length / 3, 0, 0);
        const glm::dvec3 &a = prism.positions[t[0]], &b = prism.positions[t[1]], &c = prism.positions[t[2]];
        if (glm::dot(glm::cross(b - a, c - a), a - middle) < 0) std::swap(t[1], t[2]);
    }
    TwoFaces faces;
    faces.point[0] = faces.point[1] = edge;
    faces.normal[0] = {std::sin(half), 0, std::cos(half)}, faces.normal[1] = {-std::sin(half), 0, std::cos(half)};
    faces.ior = 1.6;
    expectBeamsToLand(withFacetNormals(prism), faces, {0.3, 0.05, -1}, {-0.1, 0, 0.45});
}

/// How far from an envelope the brightest voxels of lines across it lie.
class MissesOfEnvelope {
public:
    MissesOfEnvelope(const LightField& field, double voxel) : field_(field), voxel_(voxel) {}

    /// @param place    on the envelope [m]
    /// @param across   unit
    /// @param from     [voxels] where the line begins; it ends at 4
    void look(const glm::dvec3& place, const glm::dvec3& across, double from, double degrees) {
        double brightest = 0, where = 1e9;
        for (double t = from; t <= 4; t += 0.125) {
            const glm::ivec3 v(glm::round(field_.frame().indexFromWorld(place + t * voxel_ * across)));
            if (const double e = field_.irradiance(v); e > brightest) brightest = e, where = t;
        }
        EXPECT_LT(std::fabs(where), 1.75) << degrees << " degrees: the brightest voxel is not at the envelope";
        sum_ += std::fabs(where) * voxel_, ++lines_;
    }

    /// [m], below a voxel.
    double expectSmall() const {
        const double mean = sum_ / lines_;
        std::printf("  voxels of %.4f m: brightest on average %.4f m from the envelope\n", voxel_, mean);
        EXPECT_LT(mean, 0.9 * voxel_);
        return mean;
    }

private:
    const LightField& field_;
    double voxel_, sum_ = 0;
    int lines_ = 0;
};

/// The upright half of a circular mirror that is open to the left.
struct HalfRing {
    static constexpr double kRadius = 0.8, kWidest = 80 * std::numbers::pi / 180;
    glm::dvec3 axis{-0.05, 0.013, 0};

    void addTo(GlassScene& glass, int cells) const {
        const int columns = 6 * cells, rows = 2;
        TriangleMesh ring;
        for (int r = 0; r <= rows; ++r)
            for (int c = 0; c <= columns; ++c) {
                const double a = kWidest * (2.0 * c / columns - 1);
                ring.positions.push_back(
                    axis + glm::dvec3(kRadius * std::cos(a), kRadius * std::sin(a), -0.8 + 1.6 * r / rows));
                ring.normals.emplace_back(-std::cos(a), -std::sin(a), 0);
            }
        const auto at = [&](int r, int c) { return static_cast<std::uint32_t>(r * (columns + 1) + c); };
        for (int r = 0; r < rows; ++r)
            for (int c = 0; c < columns; ++c) {
                ring.triangles.push_back({at(r, c), at(r + 1, c), at(r, c + 1)});
                ring.triangles.push_back({at(r + 1, c), at(r + 1, c + 1), at(r, c + 1)});
            }
        glass.add(std::move(ring), SurfaceEvent::Mirror).closed = false;
        glass.scene.bake.bounces = 1;
    }

    /// Along the way of the light that leaves the mirror at an angle, by 1/s + 1/s' = 2 / (R cos i).
    /// @param parallel  or from the point of the circle on the left
    /// @return how far from the envelope the brightest voxels lie [m], mean of some places
    double expectBrightestAtTheEnvelope(const LightField& field, bool parallel, double voxel) const {
        MissesOfEnvelope misses(field, voxel);
        for (const double degrees : {-52.0, -40.0, -28.0, 24.0, 37.0, 49.0}) {
            const double a = degrees * std::numbers::pi / 180;
            const glm::dvec2 mirror(kRadius * std::cos(a), kRadius * std::sin(a)), normal = -mirror / kRadius;
            const glm::dvec2 in = parallel ? glm::dvec2(1, 0) : glm::normalize(mirror - glm::dvec2(-kRadius, 0));
            const double cosine = -glm::dot(in, normal);
            const glm::dvec2 out = in + 2 * cosine * normal, aside(-out.y, out.x);
            const double source = 2 * kRadius * cosine;
            const double image = 1 / (2 / (kRadius * cosine) - (parallel ? 0 : 1 / source));
            // Across the envelope, which the light touches: where is the brightest of the voxels on that line?
            misses.look(axis + glm::dvec3(mirror + image * out, -0.1), glm::dvec3(aside, 0), -4, degrees);
        }
        return misses.expectSmall();
    }
};

/// Of what falls as the voxels do, from the first resolution to the last.
void expectSlope(const std::vector<double>& errors, double slope) {
    EXPECT_GT(std::log2(errors.front() / errors.back()) / 2, slope);
}

TEST(GlassEnvelope, ParallelLightInACupIsBrightestAtTheNephroid) {
    std::vector<double> errors;
    for (const int cells : kCells) {
        GlassScene glass(cells, {1, 0, -0.2});
        HalfRing ring;
        ring.addTo(glass, cells);
        errors.push_back(ring.expectBrightestAtTheEnvelope(glass.bake(beamsMethod()).field, true, 2.0 / cells));
    }
    expectSlope(errors, 0.7);
}

TEST(GlassEnvelope, LightFromTheRimIsBrightestAtTheCardioid) {
    std::vector<double> errors;
    for (const int cells : kCells) {
        GlassScene glass(cells);
        HalfRing ring;
        Light& lamp = glass.scene.lights[0];
        lamp.type = LightType::Point, lamp.power = glm::dvec3(10);
        lamp.position = ring.axis + glm::dvec3(-HalfRing::kRadius, 0, 0.05), lamp.direction = {1, 0, 0};
        ring.addTo(glass, cells);
        errors.push_back(ring.expectBrightestAtTheEnvelope(glass.bake(beamsMethod()).field, false, 2.0 / cells));
    }
    expectSlope(errors, 0.7);
}

/// A ball of an even index under a sun that shines along -z, by the closed form: a ray that comes in at b = R sin t is
/// turned by 2 (t - t'), and crosses the level `depth` below the centre at r = b cos(delta) - s sin(delta), with
/// depth = b sin(delta) + s cos(delta).
struct BallLens {
    static constexpr double kRadius = 0.7, kIor = 1.333;
    glm::dvec3 centre{0.011, -0.017, 0.25};

    void addTo(GlassScene& glass) const {
        glass.addSphere(centre, kRadius, SurfaceEvent::Refract);
        glass.scene.media[1].ior = kIor, glass.scene.bake.bounces = 2;
    }
    double radiusAt(double b, double depth) const {
        const double t = std::asin(b / kRadius), turned = 2 * (t - std::asin(b / kRadius / kIor));
        const double s = (depth - b * std::sin(turned)) / std::cos(turned);
        return b * std::cos(turned) - s * std::sin(turned);
    }
    /// The light of both faces that crosses that level within a radius of the axis [W].
    double powerWithin(double radius, double depth) const {
        constexpr int kRings = 200'000;
        double sum = 0;
        for (int i = 0; i < kRings; ++i) {
            const double b = kRadius * (i + 0.5) / kRings;
            if (std::fabs(radiusAt(b, depth)) > radius) continue;
            const double cosine = std::sqrt(1 - b * b / kRadius / kRadius),
                         t = truth::fresnelTransmittance(cosine, 1, kIor);
            sum += 2 * std::numbers::pi * b * kRadius / kRings * t * t;
        }
        return sum;
    }
    /// Where the rays of one plane touch their envelope: the largest radius that they have before they cross the axis.
    double envelopeAt(double depth) const {
        double largest = 0;
        for (int i = 1; i < 20'000; ++i) largest = std::max(largest, radiusAt(0.95 * kRadius * i / 20'000, depth));
        return largest;
    }
};

/// What crosses a layer of voxels within a radius of a point of it [W]; voxels that the circle cuts, by their share.
double powerInCircle(const LightField& field, int layer, const glm::dvec2& centre, double radius) {
    constexpr int kParts = 32;
    const GridFrame& f = field.frame();
    const double side = f.worldFromIndex()[0][0];
    double sum = 0;
    for (int x = f.min.x; x <= f.max.x; ++x)
        for (int y = f.min.y; y <= f.max.y; ++y) {
            int inside = 0;
            for (int i = 0; i < kParts * kParts; ++i) {
                const glm::dvec2 part = (glm::dvec2(i % kParts, i / kParts) + 0.5) / double(kParts) - 0.5;
                const glm::dvec2 at(f.worldFromIndex(glm::dvec3(glm::dvec2(x, y) + part, layer)));
                inside += glm::length(at - centre) <= radius;
            }
            sum -= field.flux({x, y, layer}).z * side * side * inside / (kParts * kParts);
        }
    return sum;
}

TEST(GlassEnvelope, ABallLensGathersItsPowerAroundTheAxis) {
    const BallLens ball;
    std::vector<double> errors;
    for (const int cells : kCells) {
        GlassScene glass(cells);
        ball.addTo(glass);
        const LightField field = glass.bake(beamsMethod()).field;
        double off = 0, all = 0;
        // Layers in the same places at every resolution, but for half of a voxel.
        for (const double z : {-0.5625, -0.6875, -0.8125, -0.9375}) {
            const int layer = static_cast<int>(std::floor(z * cells / 2));
            const double depth = ball.centre.z - glass.frame.worldFromIndex({0, 0, layer}).z;
            for (const double radius : {0.15, 0.3, 0.45, 0.6}) {
                const double exact = ball.powerWithin(radius, depth),
                             found = powerInCircle(field, layer, glm::dvec2(ball.centre), radius);
                off += std::fabs(found - exact), all += exact;
            }
        }
        std::printf("  %d cells: power within a radius of the axis off by %.4f of it\n", cells, off / all);
        errors.push_back(off / all);
    }
    EXPECT_LT(errors.back(), 0.01);
    expectSlope(errors, 1);
}

TEST(GlassEnvelope, LightBehindABallLensIsBrightestAtItsEnvelope) {
    const BallLens ball;
    std::vector<double> errors;
    for (const int cells : {32, 64, 128}) {
        GlassScene glass(cells);
        ball.addTo(glass);
        const LightField field = glass.bake(beamsMethod()).field;
        MissesOfEnvelope misses(field, 2.0 / cells);
        for (const double z : {-0.51, -0.55, -0.6})
            for (const double degrees : {13.0, 75.0, 140.0, 205.0, 290.0}) {
                const double a = degrees * std::numbers::pi / 180;
                const glm::dvec3 out(std::cos(a), std::sin(a), 0);
                const glm::dvec3 at =
                    glm::dvec3(ball.centre.x, ball.centre.y, z) + ball.envelopeAt(ball.centre.z - z) * out;
                // Not as far inwards as the axis, which is bright too.
                misses.look(at, out, -1.5, degrees);
            }
        errors.push_back(misses.expectSmall());
    }
    expectSlope(errors, 0.7);
}

}  // namespace
}  // namespace photic
