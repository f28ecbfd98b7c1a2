// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/emission.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "bake/optics/tangent_frame.h"
#include "bake/paths/ray_casting.h"
#include "bake/scene/scattered_points.h"

namespace photic {
namespace {

// Of a lamp's strength on its axis: where the middle differs by more from the mean of the ends, it is not even.
constexpr double kEven = 0.01;

// Edges along which a cone's strength is asked for, over the radius of what it lights: its power is off by less than
// one per cent then, with the hardest rim.
constexpr double kNarrow = 0.25;

// Light along an axis comes to corners that lie on a sphere's very rim. Rounding must not choose there whether it comes
// from within: it would go on inside of the ball, and bring many times the light.
glm::dvec3 facingTheLight(const glm::dvec3& direction, const glm::dvec3& normal, const Sphere& sphere) {
    const double past = glm::dot(direction, normal);
    const bool on_rim = std::fabs(past) * sphere.radius < roundingOnSphere(sphere);
    return on_rim ? glm::normalize(normal - (past + 1e-12) * direction) : normal;
}

// A spiral over the unit disc, moved and stretched to have the disc's own mean and moments of second order: light that
// is a quadratic of the direction is summed exactly, and a low sun sends what its middle sends.
std::vector<glm::dvec2> discPoints(int count, double moment) {
    const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
    std::vector<glm::dvec2> points;
    glm::dvec2 mean(0);
    for (int i = 0; i < count; ++i) {
        const double r = std::sqrt((i + 0.5) / count), angle = i * golden_angle;
        points.push_back(r * glm::dvec2(std::cos(angle), std::sin(angle)));
        mean += points.back() / static_cast<double>(count);
    }
    double xx = 0, xy = 0, yy = 0;
    for (glm::dvec2& p : points) {
        p -= mean;
        xx += p.x * p.x / count, xy += p.x * p.y / count, yy += p.y * p.y / count;
    }
    if (count < 3) return points;  // on a line
    for (glm::dvec2& p : points) {
        // By Cholesky's factors of the moments.
        const double x = p.x / std::sqrt(xx), y = (p.y - xy / xx * p.x) / std::sqrt(yy - xy * xy / xx);
        p = std::sqrt(moment) * glm::dvec2(x, y);
    }
    std::sort(points.begin(), points.end(),
              [](const glm::dvec2& a, const glm::dvec2& b) { return glm::dot(a, a) < glm::dot(b, b); });
    return points;
}

std::vector<LightSample> discSamples(const Light& light, int count) {
    const double radius = 0.5 * light.angular_diameter_deg * std::numbers::pi / 180;
    if (radius <= 0 || count <= 1) return {{light.direction, std::nullopt, light.irradiance, &light}};
    const TangentFrame frame(light.direction);
    const double sine = std::sin(radius), cosine = std::cos(radius);
    // The mean of x^2 over the solid angle, in units of the rim's.
    const double moment = (1 - (1 + cosine + cosine * cosine) / 3) / (2 * sine * sine);
    std::vector<LightSample> samples;
    for (const glm::dvec2& point : discPoints(count, moment)) {
        const glm::dvec2 p = sine * point;
        const double along = std::sqrt(std::max(0.0, 1 - glm::dot(p, p)));
        samples.push_back({along * light.direction + p.x * frame.across + p.y * frame.up, std::nullopt,
                           light.irradiance / static_cast<double>(count), &light});
    }
    return samples;
}

// Evenly scattered over a square about 0, each point with its opposite, so that their mean is the middle.
std::vector<glm::dvec2> squarePoints(int count) {
    std::vector<glm::dvec2> points;
    glm::dvec2 moment(0), farthest(0);
    for (int i = 0; i < count; ++i) {
        const glm::dvec2 p = scatteredPoint(i - 0.5 * (count - 1)) - 0.5;
        moment += p * p / static_cast<double>(count), farthest = glm::max(farthest, glm::abs(p));
        points.push_back(p);
    }
    // Stretched to the square's own moments, but never out of it.
    if (count > 1)
        for (glm::dvec2& p : points) p *= glm::min(glm::sqrt(1.0 / 12 / moment), 0.5 / farthest);
    return points;
}

}  // namespace

std::vector<LightSample> lightSamples(const Light& light, int disc_samples) {
    if (light.type == LightType::Sun) return discSamples(light, disc_samples);
    if (light.type != LightType::Rectangle)
        return {{light.direction, light.position, light.power / (4 * std::numbers::pi), &light}};
    std::vector<LightSample> samples;
    const glm::dvec3 across = light.tangent, up = glm::cross(light.direction, light.tangent);
    for (const glm::dvec2& point : squarePoints(std::max(light.samples, 1))) {
        const glm::dvec2 place = point * light.size;
        samples.push_back({light.direction, *light.position + place.x * across + place.y * up,
                           light.power / (std::numbers::pi * std::max(light.samples, 1)), &light});
    }
    return samples;
}

glm::dvec3 Emission::directionAt(const glm::dvec3& point) const {
    return sample_.source ? glm::normalize(point - *sample_.source) : sample_.direction;
}

glm::dvec3 Emission::strengthTowards(const glm::dvec3& direction) const {
    const double cosine = glm::dot(direction, sample_.direction);
    if (sample_.light->type == LightType::Rectangle) return sample_.strength * std::max(0.0, cosine);
    return sample_.strength * sample_.light->spotFalloff(cosine);
}

EmittedRay Emission::at(const EmissionParam& param, const glm::dvec3& face) const {
    if (surface_.height_field) {
        const SurfacePoint point = surface_.height_field->at({param.position.x, param.position.y});
        const glm::dvec3 normal = glm::normalize(point.normal);
        return {point.position, directionAt(point.position), normal, normal};
    }
    if (surface_.sphere) {
        const glm::dvec3 normal = glm::normalize(param.position - surface_.sphere->center);
        const glm::dvec3 position = surface_.sphere->center + surface_.sphere->radius * normal;
        const glm::dvec3 direction = directionAt(position),
                         towards = facingTheLight(direction, normal, *surface_.sphere);
        return {position, direction, towards, towards};
    }
    const double length = glm::length(param.normal);
    const bool usable = surface_.smooth && length > 0 && glm::dot(param.normal, face) > 0;
    return {param.position, directionAt(param.position), usable ? param.normal / length : face, face};
}

glm::dvec3 Emission::power(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) const {
    if (!sample_.source) return sample_.strength * across(0.5 * glm::cross(b - a, c - a));
    const glm::dvec3 u = a - *sample_.source, v = b - *sample_.source, w = c - *sample_.source;
    const double lu = glm::length(u), lv = glm::length(v), lw = glm::length(w);
    if (!(lu > 0 && lv > 0 && lw > 0)) return glm::dvec3(0);
    const double volume = -glm::dot(u, glm::cross(v, w));
    double angle = 2 * std::atan2(std::fabs(volume),
                                  lu * lv * lw + glm::dot(u, v) * lw + glm::dot(u, w) * lv + glm::dot(v, w) * lu);
    if (!surface_.mesh && !surface_.sphere && (volume < 0) != from_below_) angle = 0;
    return angle * meanStrength({u, v, w});
}

// Over the triangle between three points seen from the lamp: corners alone would miss what the rim of a spot's cone
// does between them. Exact where strength is cubic across the triangle [Strang and Fix 1973, the seven-point rule].
glm::dvec3 Emission::meanStrength(const std::array<glm::dvec3, 3>& to) const {
    if (sample_.light->type == LightType::Point) return sample_.strength;
    glm::dvec3 corners(0), middles(0);
    for (std::size_t i = 0; i < 3; ++i) {
        corners += strengthTowards(glm::normalize(to[i]));
        middles += strengthTowards(glm::normalize(to[i] + to[(i + 1) % 3]));
    }
    return corners / 20.0 + middles * (2.0 / 15) + strengthTowards(glm::normalize(to[0] + to[1] + to[2])) * (9.0 / 20);
}

Emission::Between Emission::between(const glm::dvec3& a, const glm::dvec3& b) const {
    if (!sample_.source) return Between::Even;
    const glm::dvec3 middle = 0.5 * (a + b), to = middle - *sample_.source;
    const double distance = glm::length(to), reach = glm::length(b - a);
    // Seen from a lamp that is nearer than its corners to one another an edge spans most ways that light can take:
    // those that come through the water may all lie between two that are totally reflected.
    if (!(distance > 8 * reach)) return Between::Narrow;
    if (sample_.light->type == LightType::Point) return Between::Even;
    const bool spot = sample_.light->type == LightType::Spot;
    const auto strength = [&](const glm::dvec3& point) {
        const double cosine = glm::dot(glm::normalize(point - *sample_.source), sample_.direction);
        return sample_.light->type == LightType::Rectangle ? std::max(0.0, cosine) : sample_.light->spotFalloff(cosine);
    };
    if (spot) {
        // The angle between the axis and the middle, less what the reach may turn it by.
        const double half_cone = 0.5 * sample_.light->cone_angle_deg * std::numbers::pi / 180;
        const double off = std::acos(std::clamp(glm::dot(to, sample_.direction) / distance, -1.0, 1.0));
        if (off - std::asin(reach / distance) > half_cone) return Between::Dark;
        // A cone that the corners may stand around, or its rim.
        const double radius = distance * std::tan(std::min(half_cone, 1.0));
        if (reach > kNarrow * radius) return Between::Narrow;
    }
    const double at_a = strength(a), at_b = strength(b);
    return std::fabs(strength(middle) - 0.5 * (at_a + at_b)) > kEven ? Between::Uneven : Between::Even;
}

glm::dvec3 Emission::irradianceAt(const glm::dvec3& point) const {
    if (!sample_.source) return sample_.strength;
    const glm::dvec3 to = point - *sample_.source;
    const double distance2 = glm::dot(to, to);
    return distance2 > 0 ? strengthTowards(to / std::sqrt(distance2)) / distance2 : glm::dvec3(0);
}

}  // namespace photic
