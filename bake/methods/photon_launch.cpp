// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/photon_launch.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "bake/optics/tangent_frame.h"
#include "bake/paths/optical_scene.h"

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

double angularRadius(const Light& light) { return 0.5 * light.angular_diameter_deg * std::numbers::pi / 180; }

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

PhotonLight::PhotonLight(const Light& light)
    : light_(&light),
      centre_(lightSamples(light, 1).front()),
      cap_height_(light.type == LightType::Sun ? 2 * std::pow(std::sin(0.5 * angularRadius(light)), 2) : 0) {}

PhotonLaunch::PhotonLaunch(const Scene& scene, int surface, const Light& light, const GridFrame& frame)
    : scene_(&scene),
      surface_index_(surface),
      surface_(&scene.surfaces[static_cast<std::size_t>(surface)]),
      light_(light) {
    if (surface_->height_field) domain_ = launchDomain(scene, *surface_, light, frame);
    from_below_ = standsBelow(light, *surface_);
    if (surface_->mesh && !surface_->sphere) divideMesh();
    // A few samples tell about how much power there is; where none of them is lit, as under a spot whose cone is far
    // narrower than the triangles that it meets, more of them: what seems dark would get no photons.
    constexpr int kTries = 256, kMostTries = 1 << 18;
    const PhotonPoints points(PhotonSampling::Quasi, dimensions(), 1, 1);
    for (int tries = kTries; tries <= kMostTries && !(estimated_power_ > 0); tries *= 16)
        for (int i = 0; i < tries; ++i)
            estimated_power_ += channelMean(start(points.at(static_cast<std::uint64_t>(i))).power) / tries;
}

// Triangles by the area that a sun sees, whose radius keeps those that only its rim sees; pieces of them by a bound of
// what a lamp sends there.
void PhotonLaunch::divideMesh() {
    const TriangleMesh& mesh = *surface_->mesh;
    const Light& light = light_.light();
    share_.reserve(mesh.triangles.size()), cumulative_.reserve(mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const auto& t = mesh.triangles[i];
        if (light.type != LightType::Sun) {
            addPieces({static_cast<std::uint32_t>(i)}, 0);
            continue;
        }
        const glm::dvec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
        const glm::dvec3 area = 0.5 * glm::cross(b - a, c - a);
        addPiece(std::fabs(glm::dot(light.direction, area)) + std::sin(angularRadius(light)) * glm::length(area));
    }
    for (double& c : cumulative_) c /= total_share_;
}

void PhotonLaunch::addPiece(double share) {
    share_.push_back(share), total_share_ += share;
    cumulative_.push_back(total_share_);
}

// Quarters a piece until a lamp lights it about evenly: until it is small beside the way to the lamp, and beside the
// cone of a spot. Few photons would start where most of the light is if they started anywhere on a coarse mesh.
void PhotonLaunch::addPieces(const Piece& piece, int depth) {
    constexpr int kMostDepth = 24;
    constexpr double kSmall = 0.25;
    const TriangleMesh& mesh = *surface_->mesh;
    const auto& t = mesh.triangles[piece.triangle];
    const Light& light = light_.light();
    std::array<glm::dvec3, 3> at;
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2& w = piece.corners[i];
        at[i] = (1 - w.x - w.y) * mesh.positions[t[0]] + w.x * mesh.positions[t[1]] + w.y * mesh.positions[t[2]];
    }
    const glm::dvec3 middle = (at[0] + at[1] + at[2]) / 3.0, to = middle - *light.position;
    const double distance = glm::length(to),
                 lamp = light.type == LightType::Rectangle ? 0.5 * glm::length(light.size) : 0;
    double radius = 0;
    for (const glm::dvec3& corner : at) radius = std::max(radius, glm::length(corner - middle));
    const double reach = lamp + radius;
    double strength = 1;
    // A lamp with a face lights what is near to it evenly over its own width.
    bool small = radius <= kSmall * std::max(distance, lamp);
    if (light.type == LightType::Spot && distance > reach) {
        // The least angle from the axis at which light can come here.
        const double off = std::acos(std::clamp(glm::dot(to, light.direction) / distance, -1.0, 1.0)),
                     least = std::max(0.0, off - std::asin(reach / distance)),
                     cone = 0.5 * light.cone_angle_deg * std::numbers::pi / 180;
        strength = light.spotFalloff(std::cos(least));
        small = small && reach <= kSmall * distance * std::tan(std::min(cone, 1.0));
    }
    if (strength == 0) return;
    if (small || depth == kMostDepth) {
        const double area = piece.part * 0.5 *
                            glm::length(glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                                                   mesh.positions[t[2]] - mesh.positions[t[0]]));
        const double nearest = std::max(distance - reach, kSmall * reach);
        pieces_.push_back(piece);
        return addPiece(nearest > 0 ? area * strength / (nearest * nearest) : 0);
    }
    const auto& [a, b, c] = piece.corners;
    const glm::dvec2 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
    for (const std::array<glm::dvec2, 3>& corners :
         {std::array{a, ab, ca}, std::array{ab, b, bc}, std::array{bc, ca, ab}, std::array{ca, bc, c}})
        addPieces({piece.triangle, corners, 0.25 * piece.part}, depth + 1);
}

