// SPDX-License-Identifier: Apache-2.0
// Objects whose index of refraction varies in space (GpuIndexVolumes of photic/bent_rays.h), and look-ups in them.
// Places are relative to photic_bent_origin, the camera as a rule, so that float has bits left near it.
#ifndef PHOTIC_BENT_BUFFER
#define PHOTIC_BENT_BUFFER 1        // a uniform buffer,
#define PHOTIC_BENT_FACES 5         // and six texture units
#define PHOTIC_BENT_GRADIENTS_AT 6
#define PHOTIC_BENT_SPLINE 7
#define PHOTIC_BENT_ATTENUATION 8
#define PHOTIC_BENT_GLOW 9
#define PHOTIC_BENT_BLOCKS 10
#endif
#ifndef PHOTIC_BENT_SHAPES_AT
#define PHOTIC_BENT_SHAPES_AT 12
#endif
// For Vulkan PHOTIC_BENT_SET is the descriptor set.
#ifdef PHOTIC_BENT_SET
#define PHOTIC_BENT_AT(number) set = PHOTIC_BENT_SET, binding = number
#else
#define PHOTIC_BENT_AT(number) binding = number
#endif
// PHOTIC_BENT_GRADIENTS: one filtered read of value and gradient instead of the spline.
// PHOTIC_BENT_SHAPES: objects may have shapes with sharp faces.

#define PHOTIC_BENT_MOST 16

struct PhoticBentObject {
    vec4 row_x;       // node = dot(row.xyz, place) + row.w
    vec4 row_y;
    vec4 row_z;
    vec4 box_low;     // xyz: in nodes; w: 1 with sharp sides
    vec4 box_high;    // w: g of Henyey and Greenstein
    vec4 scattering;  // [1/m]; w: least distance between nodes [m]
    vec4 coat;        // albedo of faces; w: alpha of highlights
    ivec4 count;      // nodes; w: 1 attenuates, 2 glows, 4 has faces, 8 has a coat of its own at each node
    ivec4 corner;     // first texel in the atlas; w: layers from a channel's spline to the next
    ivec4 block;      // first block; w: mask of the objects whose boxes overlap with this one's
};

layout(std140, PHOTIC_BENT_AT(PHOTIC_BENT_BUFFER)) uniform photic_bent_parameters {
    vec4 photic_bent_origin;   // [m]; w: 1 to show scattered light alone
    ivec4 photic_bent_counts;  // objects; most steps; most branches at a time; 1 to skip
    vec4 photic_bent_march;    // longest step [nodes]; largest turn a step [radians]; faintest branch; 1 for radiance without n^2
    vec4 photic_bent_texel;    // 1 / size of the textures
    // Irradiance over pi of the surroundings, by 1, y, z, x, xy, yz, 3 z^2 - 1, xz, x^2 - y^2 of the direction that a face
    // looks in; w of the first two: cosine and sine of the surroundings' turn about z.
    vec4 photic_bent_ambient[9];
    PhoticBentObject photic_bent_objects[PHOTIC_BENT_MOST];
    // Of each object its shape: first texel, or -1; rank; 1 where there are samples in it; mask of the objects with shapes
    // whose boxes overlap with the object's.
    ivec4 photic_bent_shapes[PHOTIC_BENT_MOST];
};

layout(PHOTIC_BENT_AT(PHOTIC_BENT_ATTENUATION)) uniform highp sampler3D photic_bent_attenuation;  // absorption [1/m], presence
layout(PHOTIC_BENT_AT(PHOTIC_BENT_GLOW)) uniform highp sampler3D photic_bent_glow;                // emission [W/(m3 sr)], g
layout(PHOTIC_BENT_AT(PHOTIC_BENT_FACES)) uniform highp sampler3D photic_bent_faces;  // a face; albedo
layout(PHOTIC_BENT_AT(PHOTIC_BENT_BLOCKS)) uniform highp usampler3D photic_bent_blocks;
#ifdef PHOTIC_BENT_GRADIENTS
layout(PHOTIC_BENT_AT(PHOTIC_BENT_GRADIENTS_AT)) uniform highp sampler3D photic_bent_gradients;  // slope per node; (n^2 - 1) / 2
#else
layout(PHOTIC_BENT_AT(PHOTIC_BENT_SPLINE)) uniform highp sampler2DArray photic_bent_spline;      // (n^2 - 1) / 2: coefficients
#endif

