// SPDX-License-Identifier: Apache-2.0
// Shadows of what moves through baked light (photic/movers.h, whose CPU code does the same in double). From a place the
// way of its light is followed back, as a narrow cone; what part of the cone a mover covers is the part of the light that
// it takes. Both shapes are exact for one cone; movers that cover each other multiply.
// Included by photic_volume.glsl where PHOTIC_MOVERS is defined.
#ifndef PHOTIC_BINDING_MOVERS
#define PHOTIC_BINDING_MOVERS 1     // a uniform buffer,
#define PHOTIC_BINDING_MOVER_MAP 3  // and a texture unit
#endif

#ifndef PHOTIC_AT
#define PHOTIC_AT(number) binding = number
#endif

layout(std140, PHOTIC_AT(PHOTIC_BINDING_MOVERS)) uniform photic_movers {
    vec4 photic_mover_surface;  // the light is bent where dot(xyz, world) = w, and comes from above it
    vec4 photic_mover_sun;      // xyz: its direction of travel there, unit; w: 0 when nothing up there darkens
    vec4 photic_mover_cone;     // tangents of the sun's half angle below and above; part of the light's own spread; reach [m]
    ivec4 photic_mover_count;   // shapes; steps of the march through the map, 0: there is none; rays of a cone
    vec4 photic_mover_map_u;    // where a place lies on the map, 0 to 1: dot(xyz, world) + w
    vec4 photic_mover_map_v;
    vec4 photic_mover_map_d;    // and how far along the light [m]
    vec4 photic_mover_range;    // least and largest depth on the map [m]; z: the least distance that a mover darkens at [m]
    vec4 photic_mover_shapes[128];  // four each: centre, radius of a sphere around it; half axes of a box, w: 1 for a box
};
layout(PHOTIC_AT(PHOTIC_BINDING_MOVER_MAP)) uniform highp sampler2D photic_mover_map;  // -nearest, farthest depth [m]

#ifndef PHOTIC_CONE
#define PHOTIC_CONE
/// A cone of directions back along light: a place that is `apex + z * axis + z * tangent * (two numbers within the unit
/// disc, along u and v)` is on the way of the light, for z from `near` to `far`.
struct PhoticCone {
    vec3 apex, axis, u, v;
    float tangent, near, far;
};
#endif

PhoticCone photicCone(vec3 apex, vec3 axis, float tangent, float near, float far) {
    // Duff et al. 2017, Building an Orthonormal Basis, Revisited.
    float s = axis.z < 0.0 ? -1.0 : 1.0, a = -1.0 / (s + axis.z), b = axis.x * axis.y * a;
    return PhoticCone(apex, axis, vec3(1.0 + s * axis.x * axis.x * a, s * b, -s * axis.x),
                      vec3(b, s + axis.y * axis.y * a, -axis.y), tangent, near, far);
}

/// Part of the unit disc that a disc of radius `radius` covers whose centre is `apart` away.
float photicDiscsOverlap(float radius, float apart) {
    if (apart >= 1.0 + radius) return 0.0;
    if (apart <= abs(radius - 1.0)) return radius >= 1.0 ? 1.0 : radius * radius;
    if (radius > 50.0) {
        // Where one circle is nearly straight the two areas would cancel.
        float s = clamp(radius - apart, -1.0, 1.0);
        return 0.5 + (s * sqrt(1.0 - s * s) + asin(s)) * 0.31830988618;
    }
    float square = apart * apart, r2 = radius * radius;
    float alpha = acos(clamp((square + 1.0 - r2) / (2.0 * apart), -1.0, 1.0));
    float beta = acos(clamp((square + r2 - 1.0) / (2.0 * apart * radius), -1.0, 1.0));
    float kite = 0.5 * sqrt(max(0.0, (1.0 + radius - apart) * (apart + 1.0 - radius) * (apart - 1.0 + radius) * (apart + 1.0 + radius)));
    return clamp((alpha + r2 * beta - kite) * 0.31830988618, 0.0, 1.0);
}