LightSample PhotonLight::sample(double a, double b) const {
    if (light_->type == LightType::Rectangle) {
        const glm::dvec3 up = glm::cross(light_->direction, light_->tangent);
        return {light_->direction,
                *light_->position + (a - 0.5) * light_->size.x * light_->tangent + (b - 0.5) * light_->size.y * up,
                light_->power / std::numbers::pi, light_};
    }
    if (cap_height_ <= 0) return centre_;
    LightSample sample = centre_;
    double x, y;
    concentricDisc(a, b, x, y);
    // Uniform over the solid angle: 1 - cos is proportional to the square of the disc's radius.
    const double s = x * x + y * y, height = s * cap_height_;
    const double scale = std::sqrt(cap_height_ * (2 - height));  // sin of the angle over the disc's radius
    const TangentFrame frame(light_->direction);
    sample.direction = (1 - height) * light_->direction + scale * (x * frame.across + y * frame.up);
    return sample;
}

PhotonStart PhotonLaunch::start(const std::array<double, 4>& x) const {
    PhotonStart out;
    glm::dvec3 area(0);
    if (!place(x[0], x[1], out, area)) return out;
    const Emission emission(*scene_, surface_index_, light_.sample(x[2], x[3]), from_below_);
    out.direction = emission.directionAt(out.position), out.source = emission.sample().source;
    const double facing = -glm::dot(out.direction, area);
    out.power = emission.irradianceAt(out.position) *
                (surface_->mesh ? std::fabs(facing) : std::max(0.0, from_below_ ? -facing : facing));
    return out;
}

bool PhotonLaunch::place(double u, double v, PhotonStart& out, glm::dvec3& area) const {
    if (surface_->sphere) {
        const double z = 1 - 2 * u, r = std::sqrt(std::max(0.0, 1 - z * z)), phi = 2 * std::numbers::pi * v;
        out.normal = out.face = {r * std::cos(phi), r * std::sin(phi), z};
        out.position = surface_->sphere->center + surface_->sphere->radius * out.normal;
        area = 4 * std::numbers::pi * surface_->sphere->radius * surface_->sphere->radius * out.normal;
        return true;
    }
    if (surface_->mesh) return placeOnMesh(u, v, out, area);
    if (domain_.empty()) return false;
    const SurfacePoint point = surface_->height_field->at(domain_.min + glm::dvec2(u, v) * (domain_.max - domain_.min));
    out.position = point.position;
    out.normal = out.face = glm::normalize(point.normal);
    area = domain_.area() * point.normal;
    return true;
}

bool PhotonLaunch::placeOnMesh(double u, double v, PhotonStart& out, glm::dvec3& area) const {
    if (!(total_share_ > 0)) return false;
    const auto found = std::upper_bound(cumulative_.begin(), cumulative_.end(), u);
    const auto k =
        static_cast<std::size_t>(std::min<std::ptrdiff_t>(found - cumulative_.begin(), std::ssize(cumulative_) - 1));
    const double low = k == 0 ? 0 : cumulative_[k - 1], width = cumulative_[k] - low;
    // What the choice of a piece left of u is as uniform as u was.
    const double s = std::sqrt(width > 0 ? std::clamp((u - low) / width, 0.0, 1.0) : 0.5);
    const Piece piece = pieces_.empty() ? Piece{static_cast<std::uint32_t>(k)} : pieces_[k];
    const glm::dvec2 w = (1 - s) * piece.corners[0] + s * (1 - v) * piece.corners[1] + s * v * piece.corners[2];
    const double wa = 1 - w.x - w.y, wb = w.x, wc = w.y;

    const TriangleMesh& mesh = *surface_->mesh;
    const auto& t = mesh.triangles[piece.triangle];
    const glm::dvec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    area = 0.5 * glm::cross(b - a, c - a);
    const double size = glm::length(area);
    if (size <= 0 || share_[k] <= 0) return false;
    out.position = wa * a + wb * b + wc * c;
    out.face = area / size;
    const glm::dvec3 normal = wa * mesh.normals[t[0]] + wb * mesh.normals[t[1]] + wc * mesh.normals[t[2]];
    const double length = glm::length(normal);
    // Vertex normals decide which side is above only through the face: a smooth normal never points to its back.
    const bool usable = surface_->smooth && length > 0 && glm::dot(normal, out.face) > 0;
    out.normal = usable ? normal / length : out.face;
    area *= piece.part * total_share_ / share_[k];
    return true;
}

}  // namespace photic
