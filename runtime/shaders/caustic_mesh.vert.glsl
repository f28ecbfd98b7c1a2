// SPDX-License-Identifier: Apache-2.0
// The water's mesh, carried along its refracted rays to one level layer of a caustic map: for each triangle, six vertices
// that cover the texels which it touches.
#include "photic_water.glsl"

uniform highp sampler2D photic_ray_starts;      // water_rays.frag.glsl
uniform highp sampler2D photic_ray_directions;
uniform vec4 photic_caustic_rect;    // lower corner x, y at the water's level [m]; 1 / width, 1 / depth [1/m]
uniform vec2 photic_caustic_size;    // texels
uniform vec2 photic_caustic_period;  // [m]; instances are neighbours, the fifth in the middle; 0: one instance
uniform float photic_layer_z;        // [m]

flat out vec2 photic_a, photic_b, photic_c;  // where the corners land [texels]
flat out vec4 photic_light_of_triangle;      // xyz: mean direction, unit; w: power over the sun's irradiance [texels]

void main() {
    int triangle = gl_VertexID / 6, corner = gl_VertexID % 6;
    int columns = textureSize(photic_ray_starts, 0).x - 1;
    ivec2 cell = ivec2((triangle / 2) % columns, (triangle / 2) / columns);
    vec3 light = photicStillWaterDirection();
    vec2 shift = photic_caustic_period * vec2(gl_InstanceID % 3 - 1, gl_InstanceID / 3 - 1);
    vec2 texels_per_metre = photic_caustic_size * photic_caustic_rect.zw;
    vec2 landing[3], first, last;
    vec3 direction = vec3(0.0);
    float power = 0.0;
    for (int i = 0; i < 3; ++i) {
        ivec2 vertex = cell + (i == 0 ? ivec2(0) : i == 1 ? ivec2(1) : (triangle & 1) == 0 ? ivec2(1, 0) : ivec2(0, 1));
        vec4 start = texelFetch(photic_ray_starts, vertex, 0);
        vec3 ray = texelFetch(photic_ray_directions, vertex, 0).xyz;
        vec2 place = start.xy + ray.xy * ((photic_layer_z - start.z) / ray.z) -
                     light.xy / light.z * (photic_layer_z - photic_water_level.x) + shift;
        landing[i] = (place - photic_caustic_rect.xy) * texels_per_metre;
        direction += ray;
        power += start.w / 3.0;
        if (i == 0) first = start.xy;
        if (i == 1) last = start.xy;
    }
    vec2 cell_size = abs(last - first) * texels_per_metre;
    photic_light_of_triangle = vec4(normalize(direction), power * 0.5 * cell_size.x * cell_size.y);
    photic_a = landing[0], photic_b = landing[1], photic_c = landing[2];

    // Whole texels, so that rounding in the rasteriser cannot lose one.
    vec2 low = floor(min(landing[0], min(landing[1], landing[2])));
    vec2 high = ceil(max(landing[0], max(landing[1], landing[2])));
    high = max(high, low + 1.0);
    vec2 end = vec2(corner == 1 || corner == 2 || corner == 4 ? high.x : low.x, corner == 2 || corner >= 4 ? high.y : low.y);
    if (corner == 3) end = low;
    gl_Position = vec4(end / photic_caustic_size * 2.0 - 1.0, 0.0, 1.0);
}