float photicCross(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

float photicAngle(vec2 a, vec2 b) {
    vec2 p = vec2(dot(a, b), photicCross(a, b));
    return p == vec2(0.0) ? 0.0 : atan(p.y, p.x);
}

/// Twice the area that the unit disc shares with the triangle of its centre, a and b; signed.
float photicDiscTriangle(vec2 a, vec2 b) {
    vec2 d = b - a;
    float length2 = dot(d, d), across = photicCross(a, b), inside = length2 - across * across;
    if (inside <= 0.0) return photicAngle(a, b);
    float middle = -dot(a, d), s = sqrt(inside);
    vec2 p = a + clamp((middle - s) / length2, 0.0, 1.0) * d, q = a + clamp((middle + s) / length2, 0.0, 1.0) * d;
    return photicAngle(a, p) + photicAngle(q, b) + photicCross(p, q);
}

/// The same of a quadrangle's outline, in a cone's frame, as far as it lies beyond z = near.
float photicDiscQuad(vec3 c0, vec3 c1, vec3 c2, vec3 c3, float near, float tangent) {
    float sum = 0.0;
    vec2 leaves = vec2(0.0), enters = vec2(0.0);
    bool cut = false;
    for (int i = 0; i < 4; ++i) {
        vec3 p = i == 0 ? c0 : i == 1 ? c1 : i == 2 ? c2 : c3, q = i == 0 ? c1 : i == 1 ? c2 : i == 2 ? c3 : c0;
        bool from = p.z >= near, to = q.z >= near;
        if (!from && !to) continue;
        vec2 border = vec2(0.0);
        if (from != to) {
            vec3 at = mix(p, q, (near - p.z) / (q.z - p.z));
            border = at.xy / (near * tangent);
            cut = true;
        }
        vec2 a = from ? p.xy / (p.z * tangent) : border, b = to ? q.xy / (q.z * tangent) : border;
        if (from && !to) leaves = border;
        if (!from && to) enters = border;
        sum += photicDiscTriangle(a, b);
    }
    return cut ? sum + photicDiscTriangle(leaves, enters) : sum;
}

/// Part of a cone that a box covers: where rays leave it behind `near`, without where they enter it behind `far`.
float photicBoxCovers(PhoticCone cone, vec3 centre, vec3 half_x, vec3 half_y, vec3 half_z) {
    mat3 frame = transpose(mat3(cone.u, cone.v, cone.axis));
    vec3 c = frame * (centre - cone.apex);
    vec3 axes[3];
    axes[0] = frame * half_x, axes[1] = frame * half_y, axes[2] = frame * half_z;
    float left = 0.0, entered = 0.0;
    for (int n = 0; n < 6; ++n) {
        vec3 out_by = n < 2 ? axes[0] : n < 4 ? axes[1] : axes[2];
        vec3 a = n < 2 ? axes[1] : n < 4 ? axes[2] : axes[0], b = n < 2 ? axes[2] : n < 4 ? axes[0] : axes[1];
        if ((n & 1) != 0) out_by = -out_by, a = -a;
        vec3 middle = c + out_by;
        vec3 normal = cross(a, b);
        if (dot(normal, out_by) < 0.0) normal = -normal;
        bool faces = dot(normal, middle) < 0.0;
        float part = photicDiscQuad(middle - a - b, middle + a - b, middle + a + b, middle - a + b,
                                    faces ? cone.far : cone.near, cone.tangent);
        if (faces) entered += part;
        else left += part;
    }
    return clamp((abs(left) - abs(entered)) * 0.15915494309, 0.0, 1.0);
}

/// Whether a place at `from` its middle is on a mover's own skin, where it faces the light. What a game draws is not the
/// exact shape: a mover darkens no such place, however deep in the skin it lies.
bool photicOnLitSkin(vec3 from, vec3 back, float radius, int n) {
    vec4 half_x = photic_mover_shapes[4 * n + 1];
    float out_by = length(from) / max(radius, 1e-9), faces = dot(from, back);
    if (half_x.w != 0.0) {
        vec3 half_y = photic_mover_shapes[4 * n + 2].xyz, half_z = photic_mover_shapes[4 * n + 3].xyz;
        vec3 at = vec3(dot(from, half_x.xyz) / dot(half_x.xyz, half_x.xyz), dot(from, half_y) / dot(half_y, half_y),
                       dot(from, half_z) / dot(half_z, half_z));
        vec3 size = abs(at);
        out_by = max(size.x, max(size.y, size.z));
        vec3 side = size.x == out_by ? at.x * half_x.xyz : size.y == out_by ? at.y * half_y : at.z * half_z;
        faces = dot(side, back);
    }
    return out_by > 0.9 && out_by < 1.02 && faces > 0.0;
}

/// Part of a cone that shape `n` covers.
float photicShapeCovers(PhoticCone cone, int n) {
    vec4 round = photic_mover_shapes[4 * n];
    vec3 to = round.xyz - cone.apex;
    float z = dot(to, cone.axis), radius = round.w;
    if (photicOnLitSkin(-to, cone.axis, radius, n)) return 0.0;
    if (z + radius <= cone.near || z - radius >= cone.far) return 0.0;
    float apart = length(to - z * cone.axis);
    if (apart > (radius + max(0.0, z + radius) * cone.tangent) * (1.0 + cone.tangent)) return 0.0;
    vec4 half_x = photic_mover_shapes[4 * n + 1];
    if (half_x.w != 0.0)
        return photicBoxCovers(cone, round.xyz, half_x.xyz, photic_mover_shapes[4 * n + 2].xyz, photic_mover_shapes[4 * n + 3].xyz);
    // The widest cut of the sphere between the cone's ends.
    float at = clamp(z, cone.near, cone.far), wide = at * cone.tangent;
    return photicDiscsOverlap(sqrt(max(0.0, radius * radius - (z - at) * (z - at))) / wide, apart / wide);
}

/// Part of a cone that what is drawn on the map covers: some rays, each marched through the map's box.
float photicMapCovers(PhoticCone cone) {
    float covered = 0.0;
    for (int ray = 0; ray < photic_mover_count.z; ++ray) {
        // Evenly over the disc, by the golden angle (Vogel 1979).
        float turn = 2.399963 * float(ray);
        vec2 at = sqrt((float(ray) + 0.5) / float(photic_mover_count.z)) * vec2(cos(turn), sin(turn));
        vec3 way = cone.axis + cone.tangent * (at.x * cone.u + at.y * cone.v);
        vec3 start = vec3(dot(photic_mover_map_u.xyz, cone.apex) + photic_mover_map_u.w,
                          dot(photic_mover_map_v.xyz, cone.apex) + photic_mover_map_v.w,
                          dot(photic_mover_map_d.xyz, cone.apex) + photic_mover_map_d.w);
        vec3 rate = vec3(dot(photic_mover_map_u.xyz, way), dot(photic_mover_map_v.xyz, way), dot(photic_mover_map_d.xyz, way));
        vec3 safe = mix(rate, vec3(1e-9), lessThan(abs(rate), vec3(1e-9)));
        vec3 one = (vec3(0.0, 0.0, photic_mover_range.x) - start) / safe, other = (vec3(1.0, 1.0, photic_mover_range.y) - start) / safe;
        vec3 first = min(one, other), last = max(one, other);
        float begin = max(cone.near, max(first.x, max(first.y, first.z)));
        float end = min(cone.far, min(last.x, min(last.y, last.z)));
        if (!(end > begin)) continue;
        float step_length = (end - begin) / float(photic_mover_count.y);
        for (int i = 0; i < photic_mover_count.y; ++i) {
            float z = begin + float(i) * step_length;
            float d0 = start.z + z * rate.z, d1 = d0 + step_length * rate.z;
            vec2 uv = start.xy + (z + 0.5 * step_length) * rate.xy;
            ivec2 size = textureSize(photic_mover_map, 0);
            vec2 between = texelFetch(photic_mover_map, clamp(ivec2(uv * vec2(size)), ivec2(0), size - 1), 0).rg;
            if (max(d0, d1) >= -between.x && min(d0, d1) <= between.y) {
                covered += 1.0;
                break;
            }
        }
    }
    return covered / float(max(1, photic_mover_count.z));
}

/// Part of a cone's light that passes all movers.
float photicConePasses(PhoticCone cone) {
    if (!(cone.far > cone.near)) return 1.0;
    float passes = 1.0;
    for (int n = 0; n < photic_mover_count.x; ++n) passes *= 1.0 - photicShapeCovers(cone, n);
    if (photic_mover_count.y > 0 && passes > 0.0) passes *= 1.0 - photicMapCovers(cone);
    return passes;
}

/// Part of the light at a place that passes all movers on its way there.
/// @param flux  at the place, along the light's travel, any unit
/// @param mean  irradiance there, in the same unit
float photicPassesMovers(vec3 world, vec3 flux, float mean) {
    float size = length(flux);
    if (!(size > 0.0)) return 1.0;
    vec3 back = -flux / size;
    // |flux| / mean is the mean cosine, (1 + cos) / 2 of a cone's half angle; halves round it by a thousandth.
    float cosine = clamp(2.0 * (size / max(mean, size) + 0.001) - 1.0, 0.7, 1.0);
    float tangent = max(photic_mover_cone.x, photic_mover_cone.z * sqrt(1.0 - cosine * cosine) / cosine);
    float reach = photic_mover_cone.w, near = photic_mover_range.z;
    float below = photic_mover_surface.w - dot(photic_mover_surface.xyz, world);
    float rate = dot(photic_mover_surface.xyz, back);
    float surface = below >= 0.0 && rate > 0.0 ? below / rate : reach;
    float passes = photicConePasses(photicCone(world, back, tangent, near, min(surface, reach)));
    if (photic_mover_sun.w == 0.0 || !(surface < reach) || !(passes > 0.0)) return passes;
    // Above the surface all light is the sun's: a cone as wide there as the one below is, from an apex of its own.
    float wide = max(surface * tangent, 1e-4), air = photic_mover_cone.y, height = wide / air;
    return passes * photicConePasses(photicCone(world + surface * back + height * photic_mover_sun.xyz, -photic_mover_sun.xyz, air,
                                                height, height + reach - surface));
}
