// SPDX-License-Identifier: Apache-2.0
// One light volume. Bindings are those of GpuVolume::bind(0, 0) unless these are defined before:
#ifndef PHOTIC_BINDING_LIGHT
#define PHOTIC_BINDING_LIGHT 0    // three texture units,
#define PHOTIC_BINDING_COLOUR 1
#define PHOTIC_BINDING_PAGES 2
#define PHOTIC_BINDING_BUFFER 0   // a uniform buffer
#define PHOTIC_BINDING_BRICKS 0   // and, with PHOTIC_LIGHT_IN_BUFFER, a storage buffer
#endif
// For Vulkan, where all of them are of one number space, PHOTIC_SET is the descriptor set.
#undef PHOTIC_AT
#ifdef PHOTIC_SET
#define PHOTIC_AT(number) set = PHOTIC_SET, binding = number
#else
#define PHOTIC_AT(number) binding = number
#endif
// PHOTIC_LAYOUT: 1 atlas, 2 dense; not defined: as the parameters say.
// PHOTIC_COLOURED, PHOTIC_REPEATS, PHOTIC_BC6H: 0 or 1 where that is known, which saves a test or work; not defined: as the
// parameters say.
// PHOTIC_LIGHT_IN_BUFFER: the bricks lie in a storage buffer.
// PHOTIC_MOVERS: what moves darkens the light (photic_movers.glsl).
// PHOTIC_EXACT: eight reads weighted in float instead of the hardware's filter.

#ifndef PHOTIC_LIGHT
#define PHOTIC_LIGHT
/// Light at a point.
struct PhoticLight {
    vec3 irradiance;  ///< fluence rate per channel [W/m2]
    vec3 flux;        ///< of the mean of the channels [W/m2], along the direction of travel
    float mean;       ///< of irradiance
};
#endif

layout(std140, PHOTIC_AT(PHOTIC_BINDING_BUFFER)) uniform photic_parameters {
    vec4 photic_row_x;       // local = dot(row.xyz, world - centre) + row.w, in voxels; voxel centres are whole numbers
    vec4 photic_row_y;
    vec4 photic_row_z;
    vec3 photic_centre;      // [m]
    float photic_unit;       // W/m2 of a stored 1
    ivec3 photic_offset;     // cell = floor(local) + offset, counted from the first page's first
    int photic_layout;       // 1 atlas, 2 dense
    ivec3 photic_cell_min;   // cells that may be lit, both inside
    int photic_coloured;     // 1 when there are colours
    ivec3 photic_cell_max;
    int photic_directed;     // 1 when there are directions
    ivec3 photic_period;     // cells after which the light repeats, 0: it does not
    int photic_repeats;      // 1 when it does along any axis
    ivec4 photic_dense_min;  // xyz: cell that the dense texture's first texel stands for; w: 1 where textures are BC6H
    vec4 photic_texel;       // xyz: 1 / size of the texture
    vec4 photic_lit_min;     // xyz: local box outside of which all is dark; unbounded where the light repeats
    vec4 photic_lit_max;
    vec4 photic_mirror;      // xyz: of BC6H's flux; w: the bias on what BC6H stores
};

layout(PHOTIC_AT(PHOTIC_BINDING_PAGES)) uniform highp usampler3D photic_pages;
#ifdef PHOTIC_LIGHT_IN_BUFFER
layout(std430, PHOTIC_AT(PHOTIC_BINDING_BRICKS)) readonly buffer photic_bricks {
    uint photic_words[];  // per voxel 2 words of two halves: flux.xyz, mean; coloured: 4, then r, g, b, unused
};
#else
layout(PHOTIC_AT(PHOTIC_BINDING_LIGHT)) uniform highp sampler3D photic_light;
layout(PHOTIC_AT(PHOTIC_BINDING_COLOUR)) uniform highp sampler3D photic_rgb;
#endif
#ifndef PHOTIC_LAYOUT
#define PHOTIC_LAYOUT photic_layout
#endif

#ifndef PHOTIC_COLOURED
#define PHOTIC_COLOURED photic_coloured
#endif
#ifndef PHOTIC_REPEATS
#define PHOTIC_REPEATS photic_repeats
#endif
#ifndef PHOTIC_BC6H
#define PHOTIC_BC6H photic_dense_min.w
#endif

/// Position in voxels, near 0 in the volume's middle, so that float has bits left for the fraction.
vec3 photicLocal(vec3 world) {
    vec3 p = world - photic_centre;
    return vec3(dot(photic_row_x.xyz, p) + photic_row_x.w, dot(photic_row_y.xyz, p) + photic_row_y.w,
                dot(photic_row_z.xyz, p) + photic_row_z.w);
}

/// The same of a direction: voxels per metre along it.
vec3 photicLocalDirection(vec3 world) {
    return vec3(dot(photic_row_x.xyz, world), dot(photic_row_y.xyz, world), dot(photic_row_z.xyz, world));
}

