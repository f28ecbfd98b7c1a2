// SPDX-License-Identifier: Apache-2.0
// Spreads light that was gathered at half resolution over the pixels: bilinear weights, less for other depths (joint
// bilateral upsampling, Kopf et al. 2007).
#include "g_buffer.glsl"
#include "eye_segment.glsl"
in vec2 photic_uv;
layout(location = 0) out vec4 photic_color;
layout(binding = 3) uniform highp sampler2D photic_half;  // medium.frag.glsl's, texel h at the G-buffer's 2 h

void main() {
    ivec2 texel = ivec2(photic_uv * vec2(textureSize(photic_depth, 0)));
    ivec2 base = texel / 2, last = textureSize(photic_half, 0) - 1;
    vec2 f = 0.5 * vec2(texel - 2 * base);
    float end = min(photicSegment(texel).end, 65504.0);
    vec3 sum = vec3(0.0);
    float total = 0.0;
    for (int n = 0; n < 4; ++n) {
        ivec2 o = ivec2(n & 1, n >> 1);
        vec4 sampled = texelFetch(photic_half, min(base + o, last), 0);
        vec2 bilinear = mix(1.0 - f, f, vec2(o));
        float apart = abs(sampled.a - end) / max(end, 1e-3);
        float weight = (bilinear.x * bilinear.y + 1e-4) / (1e-3 + apart);
        sum += weight * sampled.rgb;
        total += weight;
    }
    photic_color = vec4(sum / total, 0.0);
}
