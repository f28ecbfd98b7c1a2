// SPDX-License-Identifier: Apache-2.0
// What is seen through objects whose index varies (BentRayPass in photic/bent_rays.h). Pixels that see none are left.
#ifdef PHOTIC_LIT
#include "photic_volume.glsl"
#include "photic_phase.glsl"
#endif
#include "photic_bent.glsl"
in vec2 photic_uv;
layout(location = 0) out vec4 photic_color;
layout(binding = 3) uniform highp sampler2D photic_bent_environment;  // latitude and longitude, Z up, its middle along +x
layout(binding = 4) uniform highp sampler2D photic_depth;
layout(binding = 11) uniform highp sampler2D photic_bent_radiance;    // what was drawn without the objects
uniform mat4 photic_place_from_clip;     // places are relative to the camera
uniform mat4 photic_clip_from_place;
uniform vec4 photic_bent_surroundings;  // rgb: factor on the environment, or its colour; w: turn about z [radians]
uniform ivec4 photic_bent_has;          // an environment; depth; radiance; clip depth 0 to 1
uniform float photic_empty_depth;
uniform int photic_bent_disperses;

vec3 photicEnvironment(vec3 direction) {
    if (photic_bent_has.x == 0) return photic_bent_surroundings.rgb;
    float turn = atan(direction.y, direction.x) - photic_bent_surroundings.w;
    vec2 uv = vec2(fract(0.5 - turn * 0.15915494309), 0.5 + asin(clamp(direction.z, -1.0, 1.0)) * 0.31830988618);
    return textureLod(photic_bent_environment, uv, 0.0).rgb * photic_bent_surroundings.rgb;
}

bool photicNearby(vec3 from, vec3 direction, float limit, out vec3 radiance);
#include "photic_bent_trace.glsl"

float photicClipZ(float depth) { return photic_bent_has.w != 0 ? depth : 2.0 * depth - 1.0; }
vec3 photicPlace(vec3 clip) {
    vec4 place = photic_place_from_clip * vec4(clip, 1.0);
    return place.xyz / place.w;
}
/// Whether a clip position lies behind what was drawn there, and where that is.
bool photicBehind(vec3 clip, out vec3 surface) {
    vec2 size = vec2(textureSize(photic_depth, 0));
    float depth = texelFetch(photic_depth, ivec2(clamp((0.5 * clip.xy + 0.5) * size, vec2(0.0), size - 1.0)), 0).r;
    surface = vec3(clip.xy, photicClipZ(depth));
    if (depth == photic_empty_depth) return false;
    return photic_empty_depth > 0.5 ? clip.z > surface.z : clip.z < surface.z;
}

/// Goes along a ray in the picture until it is behind what was drawn. What is not in the picture is not found.
bool photicNearby(vec3 from, vec3 direction, float limit, out vec3 radiance) {
    radiance = vec3(0.0);
    if (photic_bent_has.y == 0) return false;
    if (!photic_bent_touched) {
        // Still the camera's own ray: its pixel's depth ends it.
        vec2 size = vec2(textureSize(photic_depth, 0));
        float depth = texelFetch(photic_depth, ivec2(photic_uv * size), 0).r;
        if (depth == photic_empty_depth) return false;
        return length(photicPlace(vec3(2.0 * photic_uv - 1.0, photicClipZ(depth)))) < length(from) + limit;
    }
    if (photic_bent_has.z == 0) return false;
    // The part of the ray that is in the picture.
    vec4 a = photic_clip_from_place * vec4(from, 1.0), d = photic_clip_from_place * vec4(direction, 0.0);
    float begin = 0.0, end = min(limit, 1e6);
    vec4 sides_a = vec4(a.w - a.x, a.w + a.x, a.w - a.y, a.w + a.y);
    vec4 sides_d = vec4(d.w - d.x, d.w + d.x, d.w - d.y, d.w + d.y);
    for (int i = 0; i < 4; ++i) {
        if (sides_d[i] > 0.0) begin = max(begin, -sides_a[i] / sides_d[i]);
        if (sides_d[i] < 0.0) end = min(end, -sides_a[i] / sides_d[i]);
    }
    float near = 1e-3 * max(a.w, 1e-3);
    if (d.w > 0.0) begin = max(begin, (near - a.w) / d.w);
    if (d.w < 0.0) end = min(end, (near - a.w) / d.w);
    if (!(end > begin)) return false;
    vec4 c0 = a + begin * d, c1 = a + end * d;
    vec3 s0 = c0.xyz / c0.w, s1 = c1.xyz / c1.w, surface;
    const int kSteps = 48;
    vec3 before = s0;
    bool hit = photicBehind(s0, surface);
    if (hit) {
        // It begins just below a surface, as where a glass stands on a table.
        vec3 place = photicPlace(surface);
        hit = distance(place, from + begin * direction) < 0.05 * length(place);
    }
    for (int i = 1; i <= kSteps && !hit; ++i) {
        vec3 here = mix(s0, s1, float(i) / float(kSteps)), met;
        if (photicBehind(here, met)) {
            vec3 low = before, high = here;
            for (int k = 0; k < 7; ++k) {
                vec3 middle = 0.5 * (low + high), s;
                if (photicBehind(middle, s)) {
                    high = middle;
                    surface = s;
                } else {
                    low = middle;
                }
            }
            if (!photicBehind(high, surface)) surface = met;
            vec3 place = photicPlace(high);
            // Where it only passes behind an edge, it goes on.
            hit = distance(photicPlace(surface), place) < 0.05 * length(place);
        }
        before = here;
    }
    if (!hit) return false;
    vec2 size = vec2(textureSize(photic_bent_radiance, 0));
    if (photic_bent_origin.w != 0.0) return true;
    radiance = texelFetch(photic_bent_radiance, ivec2(clamp((0.5 * surface.xy + 0.5) * size, vec2(0.0), size - 1.0)), 0).rgb;
    return true;
}

void main() {
    vec3 direction = normalize(photicPlace(vec3(2.0 * photic_uv - 1.0, photicClipZ(0.5))));
    bool touched = false;
    vec3 light = vec3(0.0);
    int rays = photic_bent_disperses != 0 ? 3 : 1;
    for (int c = 0; c < rays; ++c) {
        vec3 channels = vec3(equal(ivec3(c), ivec3(0, 1, 2)));
        bool met;
        light += photicBentRadiance(vec3(0.0), direction, rays == 1 ? vec3(1.0) : channels, c, met);
        touched = touched || met;
    }
    if (!touched) discard;
    photic_color = vec4(light, 1.0);
}
