// SPDX-License-Identifier: Apache-2.0
#pragma once

/// GLSL of the viewer itself: what a game would have of its own. What lights the scene is the runtime's.
namespace photic::viewer::shaders {

/// Positions and normals of the stage, or of the ball (moved and scaled).
inline constexpr const char* kStageVertex = R"(#version 430 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 clip_from_world;
uniform vec4 place;  // xyz: shift; w: scale
out vec3 world;
out vec3 world_normal;
void main() {
    world = position * place.w + place.xyz;
    world_normal = normal;
    gl_Position = clip_from_world * vec4(world, 1.0);
})";

/// Normals and albedo. Tiles as in `photic picture --tiles`.
inline constexpr const char* kStageFragment = R"(#version 430 core
in vec3 world;
in vec3 world_normal;
uniform vec3 base;
uniform float tile_size;  // [m]; 0: plain
uniform vec4 walls[8];    // xyz . p >= w inside the room
uniform float wall_count, tolerance;  // tolerance [m]
layout(location = 0) out vec4 normal_out;
layout(location = 1) out vec4 albedo_out;
void main() {
    for (int i = 0; i < int(wall_count); ++i) {
        if (dot(walls[i].xyz, world) < walls[i].w - tolerance) discard;
    }
    vec3 n = normalize(world_normal) * (gl_FrontFacing ? 1.0 : -1.0);  // of the side that is seen
    vec3 albedo = base;
    if (tile_size > 0.0) {
        vec2 place = abs(n.x) > 0.7 ? world.yz : abs(n.y) > 0.7 ? world.zx : world.xy;
        place /= tile_size;
        vec2 tile = floor(place), within = place - tile;
        // Joints no thinner than a pixel, or they would flicker.
        vec2 width = max(vec2(0.0175), fwidth(place));
        vec2 joint = min(smoothstep(vec2(0.0), width, within), smoothstep(vec2(0.0), width, 1.0 - within));
        float value = fract(sin(dot(tile, vec2(12.9898, 78.233))) * 43758.5453);
        albedo *= mix(0.62, 0.93 + 0.07 * value, joint.x * joint.y);
    }
    normal_out = vec4(n, 0.0);
    albedo_out = vec4(albedo, 1.0);
})";

inline constexpr const char* kFullScreenVertex = R"(#version 430 core
out vec2 uv;
void main() {
    uv = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));
    gl_Position = vec4(uv * 2.0 - 1.0, 0.0, 1.0);
})";

/// Skylight on receivers, and the sun on what is out of the water.
inline constexpr const char* kBaseFragment = R"(#version 430 core
in vec2 uv;
uniform sampler2D depth_texture, normal_texture, albedo_texture;
uniform mat4 world_from_clip;
uniform vec3 ambient;  // irradiance of the sky [W/m2]
uniform vec3 sun_direction, sun_irradiance;
uniform sampler2D water_texture;  // z of the surface [m]
uniform vec4 water_rect;          // lower corner, 1 / size [m]
uniform sampler2D environment_texture;
uniform float environment_gain, environment_turn;  // gain 0: there is none
uniform vec3 eye;
out vec4 radiance;
void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depth_texture, pixel, 0).r;
    if (depth == 1.0) {
        radiance = vec4(0.0);
        if (environment_gain > 0.0) {
            vec4 far_place = world_from_clip * vec4(uv * 2.0 - 1.0, 0.5, 1.0);
            vec3 d = normalize(far_place.xyz / far_place.w - eye);
            vec2 at = vec2(fract(0.5 - (atan(d.y, d.x) - environment_turn) / 6.28318531), 0.5 + asin(clamp(d.z, -1.0, 1.0)) / 3.14159265);
            radiance = vec4(environment_gain * textureLod(environment_texture, at, 0.0).rgb, 1.0);
        }
        return;
    }
    vec4 place = world_from_clip * vec4(uv * 2.0 - 1.0, 2.0 * depth - 1.0, 1.0);
    vec3 n = texelFetch(normal_texture, pixel, 0).xyz;
    vec3 light = ambient * (0.7 + 0.3 * n.z);
    place /= place.w;
    if (place.z > texture(water_texture, (place.xy - water_rect.xy) * water_rect.zw).r) light += sun_irradiance * max(0.0, -dot(sun_direction, n));
    radiance = vec4(texelFetch(albedo_texture, pixel, 0).rgb / 3.14159265 * light, 1.0);
})";

