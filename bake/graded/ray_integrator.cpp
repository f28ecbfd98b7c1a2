// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/ray_integrator.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace photic {
namespace {

/// The derivatives of a ray's three members by s.
GradedRay slopeOf(const GradedIndex& index, const GradedRay& ray) {
    const IndexSample here = index.at(ray.position);
    return {ray.momentum, here.gradient, 2 * here.half_square};
}

GradedRay along(const GradedRay& ray, double step, const GradedRay& slope) {
    return {ray.position + step * slope.position, ray.momentum + step * slope.momentum,
            ray.optical_path + step * slope.optical_path};
}

/// Drift, kick, drift.
IndexSample leapfrog(const GradedIndex& index, double step, GradedRay& ray) {
    ray.position += 0.5 * step * ray.momentum;
    const IndexSample here = index.at(ray.position);
    ray.momentum += step * here.gradient;
    ray.optical_path += step * 2 * here.half_square;
    ray.position += 0.5 * step * ray.momentum;
    return here;
}

}  // namespace

GradedRay startRay(const GradedIndex& index, const glm::dvec3& position, const glm::dvec3& direction) {
    return {position, direction * index.indexAt(position), 0};
}

bool stepBetweenPlanes(const GradedIndex& index, int axis, double step, GradedRay& ray) {
    const double forward = ray.momentum[axis];
    if (!(forward * step > 0)) return false;
    const double first = 0.5 * step / forward;
    const glm::dvec3 middle = ray.position + first * ray.momentum;
    const IndexSample here = index.at(middle);
    // The second half is as long as the first would make it: what the kick itself changes is of second order.
    const double kicked = forward + 2 * first * here.gradient[axis];
    if (!(kicked * step > 0)) return false;
    const double whole = first + 0.5 * step / kicked;
    const glm::dvec3 momentum = ray.momentum + whole * here.gradient;
    if (!(momentum[axis] * step > 0)) return false;
    const double plane = ray.position[axis] + step;
    ray.momentum = momentum;
    ray.position = middle + (0.5 * step / momentum[axis]) * momentum;
    ray.position[axis] = plane;
    ray.optical_path += whole * 2 * here.half_square;
    return true;
}

void stepRungeKutta(const GradedIndex& index, double step, GradedRay& ray) {
    const GradedRay a = slopeOf(index, ray), b = slopeOf(index, along(ray, 0.5 * step, a)),
                    c = slopeOf(index, along(ray, 0.5 * step, b)), d = slopeOf(index, along(ray, step, c));
    for (const auto& [slope, weight] : {std::pair{&a, 1.0}, {&b, 2.0}, {&c, 2.0}, {&d, 1.0}})
        ray = along(ray, step * weight / 6, *slope);
}

IndexSample stepYoshida(const GradedIndex& index, double step, GradedRay& ray) {
    static const double root = std::cbrt(2.0), outer = 1 / (2 - root), inner = -root / (2 - root);
    leapfrog(index, outer * step, ray), leapfrog(index, inner * step, ray);
    return leapfrog(index, outer * step, ray);
}

void stepEqualTime(const GradedIndex& index, double time, GradedRay& ray) {
    const IndexSample here = index.at(ray.position);
    const double step = time / (2 * here.half_square);  // dT = n^2 ds
    ray.position += step * ray.momentum;
    ray.momentum += step * here.gradient;
    ray.optical_path += time;
}

int stepControlled(const GradedIndex& index, double length, double tolerance, GradedRay& ray) {
    constexpr double kLeastShare = 1e-9;  // of the whole: a kink is stepped over at this
    double done = 0, step = length;
    int steps = 0;
    while (done < length) {
        step = std::min(step, length - done);
        GradedRay whole = ray, halves = ray;
        stepRungeKutta(index, step, whole);
        stepRungeKutta(index, 0.5 * step, halves), stepRungeKutta(index, 0.5 * step, halves);
        const double error = glm::distance(whole.position, halves.position) / 15;
        if (error > tolerance && step > kLeastShare * length) {
            step *= std::clamp(0.9 * std::pow(tolerance / error, 0.2), 0.1, 0.5);
            continue;
        }
        ray = along(halves, 1.0 / 15,
                    {halves.position - whole.position, halves.momentum - whole.momentum,
                     halves.optical_path - whole.optical_path});
        done += step, ++steps;
        step *= std::min(4.0, 0.9 * std::pow(tolerance / std::max(error, 1e-300), 0.2));
    }
    return steps;
}

}  // namespace photic
