// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/eikonal_index.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace photic {

double arrivalThroughIndex(const EikonalFront& front, const glm::dvec3& place, glm::dvec2 foot) {
    constexpr int kSteps = 12;
    const FrontOnSurface coming = front.front();
    const double here = front.slownessAt(place);
    glm::dvec3 gradient(0);  // of n, halfway to the first foot
    double arrival = 0;
    for (int step = 0; step < kSteps; ++step) {
        const HeightPoint s = front.table().at(foot);
        const glm::dvec3 y(foot, s.h), way = place - y, middle = 0.5 * (place + y);
        const double r = std::max(glm::length(way), 1e-12);
        const glm::dvec3 w = way / r;
        if (step == 0)
            for (int a = 0; a < 3; ++a) {
                glm::dvec3 aside(0);
                aside[a] = 0.25 * r;
                gradient[a] = (front.slownessAt(middle + aside) - front.slownessAt(middle - aside)) / (0.5 * r);
            }
        const double n = (front.slownessAt(y) + 4 * front.slownessAt(middle) + here) / 6;
        const glm::dvec3 across = gradient - glm::dot(gradient, w) * w;
        const double before =
            coming.outside > 0 ? coming.outside * glm::length(y - coming.source) : glm::dot(coming.gradient, y);
        arrival = before + n * r - r * r * r * glm::dot(across, across) / (24 * n);

        // Derivatives along the surface: what comes in, less what goes on, and half of grad n moves with the foot.
        const glm::dvec3 g = coming.gradientAt(y), u(1, 0, s.hx), v(0, 1, s.hy);
        const glm::dvec3 slope = g - n * w + 0.5 * r * gradient;
        const double g1 = glm::dot(slope, u), g2 = glm::dot(slope, v);
        const double bend = g.z - n * w.z, wu = glm::dot(w, u), wv = glm::dot(w, v), q = n / r;
        double h11 = bend * s.hxx + q * (1 + s.hx * s.hx - wu * wu), h12 = bend * s.hxy + q * (s.hx * s.hy - wu * wv),
               h22 = bend * s.hyy + q * (1 + s.hy * s.hy - wv * wv);
        const double det = h11 * h22 - h12 * h12;
        if (!(det > 0) || !(h11 > 0)) break;  // no minimum: the surface bends more sharply than the cells
        const glm::dvec2 move(-(h22 * g1 - h12 * g2) / det, -(h11 * g2 - h12 * g1) / det);
        const double length = glm::length(move);
        if (length < 1e-8 * r) break;
        foot += length > r ? move * (r / length) : move;
    }
    return arrival;
}

}  // namespace photic
