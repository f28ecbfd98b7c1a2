// SPDX-License-Identifier: Apache-2.0
// Light of one volume that a medium scatters towards the camera; alpha: where the segment ends [m].
#include "photic_volume.glsl"
#include "photic_medium.glsl"
#include "g_buffer.glsl"
#include "eye_segment.glsl"
in vec2 photic_uv;
layout(location = 0) out vec4 photic_color;
uniform vec3 photic_scattering;
uniform vec3 photic_absorption;
uniform float photic_anisotropy;
uniform float photic_scale;
uniform ivec4 photic_march;  // steps; 1 to jitter; frame; 1 to skip dark pages
uniform int photic_stride;   // 2 at half resolution: the G-buffer's texels from one of the target's to the next

/// Interleaved gradient noise (Jimenez 2014, Next Generation Post Processing in Call of Duty), moved on by each frame.
float photicNoise(vec2 pixel, int frame) {
    float n = fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
    return fract(n + 0.61803399 * float(frame % 1024));
}

void main() {
    ivec2 size = textureSize(photic_depth, 0);
    // At half resolution each pixel is that of one texel, not the mean of four: it then has one depth.
    ivec2 texel = photic_stride == 1 ? ivec2(photic_uv * vec2(size)) : min(ivec2(gl_FragCoord.xy) * photic_stride, size - 1);
    PhoticSegment s = photicSegment(texel);
    vec3 light = vec3(0.0);
    if (s.end > s.begin) {
        PhoticMedium medium = PhoticMedium(photic_scattering, photic_absorption, photic_anisotropy);
        PhoticRay ray = PhoticRay(photic_camera + s.begin * s.direction, s.direction);
        float jitter = photic_march.y != 0 ? photicNoise(gl_FragCoord.xy, photic_march.z) : 0.5;
        light = photicInscatter(ray, s.end - s.begin, medium, photic_march.x, jitter, photic_march.w != 0);
    }
    photic_color = vec4(light * photic_scale, min(s.end, 65504.0));
}
