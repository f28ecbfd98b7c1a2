// SPDX-License-Identifier: Apache-2.0
// Where a ray meets the sharp faces of shapes, of photic_bent_trace.glsl with PHOTIC_BENT_SHAPES: triangles in a tree of
// boxes, and balls. docs/index_volumes.md has the texels.
//
// A ray knows which shapes it is in. Of those it looks for faces from behind, of all others from the front, so that the
// face that it comes from is not met again, and none of a body needs a distance to be kept from it.

#define PHOTIC_BENT_CLEAR 1  // what faces do, beside Fresnel's glass: refract all light,
#define PHOTIC_BENT_MIRROR 2
#define PHOTIC_BENT_THIN 3   // a pane
#define PHOTIC_BENT_BALL 2   // a kind of shape, beside smooth meshes and flat ones

struct PhoticBentHit {
    float along;   // from the ray's start, in multiples of its momentum
    int object;    // -1: none
    int triangle;  // by its place in the tree's order
    vec2 at;       // of the triangle: weights of its second and third corner
    bool back;     // from behind
};
PhoticBentHit photic_bent_hit;
float photic_bent_seen;  // how far the ray was searched for faces
int photic_bent_channel;
int photic_bent_asked;   // bits of the shapes of which it isn't known yet whether the eye is in them
// Mirrors and panes are met from both sides, but not where the ray comes from [nodes].
#define PHOTIC_BENT_BESIDE 1e-3

int photicBentFaces(int object) { return photic_bent_shapes[object].z >> 4 & 15; }
int photicBentKind(int object) { return photic_bent_shapes[object].z >> 8 & 15; }

uvec4 photicBentTexel(int place) { return texelFetch(photic_bent_shape_texels, ivec2(place & 2047, place >> 11), 0); }
vec3 photicBentVector(int place) { return uintBitsToFloat(photicBentTexel(place).xyz); }

/// Where a ray enters a box, 1e30 where it misses it.
float photicBentEnters(vec3 low, vec3 high, vec3 from, vec3 inverse, float least, float most) {
    vec3 a = (low - from) * inverse, b = (high - from) * inverse;
    vec3 near = min(a, b), far = max(a, b);
    float enters = max(max(near.x, near.y), max(near.z, least)), leaves = min(min(far.x, far.y), min(far.z, most));
    // A hair more: what rounding takes off would be a gap between triangles.
    return enters <= leaves + 2e-6 * abs(leaves) ? enters : 1e30;
}

/// One triangle (Moeller and Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997).
/// @param side  1: from the front alone, -1: from behind, 0: both
void photicBentTriangle(int object, int triangle, int corners, vec3 from, vec3 way, float least, int side) {
    vec3 a = photicBentVector(corners + 3 * triangle);
    vec3 e1 = photicBentVector(corners + 3 * triangle + 1) - a, e2 = photicBentVector(corners + 3 * triangle + 2) - a;
    vec3 p = cross(way, e2), s = from - a, q = cross(s, e1);
    float volume = dot(e1, p);
    if (volume == 0.0 || float(side) * volume < 0.0) return;
    vec3 found = vec3(dot(s, p), dot(way, q), dot(e2, q)) / volume;
    // Neighbours overlap by more than rounding, so that no ray goes between them.
    const float kHair = 2e-6;
    if (found.x < -kHair || found.y < -kHair || found.x + found.y > 1.0 + kHair) return;
    if (found.z <= least || found.z >= photic_bent_hit.along) return;
    if (side == 0 && found.z * length(way) < PHOTIC_BENT_BESIDE) return;
    photic_bent_hit = PhoticBentHit(found.z, object, triangle, found.xy, volume < 0.0);
}

