// SPDX-License-Identifier: Apache-2.0
// Light scattered once by a homogeneous medium towards the eye. Behind photic_volume.glsl.

#ifndef PHOTIC_MEDIUM
#define PHOTIC_MEDIUM
struct PhoticMedium {
    vec3 scattering;   ///< [1/m]
    vec3 absorption;   ///< [1/m]
    float anisotropy;  ///< g of Henyey-Greenstein, -1 to 1, both excluded
};
struct PhoticRay {
    vec3 origin;     ///< [m], in the medium: attenuation counts from here
    vec3 direction;  ///< unit, away from the eye
};
#endif

#ifndef PHOTIC_STEPS
#define PHOTIC_STEPS 32
#endif

#include "photic_phase.glsl"

/// (1 - exp(-x)) / x, also near 0.
vec3 photicMeanTransmittance(vec3 x) {
    vec3 series = 1.0 - x * (0.5 - x * (1.0 / 6.0));
    vec3 exact = (1.0 - exp(-x)) / max(x, vec3(1e-6));
    return mix(exact, series, lessThan(x, vec3(0.02)));
}

/// Radiance that the light in the volume sends to the ray's origin by scattering once, [W/(m2 sr)]: the integral of
/// transmittance * scattering * irradiance * phase. `steps` segments of equal length between the ends of the lit part of
/// the ray; in each, light is that of one point and transmittance is integrated exactly.
/// @param tmax    where the ray ends [m]
/// @param jitter  place of the point in its segment, 0 to 1; 1/2 without noise
/// @param skip    pass over dark steps unsampled: the same bits, sooner
vec3 photicInscatter(PhoticRay ray, float tmax, PhoticMedium medium, int steps, float jitter, bool skip) {
    vec3 origin = photicLocal(ray.origin), direction = photicLocalDirection(ray.direction);
    // Where the ray is in the lit box.
    vec3 inverse = 1.0 / mix(direction, vec3(1e-12), lessThan(abs(direction), vec3(1e-12)));
    vec3 a = (photic_lit_min.xyz - origin) * inverse, b = (photic_lit_max.xyz - origin) * inverse;
    vec3 near = min(a, b), far = max(a, b);
    float begin = max(0.0, max(near.x, max(near.y, near.z)));
    float end = min(tmax, min(far.x, min(far.y, far.z)));
    // Light from beyond an optical depth of 12 is below 1e-5 of what starts there.
    vec3 extinction = medium.scattering + medium.absorption;
    float thinnest = min(extinction.x, min(extinction.y, extinction.z));
    if (thinnest > 0.0) end = min(end, 12.0 / thinnest);
    if (!(end > begin)) return vec3(0.0);

    float dt = (end - begin) / float(steps);
    vec3 segment = dt * photicMeanTransmittance(extinction * dt) * medium.scattering;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < steps;) {
        // From i alone, not summed up: so that skipping changes no bit.
        float t = begin + (float(i) + jitter) * dt;
        vec3 local = origin + t * direction;
        if (skip) {
            int dark = int(photicEmptyLocal(local, direction * dt));
            if (dark > 0) {
                i += dark;
                continue;
            }
        }
        PhoticLight light = photicSampleLocal(local);
        if (light.mean > 0.0) {
            float size = length(light.flux);
            // The phase function is widened by how far the light is from one direction.
            float cosine = size > 0.0 ? -dot(light.flux, ray.direction) / size : 0.0;
            float g = medium.anisotropy * min(1.0, size / light.mean);
            vec3 reaches = exp(-extinction * (begin + float(i) * dt));
#ifdef PHOTIC_MOVERS
            reaches *= photicPassesMovers(ray.origin + t * ray.direction, light.flux, light.mean);
#endif
            sum += reaches * light.irradiance * photicPhase(cosine, g);
        }
        ++i;
    }
    return sum * segment;
}

vec3 photicInscatter(PhoticRay ray, float tmax, PhoticMedium medium) {
    return photicInscatter(ray, tmax, medium, PHOTIC_STEPS, 0.5, true);
}
