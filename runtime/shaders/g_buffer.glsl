// SPDX-License-Identifier: Apache-2.0
// What a game has drawn (GBuffer in photic/runtime_gl.h).
layout(binding = 4) uniform highp sampler2D photic_depth;
layout(binding = 5) uniform highp sampler2D photic_normals;
layout(binding = 6) uniform highp sampler2D photic_albedo;
uniform mat4 photic_world_from_clip;
uniform vec3 photic_camera;
uniform float photic_empty_depth;
uniform ivec2 photic_clip_depth;  // x: 1 when clip depth is 0 to 1; y: 1 when normals are stored as (n + 1) / 2

/// World position of the point that is seen at `uv` (0 to 1, lower left first) with window depth `depth`.
vec3 photicWorld(vec2 uv, float depth) {
    float z = photic_clip_depth.x != 0 ? depth : 2.0 * depth - 1.0;
    vec4 world = photic_world_from_clip * vec4(2.0 * uv - 1.0, z, 1.0);
    return world.xyz / world.w;
}

vec3 photicNormal(ivec2 texel) {
    vec3 n = texelFetch(photic_normals, texel, 0).xyz;
    if (photic_clip_depth.y != 0) n = 2.0 * n - 1.0;
    float size = length(n);
    return size > 0.0 ? n / size : vec3(0.0);
}
