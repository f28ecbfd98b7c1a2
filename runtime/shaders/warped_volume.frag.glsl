// SPDX-License-Identifier: Apache-2.0
// A pixel's share of one warped caustic volume (Ernst et al. 2005), added to the other volumes': light on the receiver
// (sections 3.3, 3.4) and in-scatter along the line of sight (section 3.5).
#include "photic_water.glsl"
#include "g_buffer.glsl"
#include "photic_warped_volume.glsl"
#include "photic_phase.glsl"
#ifdef PHOTIC_MOVERS
#include "photic_movers.glsl"
#endif

uniform vec4 photic_target;      // x, y: lower left pixel; width, height; stands for the whole G-buffer
uniform int photic_has_albedo;   // 0: albedo 1
uniform vec4 photic_scattering;  // xyz: [1/m]; w: anisotropy g of Henyey and Greenstein

flat in vec3 photic_frame_origin, photic_frame_x, photic_frame_normal;
flat in vec3 photic_vx, photic_vz, photic_rx, photic_rz;
flat in float photic_power;

layout(location = 0) out vec4 photic_radiance;  // [W/m2/sr]

vec3 photicToWorld(vec3 v) {
    return photic_frame_x * v.x + photic_frame_normal * v.y + cross(photic_frame_normal, photic_frame_x) * v.z;
}

// Fluence rate and direction at a point, over the sun's irradiance; w = 0 outside the volume. along: [m] gone in the water.
vec4 photicVolumeLight(vec3 position, out float along) {
    vec3 from = position - photic_frame_origin;
    vec3 z = cross(photic_frame_normal, photic_frame_x);
    float depth = dot(from, photic_frame_normal);  // alpha
    vec3 cx = photic_vx + depth * photic_rx, cz = photic_vz + depth * photic_rz;
    vec3 areas = photicVolumeAreas(vec2(dot(from, photic_frame_x), dot(from, z)), cx, cz);
    float total = areas.x + areas.y + areas.z;
    along = 0.0;
    if (depth < 0.0 || total == 0.0 || !photicInsideVolume(areas)) return vec4(0.0);
    vec3 share = areas / total;
    vec3 ray = vec3(dot(share, photic_rx), 1.0, dot(share, photic_rz));
    along = depth * length(ray);
    // Power over the caustic triangle's area is irradiance on the plane of the triangle, where the ray has cosine 1 / |ray|.
    return vec4(normalize(photicToWorld(ray)), photic_power / (0.5 * abs(total)) * length(ray));
}

#ifdef PHOTIC_MOVERS
// What passes all movers of a beam's light on a stretch of the line of sight: a place for each width of the beam.
float photicSpanPasses(vec3 origin, vec3 sight, vec2 span, vec3 travel, float width) {
    int places = int(clamp(ceil((span.y - span.x) / width), 1.0, 8.0));
    float passes = 0.0;
    for (int i = 0; i < places; ++i) {
        float t = mix(span.x, span.y, (float(i) + 0.5) / float(places));
        passes += photicPassesMovers(origin + t * sight, travel, 1.0);
    }
    return passes / float(places);
}
#endif

// Single scattering where the line of sight passes through the volume [eq. of section 3.5]: the three rays are cut by a
// plane that holds the line of sight, and their triangle by the line. The paper takes the plane of the scan line; this one
// is as much across the light as it can be, so that the cut is never a long sliver.
vec3 photicVolumeScatter(vec3 origin, vec3 sight, float start, float limit) {
    vec3 corner[3], ray[3];
    vec3 mean = vec3(0.0);
    for (int i = 0; i < 3; ++i) {
        corner[i] = photic_frame_origin + photicToWorld(vec3(photic_vx[i], 0.0, photic_vz[i]));
        ray[i] = photicToWorld(vec3(photic_rx[i], 1.0, photic_rz[i]));
        mean += ray[i];
    }
    mean = normalize(mean);
    vec3 across = mean - sight * dot(sight, mean);
    float sine = length(across);
    if (sine < 1e-3) return vec3(0.0);
    across /= sine;
    vec3 aside = cross(sight, across), x, y;
    float gone = 0.0;
    for (int i = 0; i < 3; ++i) {
        float t = max(0.0, dot(origin - corner[i], across) / dot(ray[i], across));
        vec3 cut = corner[i] + t * ray[i] - origin;
        x[i] = dot(cut, sight), y[i] = dot(cut, aside);
        gone += t * length(ray[i]) / 3.0;
    }
    vec2 span = photicRayInTriangle(x, y);
    span = vec2(max(span.x, start), min(span.y, limit));
    float area = 0.5 * abs((x.y - x.x) * (y.z - y.x) - (x.z - x.x) * (y.y - y.x));
    if (span.y <= span.x || area <= 0.0) return vec3(0.0);
    float fluence = photic_power / (area * sine);
    float seen = 0.5 * (span.x + span.y) - start;
#ifdef PHOTIC_MOVERS
    fluence *= photicSpanPasses(origin, sight, span, mean, sqrt(area));
#endif
    return photic_sun_irradiance * photic_scattering.xyz * exp(-photic_water_extinction * (seen + gone)) *
           (fluence * (span.y - span.x) * photicPhase(dot(mean, -sight), photic_scattering.w));
}

void main() {
    vec2 size = vec2(textureSize(photic_depth, 0));
    ivec2 texel = ivec2((gl_FragCoord.xy - photic_target.xy) / photic_target.zw * size);
    float depth = texelFetch(photic_depth, texel, 0).r;
    vec3 position = photicWorld((vec2(texel) + 0.5) / size, depth);
    vec3 radiance = vec3(0.0);
    if (depth != photic_empty_depth) {
        float along;
        vec4 light = photicVolumeLight(position, along);
        radiance = photic_sun_irradiance * exp(-photic_water_extinction * along) *
                   (light.w * max(0.0, -dot(photicNormal(texel), light.xyz)) * 0.31830988618);
#ifdef PHOTIC_MOVERS
        if (light.w > 0.0) radiance *= photicPassesMovers(position, light.xyz, 1.0);
#endif
        if (photic_has_albedo != 0) radiance *= texelFetch(photic_albedo, texel, 0).rgb;
    }
    if (photic_scattering.x + photic_scattering.y + photic_scattering.z > 0.0) {
        vec3 sight = position - photic_camera;
        float limit = length(sight);
        sight /= limit;
        // Only the wet stretch counts for extinction, from the still surface on.
        float start = photic_camera.z > photic_water_level.x && sight.z < 0.0 ? (photic_water_level.x - photic_camera.z) / sight.z : 0.0;
        radiance += photicVolumeScatter(photic_camera, sight, start, limit);
    }
    if (radiance == vec3(0.0)) discard;
    photic_radiance = vec4(radiance, 0.0);
}
