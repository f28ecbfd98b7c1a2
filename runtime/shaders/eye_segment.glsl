// SPDX-License-Identifier: Apache-2.0
// The part of an eye ray that lies in the medium. Behind g_buffer.glsl.
uniform vec4 photic_medium_surface;  // the medium is where dot(xyz, world) <= w

struct PhoticSegment {
    vec3 direction;   // unit, away from the camera
    float begin, end;  // [m] from the camera; end < begin: none
};

/// Of the pixel of the G-buffer's texel `texel`: up to its surface.
PhoticSegment photicSegment(ivec2 texel) {
    vec2 uv = (vec2(texel) + 0.5) / vec2(textureSize(photic_depth, 0));
    float depth = texelFetch(photic_depth, texel, 0).r;
    PhoticSegment s;
    s.begin = 0.0;
    if (depth == photic_empty_depth) {
        // Any point of the ray gives its direction; the far plane may lie at infinity.
        s.direction = normalize(photicWorld(uv, 0.5) - photic_camera);
        s.end = 1e30;
    } else {
        vec3 way = photicWorld(uv, depth) - photic_camera;
        s.end = length(way);
        s.direction = s.end > 0.0 ? way / s.end : vec3(0.0, 0.0, 1.0);
    }
    float inside = photic_medium_surface.w - dot(photic_medium_surface.xyz, photic_camera);
    float rate = dot(photic_medium_surface.xyz, s.direction);
    if (rate > 0.0) {
        s.end = min(s.end, inside / rate);
    } else if (inside < 0.0) {
        s.begin = rate < 0.0 ? inside / rate : 1e30;
    }
    return s;
}
