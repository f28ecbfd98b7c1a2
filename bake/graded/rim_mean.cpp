// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/rim_mean.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace photic {
namespace {

constexpr double kExact = 1e-4;  // nodes: where the rim is found
constexpr double kPace = 0.5;    // nodes between places that are asked: no thinner wall is seen

/// Distance from `from` along `way` to where the rim is crossed, between `low` and `high`, which lie on its two sides.
double crossing(const RimMean& body, const glm::dvec3& from, const glm::dvec3& way, double low, double high,
                double exact) {
    const bool first = body.inside(from + low * way);
    while (high - low > exact) {
        const double middle = 0.5 * (low + high);
        (body.inside(from + middle * way) == first ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

/// Where the rim is, seen from a place on it: its height over the plane across `up`, some way aside.
std::optional<double> heightAside(const RimMean& body, const glm::dvec3& rim, const glm::dvec3& up,
                                  const glm::dvec3& aside, double most, double exact) {
    const glm::dvec3 from = rim + aside;
    if (body.inside(from - most * up) || !body.inside(from + most * up)) return {};
    return crossing(body, from, up, -most, most, exact);
}

/// Two directions across a third.
std::array<glm::dvec3, 2> across(const glm::dvec3& up) {
    const glm::dvec3 other = std::fabs(up.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 first = glm::normalize(glm::cross(up, other));
    return {first, glm::cross(up, first)};
}

/// Where the line from a place towards the rim meets it; nothing where it does not.
std::optional<glm::dvec3> rimFrom(const RimMean& body, const glm::dvec3& place, const glm::dvec3& up) {
    const bool here = body.inside(place);
    const glm::dvec3 way = here ? -up : up;
    for (double t = 0; t < body.half_width + 2; t += kPace)
        if (body.inside(place + (t + kPace) * way) != here)
            return place + crossing(body, place, way, t, t + kPace, kExact) * way;
    return {};
}

/// Unit normal of the rim nearest to a place, to its inside.
std::optional<glm::dvec3> normalNear(const RimMean& body, const glm::dvec3& place, glm::dvec3 up) {
    constexpr double kAside = 0.5, kFar = 2, kRound = 0.25;  // nodes
    constexpr double kTurn = 1e-4;                           // of the normal, squared: what distances do not see
    for (int turn = 0; turn < 6; ++turn) {
        const auto rim = rimFrom(body, place, up);
        if (!rim) return {};
        const auto sides = across(up);
        glm::dvec3 normal = up;
        std::array<double, 2> bulge{};
        for (int a = 0; a < 2; ++a) {
            const auto ahead = heightAside(body, *rim, up, kAside * sides[a], kAside, kExact),
                       behind = heightAside(body, *rim, up, -kAside * sides[a], kAside, kExact);
            if (!ahead || !behind) return {};
            normal -= (*ahead - *behind) / (2 * kAside) * sides[a];
            bulge[a] = *ahead + *behind;
        }
        normal = glm::normalize(normal);
        const glm::dvec3 change = normal - up;
        up = normal;
        if (glm::dot(change, change) > kTurn) continue;
        // An edge, or a bend that is sharper than what is near: further aside the rim is not where its curve would be.
        for (int a = 0; a < 2; ++a) {
            const auto ahead = heightAside(body, *rim, up, kFar * sides[a], 0.75 * kFar, 0.01),
                       behind = heightAside(body, *rim, up, -kFar * sides[a], 0.75 * kFar, 0.01);
            if (!ahead || !behind) return {};
            const double expected = bulge[a] * (kFar * kFar) / (kAside * kAside);
            if (std::fabs(*ahead + *behind - expected) > kRound || std::fabs(*ahead - *behind) > kRound) return {};
        }
        return up;
    }
    return {};
}

}  // namespace

std::optional<double> RimMean::at(const glm::dvec3& place, const glm::dvec3& towards) const {
    const auto normal = normalNear(*this, place, glm::normalize(towards));
    if (!normal) return {};
    // From side to side of the weight, in pieces on which the value is smooth: Gauss' rule of three places on each.
    constexpr std::array<double, 3> kPlaces{-0.7745966692414834, 0, 0.7745966692414834};
    constexpr std::array<double, 3> kWeights{5.0 / 18, 8.0 / 18, 5.0 / 18};
    const auto piece = [&](double low, double high) {
        double sum = 0;
        for (std::size_t i = 0; i < kPlaces.size(); ++i) {
            const double t = 0.5 * (low + high) + 0.5 * (high - low) * kPlaces[i];
            const double weight = (1 + std::cos(std::numbers::pi * t / half_width)) / (2 * half_width);
            sum += kWeights[i] * (high - low) * weight * value(place + t * *normal);
        }
        return sum;
    };
    const int pieces = static_cast<int>(std::ceil(2 * half_width / kPace));
    const double length = 2 * half_width / pieces;
    double sum = 0;
    bool before = inside(place - half_width * *normal);
    for (int i = 0; i < pieces; ++i) {
        const double low = -half_width + i * length, high = low + length;
        const bool after = inside(place + high * *normal);
        if (before == after) {
            if (before) sum += piece(low, high);
        } else {
            const double rim = crossing(*this, place, *normal, low, high, kExact);
            sum += before ? piece(low, rim) : piece(rim, high);
        }
        before = after;
    }
    return sum;
}

}  // namespace photic
