// SPDX-License-Identifier: Apache-2.0
// The part of a triangle's power that falls into a texel, added to what other triangles bring: the exact area of their
// intersection over the triangle's.
flat in vec2 photic_a, photic_b, photic_c;
flat in vec4 photic_light_of_triangle;

#include "photic_cell_share.glsl"

layout(location = 0) out vec4 photic_light;  // flux.xyz, fluence rate, over the sun's irradiance

void main() {
    vec2 texel = floor(gl_FragCoord.xy);
    float part = photicCellShare(photic_a - texel, photic_b - texel, photic_c - texel);
    if (part == 0.0) discard;
    vec3 direction = photic_light_of_triangle.xyz;
    // Half floats end at 65504.
    float fluence = clamp(part * photic_light_of_triangle.w / -direction.z, 0.0, 6e4);
    photic_light = vec4(fluence * direction, fluence);
}
