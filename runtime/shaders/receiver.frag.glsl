// SPDX-License-Identifier: Apache-2.0
// Light of one source on the surfaces of a G-buffer, to be added to what is there.
// PHOTIC_LIGHT_SOURCE: 0 a volume, 1 a caustic map, 2 a look at the water's slopes.
#ifndef PHOTIC_LIGHT_SOURCE
#define PHOTIC_LIGHT_SOURCE 0
#endif
#include "g_buffer.glsl"
#ifdef PHOTIC_MOVERS
#include "photic_movers.glsl"
#endif
#if PHOTIC_LIGHT_SOURCE == 0
#include "photic_volume.glsl"
#else
#include "photic_water.glsl"
#if PHOTIC_LIGHT_SOURCE == 1
#include "photic_caustic_map.glsl"
#define photicIrradiance photicCausticIrradiance
#else
#include "photic_water_lookup.glsl"
#define photicIrradiance photicLookupIrradiance
#endif

/// Part of the light of water without a bake that passes all movers (photic_volume.glsl has it for baked light).
float photicPasses(vec3 world) {
#ifndef PHOTIC_MOVERS
    return 1.0;
#elif PHOTIC_LIGHT_SOURCE == 1
    vec4 light = photicCausticSample(world);
    return photicPassesMovers(world, light.xyz, light.w);
#else
    // A look-up knows still water's directions; what is above it gets light that the water throws up.
    vec3 up = photic_sun_direction * vec3(1.0, 1.0, -1.0);
    return photicPassesMovers(world, world.z < photic_water_level.x ? photicStillWaterDirection() : up, 1.0);
#endif
}
#endif
in vec2 photic_uv;
layout(location = 0) out vec4 photic_color;
uniform float photic_scale;        // of the result
uniform int photic_has_albedo;     // 0: albedo 1
uniform int photic_as_irradiance;  // 1: irradiance instead of radiance

void main() {
    // The target stands for the whole G-buffer, which may be larger or smaller than it.
    vec2 size = vec2(textureSize(photic_depth, 0));
    ivec2 texel = ivec2(photic_uv * size);
    float depth = texelFetch(photic_depth, texel, 0).r;
    if (depth == photic_empty_depth) discard;
    vec3 world = photicWorld((vec2(texel) + 0.5) / size, depth);
    vec3 light = photicIrradiance(world, photicNormal(texel)) * photic_scale;
#if PHOTIC_LIGHT_SOURCE != 0
    light *= photicPasses(world);
#endif
    if (photic_as_irradiance == 0) {
        light *= 0.31830988618;
        if (photic_has_albedo != 0) light *= texelFetch(photic_albedo, texel, 0).rgb;
    }
    photic_color = vec4(light, 0.0);
}