int photicWrap(int cell, int low, int period) {
    if (period == 0) return cell;
    // Without an integer division, which is slow: a float's quotient is off by one at most.
    int d = cell - low;
    int r = d - int(floor(float(d) / float(period))) * period;
    return low + (r < 0 ? r + period : r >= period ? r - period : r);
}

/// The cell that a local position lies in, wrapped, and where in it. False where it is dark for certain: outside, or
/// not a number.
bool photicCell(vec3 local, out ivec3 cell, out vec3 fraction) {
    cell = ivec3(0);
    fraction = vec3(0.0);
    if (!all(lessThan(abs(local), vec3(4e6)))) return false;
    vec3 low = floor(local);
    fraction = local - low;
    cell = ivec3(low) + photic_offset;
    if (PHOTIC_REPEATS != 0) {
        cell = ivec3(photicWrap(cell.x, photic_cell_min.x, photic_period.x),
                     photicWrap(cell.y, photic_cell_min.y, photic_period.y),
                     photicWrap(cell.z, photic_cell_min.z, photic_period.z));
    }
    return all(greaterThanEqual(cell, photic_cell_min)) && all(lessThanEqual(cell, photic_cell_max));
}

/// Entry of the page of a cell: the brick in the low 24 bits (for the atlas its place, a byte an axis); where that is 0,
/// how far the dark reaches in the top byte, else 1 there where the brick has every second voxel of a block of 2^3 pages.
uint photicPage(ivec3 cell) { return texelFetch(photic_pages, cell >> 3, 0).r; }

vec4 photicBlend(vec4 v000, vec4 v100, vec4 v010, vec4 v110, vec4 v001, vec4 v101, vec4 v011, vec4 v111, vec3 f) {
    vec4 low = mix(mix(v000, v100, f.x), mix(v010, v110, f.x), f.y);
    vec4 high = mix(mix(v001, v101, f.x), mix(v011, v111, f.x), f.y);
    return mix(low, high, f.z);
}

#ifdef PHOTIC_LIGHT_IN_BUFFER
vec4 photicHalves(uint word) { return vec4(unpackHalf2x16(photic_words[word]), unpackHalf2x16(photic_words[word + 1u])); }

/// Eight voxels of a brick, beginning at word `at` and `stride` words apart.
vec4 photicWeighted(uint at, uint stride, vec3 f) {
    uint y = 9u * stride, z = 81u * stride;
    return photicBlend(photicHalves(at), photicHalves(at + stride), photicHalves(at + y), photicHalves(at + y + stride),
                       photicHalves(at + z), photicHalves(at + z + stride), photicHalves(at + y + z),
                       photicHalves(at + y + z + stride), f);
}
#elif defined(PHOTIC_EXACT)
vec4 photicWeighted(highp sampler3D s, ivec3 a, ivec3 b, vec3 f) {
    return photicBlend(texelFetch(s, a, 0), texelFetch(s, ivec3(b.x, a.y, a.z), 0), texelFetch(s, ivec3(a.x, b.y, a.z), 0),
                       texelFetch(s, ivec3(b.x, b.y, a.z), 0), texelFetch(s, ivec3(a.x, a.y, b.z), 0),
                       texelFetch(s, ivec3(b.x, a.y, b.z), 0), texelFetch(s, ivec3(a.x, b.y, b.z), 0), texelFetch(s, b, 0), f);
}
#endif

/// Where a cell lies in the brick of its page, in texels; `fraction` goes on from there.
ivec3 photicInBrick(uint entry, ivec3 cell, inout vec3 fraction) {
    if ((entry >> 24) == 0u) return cell & 7;
    // Wide voxels lie on every second fine one: the same light on both sides of a seam.
    ivec3 at = cell & 15;
    fraction = 0.5 * (vec3(at & 1) + fraction);
    return at >> 1;
}

/// Flux and mean of what BC6H's textures have: mirrored flux, and colour, both with a bias, which is taken off `colour` too.
vec4 photicOfBlocks(vec3 stored, inout vec4 colour) {
    stored -= photic_mirror.w;
    colour = max(colour - photic_mirror.w, vec4(0.0));
    return vec4(stored - 2.0 * dot(photic_mirror.xyz, stored) * photic_mirror.xyz, (colour.x + colour.y + colour.z) / 3.0);
}