#ifdef PHOTIC_BENT_SHAPES
layout(PHOTIC_BENT_AT(PHOTIC_BENT_SHAPES_AT)) uniform highp usampler2D photic_bent_shape_texels;
/// (n^2 - 1) / 2 of the shape around a place that has no samples, 0 in air, and its absorption [1/m].
float photic_bent_base = 0.0;
vec3 photic_bent_base_absorption = vec3(0.0);
#else
#define photic_bent_base 0.0
#endif
/// Whether an object ends at faces of its own. Without PHOTIC_BENT_SHAPES those are not seen.
bool photicBentShaped(int object) { return photic_bent_shapes[object].x >= 0; }

struct PhoticRefraction {
    float excess;   ///< (n^2 - 1) / 2
    vec3 gradient;  ///< of it [1/m]
};

vec3 photicBentNode(int object, vec3 place) {
    return vec3(dot(photic_bent_objects[object].row_x.xyz, place) + photic_bent_objects[object].row_x.w,
                dot(photic_bent_objects[object].row_y.xyz, place) + photic_bent_objects[object].row_y.w,
                dot(photic_bent_objects[object].row_z.xyz, place) + photic_bent_objects[object].row_z.w);
}
/// The same of a direction or a velocity.
vec3 photicBentNodeVector(int object, vec3 v) {
    return vec3(dot(photic_bent_objects[object].row_x.xyz, v), dot(photic_bent_objects[object].row_y.xyz, v),
                dot(photic_bent_objects[object].row_z.xyz, v));
}
bool photicBentHolds(int object, vec3 node) {
    return all(greaterThanEqual(node, photic_bent_objects[object].box_low.xyz)) &&
           all(lessThanEqual(node, photic_bent_objects[object].box_high.xyz));
}

vec4 photicBentWeights(float t) {
    float u = 1.0 - t, t2 = t * t, u2 = u * u;
    return vec4(u2 * u, 4.0 - 6.0 * t2 + 3.0 * t2 * t, 4.0 - 6.0 * u2 + 3.0 * u2 * u, t2 * t) * (1.0 / 6.0);
}
vec4 photicBentSlopes(float t) {
    float u = 1.0 - t;
    return vec4(-u * u, (3.0 * t - 4.0) * t, (4.0 - 3.0 * u) * u, t * t) * 0.5;
}

#ifndef PHOTIC_BENT_GRADIENTS
/// One layer of 4 x 4 coefficients less `middle`: x: value, y, z: slopes along x and y.
vec3 photicBentLayer(vec3 at, vec4 wx, vec4 sx, vec4 wy, vec4 sy, float middle) {
    vec2 two = 2.0 * photic_bent_texel.xy;
    // Each read has four: (x, y + 1), (x + 1, y + 1), (x + 1, y), (x, y).
    vec4 a = textureGather(photic_bent_spline, at) - middle;
    vec4 b = textureGather(photic_bent_spline, vec3(at.x + two.x, at.y, at.z)) - middle;
    vec4 c = textureGather(photic_bent_spline, vec3(at.x, at.y + two.y, at.z)) - middle;
    vec4 d = textureGather(photic_bent_spline, vec3(at.xy + two, at.z)) - middle;
    vec4 r0 = vec4(a.w, a.z, b.w, b.z), r1 = vec4(a.x, a.y, b.x, b.y);
    vec4 r2 = vec4(c.w, c.z, d.w, d.z), r3 = vec4(c.x, c.y, d.x, d.y);
    vec4 value = vec4(dot(wx, r0), dot(wx, r1), dot(wx, r2), dot(wx, r3));
    vec4 slope = vec4(dot(sx, r0), dot(sx, r1), dot(sx, r2), dot(sx, r3));
    return vec3(dot(wy, value), dot(wy, slope), dot(sy, value));
}
#endif