void photicBentMesh(int object, vec3 from, vec3 way, float least, int side) {
    ivec4 parts = ivec4(photicBentTexel(photic_bent_shapes[object].x + 3));
    vec3 inverse = 1.0 / mix(way, vec3(1e-12), lessThan(abs(way), vec3(1e-12)));
    int waiting[32], depth = 0, node = parts.x;
    for (int i = 0; i < 1000000; ++i) {
        int next = -1, later = -1;
        bool leaf = node < 0;
        if (leaf) {
            int first = ~node >> 3, count = ~node & 7;
            for (int k = 0; k < count; ++k) photicBentTriangle(object, first + k, parts.y, from, way, least, side);
        } else {
            uvec4 left = photicBentTexel(node), right = photicBentTexel(node + 2);
            float most = photic_bent_hit.along;
            float l = photicBentEnters(uintBitsToFloat(left.xyz), photicBentVector(node + 1), from, inverse, least, most);
            float r = photicBentEnters(uintBitsToFloat(right.xyz), photicBentVector(node + 3), from, inverse, least, most);
            if (min(l, r) < 1e30) {
                // The nearer one first: what it has may hide the other.
                node = l <= r ? int(left.w) : int(right.w);
                if (max(l, r) < 1e30) waiting[depth++] = l <= r ? int(right.w) : int(left.w);
                continue;
            }
        }
        if (depth == 0) return;
        node = waiting[--depth];
    }
}

void photicBentBall(int object, vec3 from, vec3 way, float least, int side) {
    vec4 ball = uintBitsToFloat(photicBentTexel(photic_bent_shapes[object].x + 3));
    vec3 o = from - ball.xyz;
    float length2 = dot(way, way), middle = -dot(o, way) / length2;
    vec3 nearest = o + middle * way;
    float half2 = (ball.w * ball.w - dot(nearest, nearest)) / length2;
    if (half2 <= 0.0) return;
    float reach = sqrt(half2), enters = middle - reach, leaves = middle + reach;
    bool back = side < 0 || (side == 0 && enters <= least);
    float along = back ? leaves : enters;
    if (along <= least || along >= photic_bent_hit.along) return;
    if (side == 0 && along * sqrt(length2) < PHOTIC_BENT_BESIDE) return;
    photic_bent_hit = PhoticBentHit(along, object, 0, vec2(0.0), back);
}

/// The nearest face of some objects' shapes, as photic_bent_hit.
/// @param others  their bits
/// @param inside  bits of those that the ray is in; -1: it isn't known
void photicBentNearest(vec3 place, vec3 way, float least, float most, int others, int inside) {
    photic_bent_hit = PhoticBentHit(most, -1, -1, vec2(0.0), false);
    photic_bent_seen = most;
    for (int i = 0; i < photic_bent_counts.x; ++i) {
        if ((others >> i & 1) == 0 || !photicBentShaped(i)) continue;
        vec2 box = photicBentBox(i, place, way);
        float hair = 1e-5 * max(abs(box.x), abs(box.y));
        if (box.y + hair < max(box.x, least) || box.x > photic_bent_hit.along) continue;
        int side = inside == -1 || photicBentFaces(i) >= PHOTIC_BENT_MIRROR ? 0 : (inside >> i & 1) != 0 ? -1 : 1;
        vec3 node = photicBentNode(i, place), node_way = photicBentNodeVector(i, way);
        if (photicBentKind(i) == PHOTIC_BENT_BALL)
            photicBentBall(i, node, node_way, least, side);
        else
            photicBentMesh(i, node, node_way, least, side);
    }
}

/// Bits of the shapes in whose boxes a place is.
int photicBentBoxesAround(vec3 place) {
    int around = 0;
    for (int i = 0; i < photic_bent_counts.x; ++i) {
        if (photicBentShaped(i) && photicBentFaces(i) < PHOTIC_BENT_MIRROR && photicBentHolds(i, photicBentNode(i, place)))
            around |= 1 << i;
    }
    return around;
}