/// What the water between a surface and the eye lets through: multiplied with what is there.
inline constexpr const char* kVeilFragment = R"(#version 430 core
in vec2 uv;
uniform sampler2D depth_texture;
uniform mat4 world_from_clip;
uniform vec3 eye, low, high;  // of the water's box [m]
uniform vec3 extinction;      // [1/m]
uniform float covers;         // 1: what it takes away from the background is opaque; 0: the background is left alone
out vec4 transmittance;       // a: how much it covers
void main() {
    float depth = texelFetch(depth_texture, ivec2(gl_FragCoord.xy), 0).r;
    vec4 place = world_from_clip * vec4(uv * 2.0 - 1.0, 2.0 * depth - 1.0, 1.0);
    vec3 sight = place.xyz / place.w - eye;
    float limit = length(sight);
    sight /= limit;
    vec3 a = (low - eye) / sight, b = (high - eye) / sight, enter = min(a, b), leave = max(a, b);
    float start = max(0.0, max(enter.x, max(enter.y, enter.z))), end = min(limit, min(leave.x, min(leave.y, leave.z)));
    vec3 left = exp(-extinction * max(0.0, end - start));
    transmittance = vec4(left, covers * (1.0 - dot(left, vec3(1.0 / 3.0))));
})";

/// The water's surface from either side: the sky in it, laid over what is behind.
inline constexpr const char* kSurfaceFragment = R"(#version 430 core
in vec3 world;
in vec3 world_normal;
uniform vec3 eye, sun_direction;
uniform float sky, ior, metal;  // metal: reflectance at any angle; 0: Fresnel's
uniform vec3 low, high;  // of the box [m]
out vec4 colour;
void main() {
    vec3 sight = normalize(world - eye), n = normalize(world_normal);
    if (dot(sight, n) > 0.0) n = -n;
    float c = -dot(sight, n), g = sqrt(max(0.0, ior * ior - 1.0 + c * c));
    float rs = (c - g) / (c + g), rp = (ior * ior * c - g) / (ior * ior * c + g);
    float reflectance = metal > 0.0 ? metal : 0.5 * (rs * rs + rp * rp);
    vec3 back = reflect(sight, n);
    vec3 seen = sky * mix(vec3(0.85, 0.92, 1.0), vec3(0.30, 0.52, 0.92), sqrt(max(0.0, back.z)));
    // The sun as a lobe of two degrees: its true disc would alias into specks.
    seen += 40.0 * sky * exp(-(1.0 - dot(back, -sun_direction)) / 6.1e-4);
    colour = vec4(seen * reflectance, reflectance);
    // A line where the surface is cut, or nobody sees where the water ends.
    vec2 side = min(world.xy - low.xy, high.xy - world.xy);
    if (min(side.x, side.y) < 0.004 * max(high.x - low.x, high.y - low.y)) colour = mix(colour, vec4(1.6 * sky * vec3(0.75, 0.92, 1.0), 1.0), 0.5);
})";

/// Two pictures side by side, tone mapped (fit of the ACES curve by K. Narkowicz, 2015) over a quiet gradient, as
/// `photic picture` shows radiance. The only place where radiance becomes colour.
inline constexpr const char* kDisplayFragment = R"(#version 430 core
in vec2 uv;
uniform sampler2D left_texture, right_texture;
uniform float exposure, split;  // split: part of the width that shows the left picture
out vec4 colour;
vec3 filmic(vec3 x) { return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0); }
void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 radiance = uv.x < split ? texelFetch(left_texture, pixel, 0) : texelFetch(right_texture, pixel, 0);
    vec3 shown = filmic(max(radiance.rgb, 0.0) / max(radiance.a, 1e-3) * exposure);
    shown = mix(1.055 * pow(shown, vec3(1.0 / 2.4)) - 0.055, 12.92 * shown, lessThan(shown, vec3(0.0031308)));
    vec3 encoded = mix(mix(vec3(0.07, 0.08, 0.10), vec3(0.20, 0.23, 0.27), uv.y), shown, clamp(radiance.a, 0.0, 1.0));
    if (split > 0.0 && split < 1.0 && abs(gl_FragCoord.x - split * float(textureSize(left_texture, 0).x)) < 1.0) encoded = vec3(1.0);
    colour = vec4(encoded, 1.0);
})";

}  // namespace photic::viewer::shaders