/// (n^2 - 1) / 2 and its slopes per node. Where all coefficients around are one value, slopes are 0 to the last bit.
vec4 photicBentSplineAt(int object, vec3 node, int channel) {
    ivec3 corner = photic_bent_objects[object].corner.xyz;
    vec3 inside = clamp(node, vec3(1.0), vec3(photic_bent_objects[object].count.xyz) - 2.0);
#ifdef PHOTIC_BENT_GRADIENTS
    return textureLod(photic_bent_gradients, (vec3(corner) + inside + 0.5) * photic_bent_texel.xyz, 0.0);
#else
    ivec3 cell = min(ivec3(inside), photic_bent_objects[object].count.xyz - 3);
    vec3 t = inside - vec3(cell);
    vec4 wx = photicBentWeights(t.x), sx = photicBentSlopes(t.x), wy = photicBentWeights(t.y), sy = photicBentSlopes(t.y);
    vec4 wz = photicBentWeights(t.z), sz = photicBentSlopes(t.z);
    int layer = corner.z + channel * photic_bent_objects[object].corner.w + cell.z - 1;
    float middle = texelFetch(photic_bent_spline, ivec3(corner.xy + cell.xy, layer + 1), 0).r;
    // The corner between four texels: the gather's choice of them doesn't hang on rounding.
    vec3 at = vec3(vec2(corner.xy + cell.xy) * photic_bent_texel.xy, float(layer));
    vec3 l0 = photicBentLayer(at, wx, sx, wy, sy, middle);
    vec3 l1 = photicBentLayer(vec3(at.xy, at.z + 1.0), wx, sx, wy, sy, middle);
    vec3 l2 = photicBentLayer(vec3(at.xy, at.z + 2.0), wx, sx, wy, sy, middle);
    vec3 l3 = photicBentLayer(vec3(at.xy, at.z + 3.0), wx, sx, wy, sy, middle);
    vec4 value = vec4(l0.x, l1.x, l2.x, l3.x);
    return vec4(dot(wz, vec4(l0.y, l1.y, l2.y, l3.y)), dot(wz, vec4(l0.z, l1.z, l2.z, l3.z)), dot(sz, value),
                middle + dot(wz, value));
#endif
}

#ifdef PHOTIC_BENT_COUNTS
/// Look-ups of the index: where it bends nothing, where it does, along a ray for a face, and at one.
ivec4 photic_bent_looks;
/// @param face  0: along a ray for a face; more: at one
void photicBentCount(int face, PhoticRefraction here) {
    ++photic_bent_looks[face >= 0 ? 2 + min(face, 1) : here.gradient != vec3(0.0) ? 1 : 0];
}
#endif

/// One object's index at a place in its box.
PhoticRefraction photicBentOne(int object, vec3 node, int channel) {
    vec4 v = photicBentSplineAt(object, node, channel);
    return PhoticRefraction(v.w, photic_bent_objects[object].row_x.xyz * v.x + photic_bent_objects[object].row_y.xyz * v.y +
                                     photic_bent_objects[object].row_z.xyz * v.z);
}

/// That of an object and of those whose boxes overlap with its: they add up.
PhoticRefraction photicBentAt(int object, vec3 place, int channel) {
    PhoticRefraction sum = PhoticRefraction(photic_bent_base, vec3(0.0));
    int others = photic_bent_objects[object].block.w;
    // Itself first. One look-up in the text: compilers copy it to wherever it is called.
    for (int i = -1; i < photic_bent_counts.x; ++i) {
        int one = i < 0 ? object : i;
        vec3 node = photicBentNode(one, place);
        if (i < 0 || ((others >> i & 1) != 0 && photicBentHolds(one, node))) {
            PhoticRefraction here = photicBentOne(one, node, channel);
            sum.excess += here.excess;
            sum.gradient += here.gradient;
        }
        if (others == 0) break;
    }
    return sum;
}

/// How many blocks around a place are all alike, in index and attenuation: 0, or the reach, of which 1 is its own block.
int photicBentReach(int object, vec3 node) {
    ivec3 block = ivec3(clamp(node, vec3(0.0), vec3(photic_bent_objects[object].count.xyz - 1))) >> 1;
    return int(texelFetch(photic_bent_blocks, photic_bent_objects[object].block.xyz + block, 0).r);
}

