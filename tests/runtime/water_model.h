// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "photic/runtime_water.h"
#include "runtime/src/gl_functions.h"
#include "runtime/src/uniforms.h"

/// The look-ups of runtime/shaders/photic_water_lookup.glsl again, in double and from the papers' formulae, and what
/// runs the GLSL on a grid of points.
namespace photic::test {

/// Snell's law; 0 at total reflection. All unit; dot(direction, normal) < 0.
glm::dvec3 refracted(const glm::dvec3& direction, const glm::dvec3& normal, double ior_from, double ior_to);
glm::dvec3 reflectedAt(const glm::dvec3& direction, const glm::dvec3& normal);

/// omega = exp(-tau a^2) below the surface, a measured across the sun's direction along one axis or both.
/// @param slopes  of the water where the look-up reads it
double lookupOmega(const glm::dvec2& slopes, const glm::dvec3& sun, double ior, double tau, int axes, double reflected);
/// The same above the surface, of the reflected sun.
double lookupReflected(const glm::dvec2& slopes, const glm::dvec3& sun, double tau, int axes);

/// Heights of the water of tests/support/pool3.h over [-2, 2]^2, `side` samples a side.
struct SampledWater {
    std::vector<float> heights;
    runtime::WaterHeights water;
};
SampledWater sampleWater(int side, const std::function<double(double x, double y)>& height, double half = 2,
                         runtime::WaterOutside outside = runtime::WaterOutside::Flat);
SampledWater pool3Water(int side);
/// The sun of pool3, of 1 W/m2 across its beam.
runtime::WaterLight pool3Light();

/// Evaluates GLSL for each pixel of a `width` x `height` target.
/// @param include     file of runtime/shaders
/// @param expression  of type vec4, with `pixel` (vec2, centres at 0.5) at hand
/// @param bind        sets uniforms
/// @return four floats a pixel, row 0 first
std::vector<float> evaluate(const runtime::GlFunctions& gl, const std::string& include, const std::string& expression,
                            int width, int height, const std::function<void(const runtime::Uniforms&)>& bind);

/// GLSL: the point of a level floor at z under `pixel`, for `size` pixels over [-1, 1]^2.
std::string floorPoint(double z, int size);

struct Likeness {
    double correlation = 0, energy = 0, relative_l1 = 0;
};
/// Of a to the reference: Pearson's correlation, ratio of sums, mean |a - r| / mean r.
Likeness likeness(const std::vector<double>& a, const std::vector<double>& reference);
/// One channel of what evaluate() returns.
std::vector<double> channel(const std::vector<float>& pixels, int index);

}  // namespace photic::test
