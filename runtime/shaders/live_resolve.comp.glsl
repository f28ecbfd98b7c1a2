// SPDX-License-Identifier: Apache-2.0
// Sums of a live bake to the texels of its volume: each layer blurred by the image of the sun's disc there. Around the
// box one dark texel.
#include "live_grid.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 1) readonly buffer photic_live_kernel { float photic_live_weights[]; };  // layer by layer
layout(rgba16f, binding = 0) writeonly uniform highp image3D photic_live_light;
#if PHOTIC_COLOURED
layout(rgba16f, binding = 1) writeonly uniform highp image3D photic_live_rgb;
#endif

/// The nearest numbers that halves hold: what is stored is cut by some GPUs, which would dim all light by 0.03 %.
vec4 photicNearestHalf(vec4 v) {
    uvec4 bits = floatBitsToUint(v);
    return uintBitsToFloat((bits + 0xfffu + ((bits >> 13) & 1u)) & 0xffffe000u);
}

uniform ivec4 photic_live_border;  // dark texels around x and y: 0 where they repeat; around z

void main() {
    ivec3 texel = ivec3(gl_GlobalInvocationID), border = photic_live_border.xxy;
    if (any(greaterThanEqual(texel, photic_live_cells.xyz + 2 * border))) return;
    ivec3 cell = texel - border;
    vec4 light = vec4(0.0), colour = vec4(0.0);
    if (all(greaterThanEqual(cell, ivec3(0))) && all(lessThan(cell, photic_live_cells.xyz))) {
        // Of whole numbers, so that light that goes all one way stays so.
        int side = 2 * photic_live_pad + 1, weight_at = cell.z * side * side;
        for (int y = -photic_live_pad; y <= photic_live_pad; ++y) {
            for (int x = -photic_live_pad; x <= photic_live_pad; ++x) {
                float weight = photic_live_weights[weight_at++];
                int at = photicLiveAt(cell.xy - ivec2(x, y), cell.z);
                if (weight == 0.0 || at < 0) continue;
                light += weight * vec4(photic_live_sums[at], photic_live_sums[at + 1], photic_live_sums[at + 2], photic_live_sums[at + 3]);
#if PHOTIC_COLOURED
                colour += weight * vec4(photic_live_sums[at + 4], photic_live_sums[at + 5], photic_live_sums[at + 6], 0);
#endif
            }
        }
        light /= photicLiveUnit, colour /= photicLiveUnit;
    }
    imageStore(photic_live_light, texel, photicNearestHalf(light));
#if PHOTIC_COLOURED
    imageStore(photic_live_rgb, texel, photicNearestHalf(colour));
#endif
}