/// What a place does to light beside bending it.
struct PhoticBentMedium {
    vec3 absorption;  ///< [1/m]
    vec3 scattering;  ///< [1/m]
    vec3 emission;    ///< [W/(m3 sr)]
    float anisotropy;
};
PhoticBentMedium photicBentMedium(int object, vec3 node) {
    int flags = photic_bent_objects[object].count.w;
    PhoticBentMedium m = PhoticBentMedium(vec3(0.0), vec3(0.0), vec3(0.0), photic_bent_objects[object].box_high.w);
    if ((flags & 3) == 0) return m;
    vec3 inside = clamp(node, vec3(0.0), vec3(photic_bent_objects[object].count.xyz) - 1.0);
    vec3 uvw = (vec3(photic_bent_objects[object].corner.xyz) + inside + 0.5) * photic_bent_texel.xyz;
    if ((flags & 1) != 0) {
        vec4 v = textureLod(photic_bent_attenuation, uvw, 0.0);
        m.absorption = v.rgb;
        m.scattering = v.a * photic_bent_objects[object].scattering.rgb;
    }
    if ((flags & 2) != 0) {
        vec4 v = textureLod(photic_bent_glow, uvw, 0.0);
        m.emission = v.rgb;
        m.anisotropy = v.a;
    }
    return m;
}

/// Around a face, x is more than 1/2; yzw: its albedo, where that differs from place to place.
vec4 photicBentFaceTexel(int object, vec3 node) {
    vec3 inside = clamp(node, vec3(0.0), vec3(photic_bent_objects[object].count.xyz) - 1.0);
    return textureLod(photic_bent_faces, (vec3(photic_bent_objects[object].corner.xyz) + inside + 0.5) * photic_bent_texel.xyz,
                      0.0);
}
bool photicBentFace(int object, vec3 node) {
    return (photic_bent_objects[object].count.w & 4) != 0 && photicBentFaceTexel(object, node).r > 0.5;
}

/// How a face there sends light back besides Fresnel's mirror: rgb: albedo; w: alpha of highlights.
vec4 photicBentCoat(int object, vec3 node) {
    vec4 coat = photic_bent_objects[object].coat;
    if ((photic_bent_objects[object].count.w & 8) != 0) coat.rgb = photicBentFaceTexel(object, node).yzw;
    return coat;
}
/// Irradiance over pi that a face which looks along `normal` has of the surroundings.
vec3 photicBentAmbient(vec3 normal) {
    vec2 turn = vec2(photic_bent_ambient[0].w, photic_bent_ambient[1].w);
    float x = turn.x * normal.x + turn.y * normal.y, y = turn.x * normal.y - turn.y * normal.x, z = normal.z;
    vec3 sum = photic_bent_ambient[0].rgb + y * photic_bent_ambient[1].rgb + z * photic_bent_ambient[2].rgb +
               x * photic_bent_ambient[3].rgb + (x * y) * photic_bent_ambient[4].rgb + (y * z) * photic_bent_ambient[5].rgb +
               (3.0 * z * z - 1.0) * photic_bent_ambient[6].rgb + (x * z) * photic_bent_ambient[7].rgb +
               (x * x - y * y) * photic_bent_ambient[8].rgb;
    return max(sum, vec3(0.0));
}

/// Distances along a straight ray at which it is in an object's box: y < x where it misses. In multiples of `direction`.
vec2 photicBentBox(int object, vec3 place, vec3 direction) {
    vec3 node = photicBentNode(object, place), way = photicBentNodeVector(object, direction);
    vec3 inverse = 1.0 / mix(way, vec3(1e-12), lessThan(abs(way), vec3(1e-12)));
    vec3 a = (photic_bent_objects[object].box_low.xyz - node) * inverse;
    vec3 b = (photic_bent_objects[object].box_high.xyz - node) * inverse;
    vec3 near = min(a, b), far = max(a, b);
    return vec2(max(near.x, max(near.y, near.z)), min(far.x, min(far.y, far.z)));
}

/// An object without a shape that holds a place; -1: none.
int photicBentFind(vec3 place) {
    for (int i = 0; i < photic_bent_counts.x; ++i) {
        if (!photicBentShaped(i) && photicBentHolds(i, photicBentNode(i, place))) return i;
    }
    return -1;
}
