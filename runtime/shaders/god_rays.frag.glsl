// SPDX-License-Identifier: Apache-2.0
// God rays without a bake, to be added to what is there (Guerin and Izumi, eq. 2).
#include "g_buffer.glsl"
#ifdef PHOTIC_MOVERS
#include "photic_movers.glsl"
#endif
#include "photic_water_lookup.glsl"
in vec2 photic_uv;
layout(location = 0) out vec4 photic_color;

void main() {
    vec2 size = vec2(textureSize(photic_depth, 0));
    ivec2 texel = ivec2(photic_uv * size);
    vec3 world = photicWorld((vec2(texel) + 0.5) / size, texelFetch(photic_depth, texel, 0).r);
    vec3 sight = world - photic_camera;
    float limit = length(sight);
    float gamma = photicGodRays(photic_camera, sight / limit, limit);
    photic_color = vec4(photic_sun_irradiance * (gamma * photic_god_rays.w), 0.0);
}
