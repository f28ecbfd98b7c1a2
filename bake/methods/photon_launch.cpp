// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/photon_launch.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace photic {
namespace {

/// Finaliser of SplitMix64 (Steele, Lea and Flood 2014): a bijection whose outputs pass as random.
std::uint64_t mixed(std::uint64_t x) {
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ x >> 27) * 0x94d049bb133111ebull;
    return x ^ x >> 31;
}
constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ull;

double fraction(std::uint64_t fixed_point) { return static_cast<double>(fixed_point >> 11) * 0x1p-53; }

/// Square to disc, keeping areas and neighbourhoods (Shirley and Chiu 1997).
void concentricDisc(double a, double b, double& x, double& y) {
    const double u = 2 * a - 1, v = 2 * b - 1;
    if (u == 0 && v == 0) {
        x = y = 0;
        return;
    }
    const bool wide = std::fabs(u) > std::fabs(v);
    const double radius = wide ? u : v;
    const double phi = wide ? std::numbers::pi / 4 * (v / u) : std::numbers::pi / 2 - std::numbers::pi / 4 * (u / v);
    x = radius * std::cos(phi), y = radius * std::sin(phi);
}

}  // namespace

PhotonPoints::PhotonPoints(PhotonSampling sampling, int dimensions, std::uint64_t seed, std::uint64_t stream)
    : sampling_(sampling), dimensions_(dimensions), key_(mixed(mixed(seed + kGolden) + stream * kGolden)) {
    // Roots of phi^3 = phi + 1 and phi^5 = phi + 1.
    const long double phi = dimensions == 2 ? 1.32471795724474602596090885447809L : 1.16730397826141868425604589985484L;
    long double alpha = 1;
    for (std::size_t j = 0; j < static_cast<std::size_t>(dimensions); ++j) {
        alpha /= phi;
        alpha_[j] = static_cast<std::uint64_t>(alpha * 0x1p64L);
        shift_[j] = mixed(key_ + (j + 1) * kGolden);
    }
}

std::array<double, 4> PhotonPoints::at(std::uint64_t index) const {
    std::array<double, 4> x{0.5, 0.5, 0.5, 0.5};
    for (std::size_t j = 0; j < static_cast<std::size_t>(dimensions_); ++j)
        x[j] = fraction(sampling_ == PhotonSampling::Quasi ? shift_[j] + index * alpha_[j]
                                                           : mixed(key_ + (4 * index + j) * kGolden));
    return x;
}

PhotonLaunch::PhotonLaunch(const Scene& scene, const Surface& surface, const Light& light, const GridFrame& frame)
    : surface_(&surface), light_(&light) {
    const glm::dvec3 d = light.direction;
    across_ = glm::normalize(glm::cross(d, std::fabs(d.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    up_ = glm::cross(across_, d);
    const double radius = 0.5 * light.angular_diameter_deg * std::numbers::pi / 180;
    cap_height_ = 2 * std::pow(std::sin(0.5 * radius), 2);

    if (surface.height_field) {
        domain_ = launchDomain(scene, surface, light, frame);
        cross_section_ = domain_.area() * std::max(0.0, -d.z);
        return;
    }
    // Triangles by the area that the light sees; the sun's radius keeps those that only its rim sees.
    const TriangleMesh& mesh = *surface.mesh;
    share_.reserve(mesh.triangles.size()), cumulative_.reserve(mesh.triangles.size());
    for (const auto& t : mesh.triangles) {
        const glm::dvec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
        const glm::dvec3 area = 0.5 * glm::cross(b - a, c - a);
        share_.push_back(std::fabs(glm::dot(d, area)) + std::sin(radius) * glm::length(area));
        cross_section_ += share_.back();
        cumulative_.push_back(cross_section_);
    }
    for (double& c : cumulative_) c /= cross_section_;
}

glm::dvec3 PhotonLaunch::sunDirection(double a, double b) const {
    if (cap_height_ <= 0) return light_->direction;
    double x, y;
    concentricDisc(a, b, x, y);
    // Uniform over the solid angle: 1 - cos is proportional to the square of the disc's radius.
    const double s = x * x + y * y, height = s * cap_height_;
    const double scale = std::sqrt(cap_height_ * (2 - height));  // sin of the angle over the disc's radius
    return (1 - height) * light_->direction + scale * (x * across_ + y * up_);
}

PhotonStart PhotonLaunch::start(const std::array<double, 4>& x) const {
    PhotonStart out;
    out.direction = sunDirection(x[2], x[3]);
    if (!surface_->height_field) {
        startOnMesh(x[0], x[1], out);
        return out;
    }
    const glm::dvec2 uv = domain_.min + glm::dvec2(x[0], x[1]) * (domain_.max - domain_.min);
    const SurfacePoint point = surface_->height_field->at(uv);
    out.position = point.position;
    out.normal = out.face = glm::normalize(point.normal);
    out.area = domain_.area() * std::max(0.0, -glm::dot(out.direction, point.normal));
    return out;
}

void PhotonLaunch::startOnMesh(double u, double v, PhotonStart& out) const {
    const auto found = std::upper_bound(cumulative_.begin(), cumulative_.end(), u);
    const auto k =
        static_cast<std::size_t>(std::min<std::ptrdiff_t>(found - cumulative_.begin(), std::ssize(cumulative_) - 1));
    const double low = k == 0 ? 0 : cumulative_[k - 1], width = cumulative_[k] - low;
    // What the choice of a triangle left of u is as uniform as u was.
    const double s = std::sqrt(width > 0 ? std::clamp((u - low) / width, 0.0, 1.0) : 0.5);
    const double wa = 1 - s, wb = s * (1 - v), wc = s * v;

    const TriangleMesh& mesh = *surface_->mesh;
    const auto& t = mesh.triangles[k];
    const glm::dvec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const glm::dvec3 area = 0.5 * glm::cross(b - a, c - a);
    const double size = glm::length(area);
    if (size <= 0 || share_[k] <= 0) return;
    out.position = wa * a + wb * b + wc * c;
    out.face = area / size;
    const glm::dvec3 normal = wa * mesh.normals[t[0]] + wb * mesh.normals[t[1]] + wc * mesh.normals[t[2]];
    const double length = glm::length(normal);
    // Vertex normals decide which side is above only through the face: a smooth normal never points to its back.
    out.normal = length > 0 && glm::dot(normal, out.face) > 0 ? normal / length : out.face;
    out.area = cross_section_ * std::fabs(glm::dot(out.direction, area)) / share_[k];
}

}  // namespace photic
