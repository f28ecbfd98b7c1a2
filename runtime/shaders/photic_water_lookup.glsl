// SPDX-License-Identifier: Apache-2.0
// Caustics and god rays from a look at the water's slopes: K. Guerin, M. Izumi, "Real-time caustics rendering in large
// marine environments" (after J. Guardado, D. Sanchez-Crespo, GPU Gems 1, chapter 2). A ray from the lit point to the
// surface is refracted there; the better it is aligned with the sun, the brighter the point.
// Made beyond the paper, each switchable: both axes of misalignment instead of one, the ray along the refracted sun
// instead of straight up, and a mean brightness that is kept whatever the tightening.
// Where PHOTIC_MOVERS is defined god rays have shadows: photic_movers.glsl before this.
#include "photic_water.glsl"

uniform int photic_lookup_axes;        // of misalignment, 1 | 2
uniform int photic_lookup_projection;  // 0: along the light; 1: tri-planar
uniform int photic_lookup_gain;        // 0: keeps the mean; 1: fixed
uniform vec4 photic_lookup_tightening; // x: tau at the surface; y: its growth per metre of depth [1/m];
                                       // z: weight of the reflected ray below the surface, 0..1; w: the fixed gain
uniform vec4 photic_lookup_covariance; // trace and determinant below the surface (x, y) and above it (z, w)
uniform vec4 photic_god_rays;          // x: distance between planes [m]; y: depth over which samples fade in [m];
                                       // z: most samples; w: strength

// [eq. 1] of the paper, and a faster fall where the ray does not leave the water at all.
float photicTighten(float misalignment_squared, float tau) { return exp(-tau * misalignment_squared); }

// a^2 of [eq. 1]: how far `ray` is from `reference`, as dot products with one or two axes across it. 0: aligned.
float photicMisalignment(vec3 ray, vec3 reference) {
    // The first axis lies as near to +x as it can, as in the paper.
    vec3 u = normalize(vec3(1.0, 0.0, 0.0) - reference * reference.x);
    float a = dot(ray, u);
    float squared = a * a;
    if (photic_lookup_axes == 2) {
        float b = dot(ray, cross(reference, u));
        squared += b * b;
    }
    return squared;
}

// omega for slopes read at the surface, `depth` metres above the lit point.
float photicLookupOmega(vec2 slopes, float tau) {
    vec3 n = photicWaterNormal(slopes);
    vec3 up = -photicStillWaterDirection();
    vec3 refracted = refract(up, -n, photic_water_level.y);
    float refraction = refracted == vec3(0.0) ? 0.0 : photicTighten(photicMisalignment(refracted, -photic_sun_direction), tau);
    float weight = photic_lookup_tightening.z;
    if (weight <= 0.0) return refraction;
    vec3 mirrored = reflect(up, vec3(0.0, 0.0, 1.0));
    float reflection = photicTighten(photicMisalignment(reflect(up, -n), mirrored), tau);
    return mix(refraction, reflection, weight);
}

// omega above the water: the sun's light that the surface sends up again.
float photicLookupReflected(vec2 slopes, float tau) {
    vec3 n = photicWaterNormal(slopes);
    vec3 down = -reflect(photic_sun_direction, vec3(0.0, 0.0, 1.0));
    return photicTighten(photicMisalignment(reflect(down, n), -photic_sun_direction), tau);
}

// What omega is multiplied by. Its mean over slopes with a Gaussian spread, small enough for a to grow with them linearly,
// is 1 / sqrt(det(1 + 2 tau C)), C the covariance of the components of a.
// covariance: trace and determinant of C.
float photicLookupGain(float tau, vec2 covariance) {
    return photic_lookup_gain == 1 ? photic_lookup_tightening.w
                                   : sqrt(1.0 + 2.0 * tau * covariance.x + 4.0 * tau * tau * covariance.y);
}

// Slopes along the light, or by tri-planar projection: the mean over three readings, with (x, y), (x, z) and (y, z) of the
// position as texture coordinates, weighted by the normal.
float photicLookupBelow(vec3 position, vec3 normal, float tau) {
    if (photic_lookup_projection == 1) {
        vec3 weight = abs(normal);
        weight /= weight.x + weight.y + weight.z;
        vec3 omega = vec3(photicLookupOmega(photicWaterAt(position.yz).yz, tau),
                          photicLookupOmega(photicWaterAt(position.xz).yz, tau),
                          photicLookupOmega(photicWaterAt(position.xy).yz, tau));
        return dot(weight, omega);
    }
    vec3 light = photicStillWaterDirection();
    vec2 above = position.xy - light.xy * ((position.z - photic_water_level.x) / light.z);
    return photicLookupOmega(photicWaterAt(above).yz, tau);
}

