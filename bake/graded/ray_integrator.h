// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>

#include "bake/scene/graded_index.h"

namespace photic {

/// A ray in a graded index. With s, the parameter that grows by length / n: dx/ds = p, dp/ds = grad(n^2 / 2),
/// dT/ds = n^2.
struct GradedRay {
    glm::dvec3 position{0};   ///< world [m]
    glm::dvec3 momentum{0};   ///< p: along the ray, as long as n
    double optical_path = 0;  ///< T: integral of n over length [m]
};

/// A ray that starts at a place along a unit direction.
GradedRay startRay(const GradedIndex& index, const glm::dvec3& position, const glm::dvec3& direction);

/// Between two planes across `axis` that lie `step` [m] apart, of either sign: drift, kick in the middle, drift, with
/// the axis itself as parameter. Second order, and one look at the index. The wavefront's own step.
/// @return false, and leaves the ray, where it turns around within the step
bool stepBetweenPlanes(const GradedIndex& index, int axis, double step, GradedRay& ray);

/// The classical fourth-order Runge-Kutta step of `step` in s [m].
void stepRungeKutta(const GradedIndex& index, double step, GradedRay& ray);

/// Three leapfrogs whose errors of second order cancel [Yoshida 1990]: fourth order, and symplectic: |p| - n does not
/// drift however far the ray goes.
/// @return the index at its last look, a little before the end of the step
IndexSample stepYoshida(const GradedIndex& index, double step, GradedRay& ray);

/// Euler's step over `time` [m of optical path], as [Ihrke et al. 2007, eqs. 14 and 15]: first order.
void stepEqualTime(const GradedIndex& index, double time, GradedRay& ray);

/// Runge-Kutta steps as long as their error allows, over `length` in s [m]: each is compared with two of half the
/// length, and takes the difference as its correction.
/// @param tolerance  of one step [m]
/// @return steps taken
int stepControlled(const GradedIndex& index, double length, double tolerance, GradedRay& ray);

}  // namespace photic