/// Light at a local position.
PhoticLight photicSampleLocal(vec3 local) {
    PhoticLight light = PhoticLight(vec3(0.0), vec3(0.0), 0.0);
    ivec3 cell;
    vec3 fraction;
    if (!photicCell(local, cell, fraction)) return light;
    vec4 v, colour;
    bool coloured = PHOTIC_COLOURED != 0;
#ifndef PHOTIC_LIGHT_IN_BUFFER
    bool blocks = PHOTIC_BC6H != 0;
#endif
#ifdef PHOTIC_LIGHT_IN_BUFFER
    uint entry = photicPage(cell), brick = entry & 0xffffffu, stride = coloured ? 4u : 2u;
    if (brick == 0u) return light;
    uvec3 corner = uvec3(photicInBrick(entry, cell, fraction));
    uint at = (brick * 729u + corner.x + 9u * corner.y + 81u * corner.z) * stride;
    v = photicWeighted(at, stride, fraction);
    colour = coloured ? photicWeighted(at + 2u, stride, fraction) : vec4(v.w);
#else
    ivec3 texel;
    bool dense = PHOTIC_LAYOUT == 2;
    if (dense) {
        texel = cell - photic_dense_min.xyz;
    } else {
        uint entry = photicPage(cell);
        ivec3 brick = ivec3(entry & 255u, entry >> 8 & 255u, entry >> 16 & 255u);
        // Of the dark brick the top byte says something else, and all of it is dark. As BC6H it is not: of it no bias is
        // taken.
        if (blocks && brick == ivec3(0)) return light;
        texel = brick * (blocks ? ivec3(12, 12, 9) : ivec3(9)) + (brick == ivec3(0) ? ivec3(0) : photicInBrick(entry, cell, fraction));
    }
#ifdef PHOTIC_EXACT
    ivec3 next = texel + 1;
    // A dense texture ends where the light begins anew.
    if (PHOTIC_REPEATS != 0 && dense && photic_period.x != 0 && next.x == photic_period.x) next.x = 0;
    if (PHOTIC_REPEATS != 0 && dense && photic_period.y != 0 && next.y == photic_period.y) next.y = 0;
    if (PHOTIC_REPEATS != 0 && dense && photic_period.z != 0 && next.z == photic_period.z) next.z = 0;
    v = photicWeighted(photic_light, texel, next, fraction);
    colour = coloured || blocks ? photicWeighted(photic_rgb, texel, next, fraction) : vec4(v.w);
#else
    vec3 uvw = (vec3(texel) + fraction + 0.5) * photic_texel.xyz;
    v = textureLod(photic_light, uvw, 0.0);
    colour = coloured || blocks ? textureLod(photic_rgb, uvw, 0.0) : vec4(v.w);
#endif
    if (blocks) v = photicOfBlocks(v.xyz, colour);
#endif
    light.flux = v.xyz * photic_unit;
    light.mean = v.w * photic_unit;
    light.irradiance = colour.xyz * photic_unit;
    return light;
}

/// Light at a point [W/m2].
/// @param world  [m]
PhoticLight photicSample(vec3 world) { return photicSampleLocal(photicLocal(world)); }

#ifdef PHOTIC_MOVERS
#include "photic_movers.glsl"
#endif

/// What a surface gets: E_c = irradiance_c * max(0, -normal . flux) / mean [W/m2] per channel.
/// @param normal  world, away from the surface; need not be unit
vec3 photicIrradiance(vec3 world, vec3 normal) {
    PhoticLight light = photicSample(world);
    if (photic_directed == 0) return light.irradiance;
#ifdef PHOTIC_MOVERS
    light.irradiance *= photicPassesMovers(world, light.flux, light.mean);
#endif
    float towards = max(0.0, -dot(normal, light.flux)) * inversesqrt(max(dot(normal, normal), 1e-30));
    return light.mean > 0.0 ? light.irradiance * (towards / light.mean) : vec3(0.0);
}

/// How far it is dark for certain from a local position on, in multiples of `direction`; 0 where there may be light.
float photicEmptyLocal(vec3 local, vec3 direction) {
    ivec3 cell;
    vec3 fraction;
    if (!photicCell(local, cell, fraction)) return 0.0;
    uint entry = photicPage(cell);
    if ((entry & 0xffffffu) != 0u) return 0.0;
    int reach = int(entry >> 24);
    ivec3 page = cell >> 3;
    ivec3 first = (page - reach + 1) * 8, last = (page + reach) * 8;  // cells; `last` is outside
    // What lies beyond the last cell of a period is the first again.
    if (photic_period.x != 0) last.x = min(last.x, photic_cell_max.x + 1);
    if (photic_period.y != 0) last.y = min(last.y, photic_cell_max.y + 1);
    if (photic_period.z != 0) last.z = min(last.z, photic_cell_max.z + 1);
    vec3 here = vec3(cell) + fraction;
    vec3 room = vec3(direction.x > 0.0 ? float(last.x) - here.x : here.x - float(first.x),
                     direction.y > 0.0 ? float(last.y) - here.y : here.y - float(first.y),
                     direction.z > 0.0 ? float(last.z) - here.z : here.z - float(first.z));
    vec3 steps = room / max(abs(direction), vec3(1e-12));
    return max(0.0, min(steps.x, min(steps.y, steps.z)));
}

/// How far it is dark for certain from a point on along a unit direction [m]; 0 where there may be light.
float photicEmpty(vec3 world, vec3 direction) {
    return photicEmptyLocal(photicLocal(world), photicLocalDirection(direction));
}
