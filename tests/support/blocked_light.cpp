// SPDX-License-Identifier: Apache-2.0
#include "tests/support/blocked_light.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <map>
#include <numbers>
#include <utility>

#include "tests/support/closed_forms.h"

namespace photic::truth {
namespace {

bool meetsBall(const Ball& ball, const glm::dvec3& origin, const glm::dvec3& direction) {
    const glm::dvec3 to = ball.center - origin;
    const double along = glm::dot(to, direction), square = glm::dot(to, to) - along * along;
    return along > 0 && square < ball.radius * ball.radius;
}

bool meetsBox(const Box& box, const glm::dvec3& origin, const glm::dvec3& direction) {
    double near = 0, far = 1e300;
    for (int a = 0; a < 3; ++a) {
        double t0 = (box.min[a] - origin[a]) / direction[a], t1 = (box.max[a] - origin[a]) / direction[a];
        if (direction[a] == 0) {
            if (origin[a] < box.min[a] || origin[a] > box.max[a]) return false;
            continue;
        }
        if (t0 > t1) std::swap(t0, t1);
        near = std::max(near, t0), far = std::min(far, t1);
    }
    return near < far;
}

// Moeller and Trumbore 1997.
bool meetsTriangle(const std::array<glm::dvec3, 3>& v, const glm::dvec3& origin, const glm::dvec3& direction) {
    const glm::dvec3 e1 = v[1] - v[0], e2 = v[2] - v[0], p = glm::cross(direction, e2);
    const double det = glm::dot(e1, p);
    if (det == 0) return false;
    const glm::dvec3 s = origin - v[0];
    const double u = glm::dot(s, p) / det;
    if (u < 0 || u > 1) return false;
    const glm::dvec3 q = glm::cross(s, e1);
    const double w = glm::dot(direction, q) / det;
    return w >= 0 && u + w <= 1 && glm::dot(e2, q) / det > 0;
}

bool meetsTriangles(const Triangles& mesh, const glm::dvec3& origin, const glm::dvec3& direction) {
    if (!meetsBall({mesh.center, mesh.radius}, origin, direction)) return false;
    for (const auto& t : mesh.triangles) {
        const std::array<glm::dvec3, 3> v{mesh.positions[static_cast<std::size_t>(t[0])],
                                          mesh.positions[static_cast<std::size_t>(t[1])],
                                          mesh.positions[static_cast<std::size_t>(t[2])]};
        if (meetsTriangle(v, origin, direction)) return true;
    }
    return false;
}

// A unit icosahedron whose triangles are quartered and pushed out to the sphere.
Triangles icosphere(int subdivisions) {
    const double g = std::numbers::phi;
    Triangles mesh;
    mesh.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                      {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (glm::dvec3& p : mesh.positions) p = glm::normalize(p);
    for (int level = 0; level < subdivisions; ++level) {
        std::map<std::pair<int, int>, int> middles;
        const auto middle = [&](int a, int b) {
            const auto [it, added] = middles.try_emplace(std::minmax(a, b), static_cast<int>(mesh.positions.size()));
            if (added)
                mesh.positions.push_back(glm::normalize(mesh.positions[static_cast<std::size_t>(a)] +
                                                        mesh.positions[static_cast<std::size_t>(b)]));
            return it->second;
        };
        std::vector<std::array<int, 3>> finer;
        for (const auto& [a, b, c] : mesh.triangles) {
            const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
        }
        mesh.triangles = std::move(finer);
    }
    return mesh;
}

}  // namespace

double Dice::uniform() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

double Dice::logBetween(double low, double high) { return low * std::pow(high / low, uniform()); }

SineWater::Point SineWater::at(const glm::dvec2& p) const {
    Point point;
    for (const Harmonic& h : harmonics) {
        const double angle = h.direction_deg * std::numbers::pi / 180, k = 2 * std::numbers::pi / h.wavelength;
        const glm::dvec2 across = k * glm::dvec2(std::cos(angle), std::sin(angle));
        const double phase = glm::dot(across, p) + h.phase;
        point.height += h.amplitude * std::sin(phase);
        point.slope += h.amplitude * std::cos(phase) * across;
    }
    return point;
}

double SineWater::steepest() const {
    double sum = 0;
    for (const Harmonic& h : harmonics) sum += h.amplitude * 2 * std::numbers::pi / h.wavelength;
    return sum;
}

Ball hull(const Solid& solid) {
    if (const auto* ball = std::get_if<Ball>(&solid)) return *ball;
    if (const auto* box = std::get_if<Box>(&solid))
        return {0.5 * (box->min + box->max), 0.5 * glm::length(box->max - box->min)};
    const auto& mesh = std::get<Triangles>(solid);
    return {mesh.center, mesh.radius};
}

bool meets(const Solid& solid, const glm::dvec3& origin, const glm::dvec3& direction) {
    if (const auto* ball = std::get_if<Ball>(&solid)) return meetsBall(*ball, origin, direction);
    if (const auto* box = std::get_if<Box>(&solid)) return meetsBox(*box, origin, direction);
    return meetsTriangles(std::get<Triangles>(solid), origin, direction);
}

double shadowArea(const Box& box, const glm::dvec3& direction) {
    const glm::dvec3 side = box.max - box.min, d = glm::abs(direction);
    return side.x * side.y + side.y * side.z * d.x / d.z + side.x * side.z * d.y / d.z;
}

double shadowArea(const Ball& ball, const glm::dvec3& direction) {
    return std::numbers::pi * ball.radius * ball.radius * glm::length(direction) / std::fabs(direction.z);
}

Triangles rock(const glm::dvec3& center, double width, int subdivisions, std::uint64_t seed) {
    Triangles mesh = icosphere(subdivisions);
    Dice dice(seed);
    const glm::dvec3 phase(dice.between(0, 6.28), dice.between(0, 6.28), dice.between(0, 6.28));
    mesh.center = center, mesh.radius = 0;
    for (glm::dvec3& p : mesh.positions) {
        const glm::dvec3 lumps = glm::sin(3.0 * p + phase);
        p = center + 0.5 * width * (0.85 + 0.15 * lumps.x * lumps.y * lumps.z) * p;
        mesh.radius = std::max(mesh.radius, glm::length(p - center));
    }
    return mesh;
}

std::optional<Refracted> refractDown(const glm::dvec3& in, const glm::dvec2& slope, double ior_below) {
    const glm::dvec3 normal = glm::normalize(glm::dvec3(-slope, 1));
    const double cos_in = -glm::dot(in, normal);
    if (cos_in <= 0) return std::nullopt;
    const double cos_out = std::sqrt(1 - (1 - cos_in * cos_in) / (ior_below * ior_below));
    return Refracted{(in + (cos_in - ior_below * cos_out) * normal) / ior_below,
                     fresnelTransmittance(cos_in, 1, ior_below)};
}

BlockedLight blockedLight(const SineWater& water, const glm::dvec3& direction, const Solid& solid, double plane_z,
                          int side) {
    // A ray may be bent away from that under flat water by a third of the surface's slope, more where it leans.
    const Ball around = hull(solid);
    const double depth = around.radius - around.center.z;
    const glm::dvec3 down = refractDown(direction, {0, 0}, water.ior_below)->direction;
    const glm::dvec2 middle = glm::dvec2(around.center) - glm::dvec2(down) / down.z * around.center.z;
    const double lean = 1 / (down.z * down.z);
    // The raster stands askew, lest a box's sides run along it.
    const glm::dvec2 askew(std::cos(0.5), std::sin(0.5));
    const double half =
        (askew.x + askew.y) * (around.radius * std::sqrt(lean) * 1.05 + 0.6 * depth * lean * water.steepest());
    const double cell = 2 * half / side;
    BlockedLight blocked;
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            const glm::dvec2 q = cell * (glm::dvec2(i, j) + 0.5) - half;
            const glm::dvec2 p = middle + glm::dvec2(askew.x * q.x - askew.y * q.y, askew.y * q.x + askew.x * q.y);
            const SineWater::Point surface = water.at(p);
            const auto ray = refractDown(direction, surface.slope, water.ior_below);
            const glm::dvec3 origin(p, surface.height);
            if (!ray || !meets(solid, origin, ray->direction)) continue;
            // Power through the raster's cell: the beam's cross-section of a patch of the surface.
            blocked.power += -glm::dot(direction, glm::dvec3(-surface.slope, 1)) * cell * cell * ray->transmittance;
            const glm::dvec2 landing = p + glm::dvec2(ray->direction) / ray->direction.z * (plane_z - surface.height);
            blocked.low = glm::min(blocked.low, landing), blocked.high = glm::max(blocked.high, landing);
        }
    }
    return blocked;
}

}  // namespace photic::truth
