// SPDX-License-Identifier: Apache-2.0
// The live counterpart of the baker's `beams`: each triangle of the water's mesh, carried along its refracted rays to the
// middle of each layer of voxels, lays its power into the voxels that it covers there, by exact area.
//
// A group of threads has 8 x 8 cells of the mesh and PHOTIC_LIVE_LAYERS layers, a thread the two triangles of a cell. Their
// light lands close together: sums are made in a window of the group's own memory first, since a GPU's atomic additions to
// its main memory are what takes the time (1.6 times as long without it). What lands beside the window goes to main memory
// at once. Sums are of whole numbers, so that the way makes no difference to a bit.
#include "photic_water.glsl"
#include "photic_cell_share.glsl"
#include "live_grid.glsl"
#ifndef PHOTIC_LIVE_LAYERS
#define PHOTIC_LIVE_LAYERS 8
#endif
layout(local_size_x = 8, local_size_y = 8) in;

uniform highp sampler2D photic_ray_starts;  // water_rays.frag.glsl
uniform highp sampler2D photic_ray_directions;
uniform vec3 photic_live_corner;  // of the box [m]
uniform vec3 photic_live_voxel;   // its voxels' sides [m]
uniform vec4 photic_live_mesh;    // spacing of the mesh x, y [m]
uniform vec3 photic_live_sun;     // irradiance per channel over the reference

uniform int photic_live_window;   // cells along x and y of the group's window, up to kWindow

const int kWindow = 16;
shared int photic_live_here[kWindow * kWindow * photicLiveValues];
ivec2 photic_live_window_at;  // its least cell

int photicLiveWhole(float value) { return int(floor(clamp(value, -8000.0, 8000.0) * photicLiveUnit + 0.5)); }

/// Adds a cell's values.
void photicLiveAdd(ivec2 cell, int layer, vec4 light, vec3 colour) {
    ivec2 in_window = cell - photic_live_window_at;
    if (all(greaterThanEqual(in_window, ivec2(0))) && all(lessThan(in_window, ivec2(photic_live_window)))) {
        int at = (in_window.y * photic_live_window + in_window.x) * photicLiveValues;
        for (int i = 0; i < 4; ++i) atomicAdd(photic_live_here[at + i], photicLiveWhole(light[i]));
#if PHOTIC_COLOURED
        for (int i = 0; i < 3; ++i) atomicAdd(photic_live_here[at + 4 + i], photicLiveWhole(colour[i]));
#endif
        return;
    }
    int at = photicLiveAt(cell, layer);
    if (at < 0) return;
    for (int i = 0; i < 4; ++i) atomicAdd(photic_live_sums[at + i], photicLiveWhole(light[i]));
#if PHOTIC_COLOURED
    for (int i = 0; i < 3; ++i) atomicAdd(photic_live_sums[at + 4 + i], photicLiveWhole(colour[i]));
#endif
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
    vec4 light = vec4(direction, 1.0) * mean;
    for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
            vec2 corner = vec2(x, y);
            float part = photicCellShare(landing[0] - corner, landing[1] - corner, landing[2] - corner);
            if (part > 0.0) photicLiveAdd(ivec2(x, y), layer, part * light, part * colour);
        }
    }
}

/// One of the triangles of a cell of the mesh.
struct PhoticLiveTriangle {
    vec4 starts[3];
    vec3 rays[3];
    vec3 direction;
    float power;  ///< 0: none
};
PhoticLiveTriangle photicLiveTriangle(ivec2 cell, int number) {
    PhoticLiveTriangle t;
    for (int i = 0; i < 3; ++i) {
        ivec2 vertex = cell + (i == 0 ? ivec2(0) : i == 1 ? ivec2(1) : number == 0 ? ivec2(1, 0) : ivec2(0, 1));
        t.starts[i] = texelFetch(photic_ray_starts, vertex, 0);
        t.rays[i] = texelFetch(photic_ray_directions, vertex, 0).xyz;
    }
    t.power = (t.starts[0].w + t.starts[1].w + t.starts[2].w) / 6.0 * photic_live_mesh.x * photic_live_mesh.y;
    t.direction = normalize(t.rays[0] + t.rays[1] + t.rays[2]);
    return t;
}

void main() {
    ivec2 cells = textureSize(photic_ray_starts, 0) - 1;
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    bool in_mesh = all(lessThan(cell, cells));
    PhoticLiveTriangle triangles[2];
    triangles[0].power = triangles[1].power = 0.0;
    if (in_mesh) {
        triangles[0] = photicLiveTriangle(cell, 0);
        triangles[1] = photicLiveTriangle(cell, 1);
    }
    // The window is around where light of the group's middle lands.
    ivec2 middle = min(8 * ivec2(gl_WorkGroupID.xy) + 4, cells);
    vec3 start = texelFetch(photic_ray_starts, middle, 0).xyz, ray = texelFetch(photic_ray_directions, middle, 0).xyz;
    int values = photic_live_window * photic_live_window * photicLiveValues;
    int thread = int(gl_LocalInvocationIndex);
    for (int i = thread; i < values; i += 64) photic_live_here[i] = 0;
    int first = PHOTIC_LIVE_LAYERS * int(gl_WorkGroupID.z);
    int last = min(first + PHOTIC_LIVE_LAYERS, photic_live_cells.z);
    for (int layer = first; layer < last; ++layer) {
        float z = photic_live_corner.z + (float(layer) + 0.5) * photic_live_voxel.z;
        vec2 landing = (start.xy + ray.xy * ((z - start.z) / ray.z) - photic_live_corner.xy) / photic_live_voxel.xy;
        photic_live_window_at = ivec2(floor(landing)) - photic_live_window / 2;
        memoryBarrierShared();
        barrier();
        for (int n = 0; n < 2; ++n) {
            if (triangles[n].power > 0.0)
                photicLiveLayer(layer, triangles[n].starts, triangles[n].rays, triangles[n].direction, triangles[n].power);
        }
        memoryBarrierShared();
        barrier();
        for (int i = thread; i < values; i += 64) {
            int sum = photic_live_here[i];
            if (sum == 0) continue;
            photic_live_here[i] = 0;
            int in_window = i / photicLiveValues;
            ivec2 at = photic_live_window_at +
                       ivec2(in_window % photic_live_window, in_window / photic_live_window);
            int to = photicLiveAt(at, layer);
            if (to >= 0) atomicAdd(photic_live_sums[to + i % photicLiveValues], sum);
        }
    }
}