/// The ray is in these shapes now: that of the highest rank is what is there.
void photicBentInto(int inside) {
    photic_bent_inside = inside;
    photic_bent_body = -1;
    for (int i = 0; i < photic_bent_counts.x; ++i) {
        if ((inside >> i & 1) == 0) continue;
        if (photic_bent_body < 0 || photic_bent_shapes[i].y >= photic_bent_shapes[photic_bent_body].y) photic_bent_body = i;
    }
    photic_bent_base = 0.0;
    photic_bent_base_absorption = vec3(0.0);
    if (photic_bent_body < 0 || (photic_bent_shapes[photic_bent_body].z & 1) != 0) return;
    int first = photic_bent_shapes[photic_bent_body].x;
    photic_bent_base = photicBentVector(first)[photic_bent_channel];
    photic_bent_base_absorption = photicBentVector(first + 1);
}

/// The object whose samples a ray at a place is stepped through; -1: none.
int photicBentSamples(vec3 place) {
    if (photic_bent_body >= 0 && (photic_bent_shapes[photic_bent_body].z & 1) != 0) return photic_bent_body;
    return photicBentFind(place);
}

/// The ray's start has moved along it.
void photicBentMoveHit(float along) {
    photic_bent_hit.along -= along;
    photic_bent_seen -= along;
}

/// How far it is to the next face, or to where none was looked for, in multiples of the ray's momentum.
float photicBentRoom() {
    float to = photic_bent_hit.object >= 0 ? photic_bent_hit.along : photic_bent_seen;
    return to - photic_bent_ray.count * photic_bent_ray.step;
}

/// Looks for the next face, where a step needs to know; of the eye's ray first for that of each shape that may be around.
void photicBentSearch() {
    int object = photic_bent_ray.object, others = -1, inside = photic_bent_inside;
    float least = 0.0, most = 1e30;
    if (object == -2) return;
    if (photic_bent_ray.look == PHOTIC_BENT_BORN) {
        if (photic_bent_asked == 0) return;
        others = photic_bent_asked & -photic_bent_asked;
        inside = -1;
    } else if (object >= 0) {
        others = photic_bent_shapes[object].w;
        bool seeks = photic_bent_ray.look == PHOTIC_BENT_SEEK && photic_bent_face.before == 1e30;
        if (photic_bent_ray.look != PHOTIC_BENT_STEP && !seeks) return;
        float node = 1.0 / length(photicBentNodeVector(object, photic_bent_ray.momentum));
        float steps = photic_bent_ray.count + 1.5;
        if (photic_bent_ray.count > 0.0 && !seeks &&
            (photic_bent_hit.object >= 0 || photic_bent_seen >= steps * photic_bent_ray.step))
            return;
        // Where it bends it is another ray after a step; between looks it goes straight on.
        least = -photic_bent_back;
        if (seeks) most = 26.0 * node;
        else if (photic_bent_ray.force != vec3(0.0)) most = (steps + 1.0) * max(photic_bent_march.x * node, photic_bent_ray.step);
    }
    photicBentNearest(photic_bent_ray.start, photic_bent_ray.momentum, least, most, others, inside);
}

/// Of the eye's ray: it is in a shape whose next face is seen from behind. When all are known, it begins.
void photicBentBorn() {
    if (photic_bent_asked != 0) {
        if (photic_bent_hit.object >= 0 && photic_bent_hit.back) photic_bent_inside |= 1 << photic_bent_hit.object;
        photic_bent_asked &= photic_bent_asked - 1;
        return;
    }
    photicBentInto(photic_bent_inside);
    vec3 place = photic_bent_ray.start;
    int object = photicBentSamples(place);
    photicBentBegin(place, photic_bent_ray.momentum, photic_bent_ray.weight, object);
    if (object >= 0) photic_bent_ray.look = PHOTIC_BENT_START;
    else if (photic_bent_march.w == 0.0) photic_bent_ray.weight *= 1.0 + 2.0 * photic_bent_base;
}
