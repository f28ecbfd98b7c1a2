// SPDX-License-Identifier: Apache-2.0
// The live counterpart of the baker's `beams`: each triangle of the water's mesh, carried along its refracted rays to the
// middle of each layer of voxels, lays its power into the voxels that it covers there, by exact area. One thread a triangle
// and PHOTIC_LIVE_LAYERS layers.
#include "photic_water.glsl"
#include "photic_cell_share.glsl"
#include "live_grid.glsl"
#ifndef PHOTIC_LIVE_LAYERS
#define PHOTIC_LIVE_LAYERS 8
#endif
layout(local_size_x = 64) in;

uniform highp sampler2D photic_ray_starts;  // water_rays.frag.glsl
uniform highp sampler2D photic_ray_directions;
uniform vec3 photic_live_corner;  // of the box [m]
uniform vec3 photic_live_voxel;   // its voxels' sides [m]
uniform vec4 photic_live_mesh;    // spacing of the mesh x, y [m]
uniform vec3 photic_live_sun;     // irradiance per channel over the reference

void photicLiveAdd(int at, float value) {
    atomicAdd(photic_live_sums[at], int(floor(clamp(value, -8000.0, 8000.0) * photicLiveUnit + 0.5)));
}

/// The power of a triangle in one layer.
/// @param power  over the sun's irradiance, of its level area
void photicLiveLayer(int layer, vec4 starts[3], vec3 rays[3], vec3 direction, float power) {
    float height = photic_live_voxel.z, middle = photic_live_corner.z + (float(layer) + 0.5) * height;
    vec2 landing[3];
    float open = 0.0, path = 0.0;
    for (int i = 0; i < 3; ++i) {
        float down = (middle - starts[i].z) / rays[i].z;
        landing[i] = (starts[i].xy + rays[i].xy * down - photic_live_corner.xy) / photic_live_voxel.xy;
        // The part of the layer that lies below the surface, and how far the light has come there.
        open += clamp((starts[i].z - middle) / height + 0.5, 0.0, 1.0) / 3.0;
        path += max(0.0, down) / 3.0;
    }
    ivec2 low = ivec2(floor(min(landing[0], min(landing[1], landing[2]))));
    ivec2 high = ivec2(floor(max(landing[0], max(landing[1], landing[2]))));
    if (photic_live_cells.w == 0) {
        low = max(low, ivec2(-photic_live_pad));
        high = min(high, photic_live_cells.xy + photic_live_pad - 1);
    }
    if (!(open > 0.0) || any(lessThan(high, low))) return;
    // Fluence rate of a cell that gets all of it.
    float all = power * open / (photic_live_voxel.x * photic_live_voxel.y * -direction.z);
    vec3 colour = photic_live_sun * exp(-photic_water_extinction * path) * all;
    float mean = PHOTIC_COLOURED != 0 ? (colour.x + colour.y + colour.z) / 3.0 : colour.x;
    for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
            vec2 corner = vec2(x, y);
            float part = photicCellShare(landing[0] - corner, landing[1] - corner, landing[2] - corner);
            int at = part > 0.0 ? photicLiveAt(ivec2(x, y), layer) : -1;
            if (at < 0) continue;
            photicLiveAdd(at, part * mean * direction.x);
            photicLiveAdd(at + 1, part * mean * direction.y);
            photicLiveAdd(at + 2, part * mean * direction.z);
            photicLiveAdd(at + 3, part * mean);
#if PHOTIC_COLOURED
            photicLiveAdd(at + 4, part * colour.x);
            photicLiveAdd(at + 5, part * colour.y);
            photicLiveAdd(at + 6, part * colour.z);
#endif
        }
    }
}

void main() {
    int triangle = int(gl_GlobalInvocationID.x);
    ivec2 vertices = textureSize(photic_ray_starts, 0);
    int columns = vertices.x - 1;
    if (triangle >= 2 * columns * (vertices.y - 1)) return;
    ivec2 cell = ivec2((triangle / 2) % columns, (triangle / 2) / columns);
    vec4 starts[3];
    vec3 rays[3];
    for (int i = 0; i < 3; ++i) {
        ivec2 vertex = cell + (i == 0 ? ivec2(0) : i == 1 ? ivec2(1) : (triangle & 1) == 0 ? ivec2(1, 0) : ivec2(0, 1));
        starts[i] = texelFetch(photic_ray_starts, vertex, 0);
        rays[i] = texelFetch(photic_ray_directions, vertex, 0).xyz;
    }
    float power = (starts[0].w + starts[1].w + starts[2].w) / 6.0 * photic_live_mesh.x * photic_live_mesh.y;
    if (!(power > 0.0)) return;
    vec3 direction = normalize(rays[0] + rays[1] + rays[2]);
    int first = PHOTIC_LIVE_LAYERS * int(gl_GlobalInvocationID.y);
    int last = min(first + PHOTIC_LIVE_LAYERS, photic_live_cells.z);
    for (int layer = first; layer < last; ++layer) photicLiveLayer(layer, starts, rays, direction, power);
}