// What a receiver gets without a bake [W/m2, per channel]. position: world; normal: unit, world.
vec3 photicLookupIrradiance(vec3 position, vec3 normal) {
    float depth = photic_water_level.x - position.z;
    float tau = photic_lookup_tightening.x * (1.0 + photic_lookup_tightening.y * abs(depth));
    float transmittance = photicTransmittance(-photic_sun_direction.z);
    if (depth >= 0.0) {
        vec3 light = photicStillWaterDirection();
        float omega = photicLookupBelow(position, normal, tau) * photicLookupGain(tau, photic_lookup_covariance.xy);
        vec3 medium = exp(-photic_water_extinction * (depth / -light.z));
        // Still water spreads the beam from cos(sun) to cos(refracted) of its width.
        float fluence = transmittance * photic_sun_direction.z / light.z * omega;
        return photic_sun_irradiance * medium * (fluence * max(0.0, -dot(normal, light)));
    }
    vec3 light = reflect(photic_sun_direction, vec3(0.0, 0.0, 1.0));
    vec2 below = position.xy + light.xy * (depth / light.z);
    float omega = photicLookupReflected(photicWaterAt(below).yz, tau) * photicLookupGain(tau, photic_lookup_covariance.zw);
    return photic_sun_irradiance * ((1.0 - transmittance) * omega * max(0.0, -dot(normal, light)));
}

// gamma of [eq. 2] [1/m]: the sum of rho_i omega_i over the crossings of an eye ray with planes fixed in the world, whose
// grid leans with the light, over the distance gone. eye: world; direction: unit; limit [m]: what the ray hits.
float photicGodRays(vec3 eye, vec3 direction, float limit) {
    vec3 light = photicStillWaterDirection();
    // Only the wet stretch of the ray.
    float level = photic_water_level.x, start = 0.0, end = limit;
    float crossing = (level - eye.z) / (abs(direction.z) > 1e-6 ? direction.z : 1e-6);
    if (eye.z > level) {
        if (direction.z >= 0.0) return 0.0;
        start = crossing;
    } else if (direction.z > 0.0) {
        end = min(end, crossing);
    }
    if (end <= start) return 0.0;
    // In the grid's frame, sheared along the light, a plane is x = k spacing or y = k spacing.
    vec2 lean = light.xy / light.z;
    vec3 first = eye + start * direction;
    vec2 from = first.xy - lean * (first.z - level);
    vec2 along = direction.xy - lean * direction.z;
    along = mix(vec2(1e-6), along, greaterThan(abs(along), vec2(1e-6)));
    float spacing = photic_god_rays.x;
    vec2 step_length = spacing / abs(along);
    vec2 next = ((floor(from / spacing) + vec2(greaterThan(along, vec2(0.0)))) * spacing - from) / along;
    float extinction = dot(photic_water_extinction, vec3(1.0 / 3.0));
    float sum = 0.0, gone = 0.0;
    int samples = int(photic_god_rays.z);
    for (int i = 0; i < samples; ++i) {
        float t = min(next.x, next.y);
        if (start + t >= end) break;
        if (next.x < next.y) next.x += step_length.x;
        else next.y += step_length.y;
        vec3 position = first + t * direction;
        float depth = level - position.z;
        float tau = photic_lookup_tightening.x * (1.0 + photic_lookup_tightening.y * depth);
        vec2 above = position.xy - lean * (position.z - level);
        float omega = photicLookupOmega(photicWaterAt(above).yz, tau);
        // rho_i: samples near the surface would show the grid; light and sight fade in the medium.
        float rho = smoothstep(0.0, photic_god_rays.y, depth) * exp(-extinction * (t + depth / -light.z));
#ifdef PHOTIC_MOVERS
        rho *= photicPassesMovers(position, light, 1.0);
#endif
        sum += rho * omega;
        gone = t;
    }
    return gone > 0.0 ? sum / gone : 0.0;
}
