// SPDX-License-Identifier: Apache-2.0
// What a sharp face of a shape does to a ray, of photic_bent_trace.glsl with PHOTIC_BENT_SHAPES.

/// A face that the ray is at.
struct PhoticBentCrossing {
    int object;
    vec3 normal, face;  // unit, to where the ray goes: that of light, interpolated, and that of the triangle itself
    int before;         // bits of the shapes that the ray was in
    float square;       // n^2 behind it
};
PhoticBentCrossing photic_bent_crossing;

vec3 photicBentWorldNormal(int object, vec3 covector) {
    return normalize(photic_bent_objects[object].row_x.xyz * covector.x + photic_bent_objects[object].row_y.xyz * covector.y +
                     photic_bent_objects[object].row_z.xyz * covector.z);
}

/// Normals at a face that was found: outwards.
void photicBentNormals(vec3 place, out vec3 normal, out vec3 face) {
    int object = photic_bent_hit.object, first = photic_bent_shapes[object].x, kind = photicBentKind(object);
    if (kind == PHOTIC_BENT_BALL) {
        normal = face = photicBentWorldNormal(object, photicBentNode(object, place) - photicBentVector(first + 3));
        return;
    }
    ivec4 parts = ivec4(photicBentTexel(first + 3));
    int corner = parts.y + 3 * photic_bent_hit.triangle;
    vec3 a = photicBentVector(corner);
    normal = face = photicBentWorldNormal(object, cross(photicBentVector(corner + 1) - a, photicBentVector(corner + 2) - a));
    if (kind != 0) return;
    corner = parts.z + 3 * photic_bent_hit.triangle;
    vec2 at = photic_bent_hit.at;
    normal = photicBentWorldNormal(object, photicBentVector(corner) * (1.0 - at.x - at.y) + photicBentVector(corner + 1) * at.x +
                                               photicBentVector(corner + 2) * at.y);
}

/// Refracts and reflects the ray at photic_bent_crossing. It is at the face, and in what is behind it already.
void photicBentCrossShape() {
    float square = photic_bent_crossing.square;
    vec3 place = photic_bent_ray.start, p = photic_bent_ray.momentum, face = photic_bent_crossing.face;
    vec3 normal = photic_bent_crossing.normal, along, mirrored, onward;
    float a, b2;
    for (int i = 0; i < 2; ++i) {
        a = dot(p, normal);
        along = p - a * normal;
        mirrored = along - a * normal;
        b2 = square - dot(along, along);
        onward = along + sqrt(max(b2, 0.0)) * normal;
        // Where an interpolated normal would send light through the face that it is reflected by, or back from one that
        // it goes through, the face's own is taken.
        if (dot(mirrored, face) < 0.0 && (b2 <= 0.0 || dot(onward, face) > 0.0)) break;
        normal = face;
    }
    int object = photic_bent_crossing.object, after = photic_bent_inside, beyond = photic_bent_ray.object;
    vec3 hair = face * (1e-3 * photic_bent_objects[object].scattering.w);
    photic_bent_touched = true;
    vec3 weight = photic_bent_ray.weight;
    weight *= 1.0 - photicBentReflect(object, photicBentNode(object, place), place - hair, -normal, p, b2 > 0.0 ? square : -1.0, weight);
    if (b2 <= 0.0) {
        photicBentInto(photic_bent_crossing.before);
        photicBentBegin(place, mirrored, weight, photicBentSamples(place));
        return;
    }
    float share = photicBentFaces(object) == PHOTIC_BENT_CLEAR ? 0.0 : photicFresnel(a, sqrt(b2), dot(p, p), square);
    photic_bent_inside = photic_bent_crossing.before;
    photicBentPush(place, mirrored, weight * share);
    photic_bent_inside = after;
    photicBentBegin(place, onward, weight * (1.0 - share), beyond);
}

/// A mirror, or a pane, through which light goes straight on, less what its two faces reflect to and fro (Stokes 1862).
void photicBentTwoSided(vec3 place, vec3 normal, vec3 face) {
    int object = photic_bent_hit.object, first = photic_bent_shapes[object].x;
    vec3 p = photic_bent_ray.momentum;
    float a = dot(p, normal);
    vec3 mirrored = p - 2.0 * a * normal;
    if (dot(mirrored, face) >= 0.0) a = dot(p, face), mirrored = p - 2.0 * a * face;
    vec3 back = photicBentVector(first + 2), weight = photic_bent_ray.weight;
    if (photicBentFaces(object) == PHOTIC_BENT_THIN) {
        float square = dot(p, p), within = 1.0 + 2.0 * photicBentVector(first)[photic_bent_channel];
        float b2 = within - square + a * a, once = b2 > 0.0 ? photicFresnel(a, sqrt(b2), square, within) : 1.0;
        back = vec3(2.0 * once / (1.0 + once));
        photicBentPush(place, mirrored, weight * back);
        photicBentBegin(place, p, weight * (1.0 - back), photicBentSamples(place));
    } else {
        photicBentBegin(place, mirrored, weight * back, photicBentSamples(place));
    }
}

/// The ray is at the face that was found.
void photicBentMeet() {
    int object = photic_bent_hit.object;
    vec3 place = photic_bent_ray.start, p = photic_bent_ray.momentum, weight = photic_bent_ray.weight, normal, face;
    bool back = photic_bent_hit.back;
    photicBentNormals(place, normal, face);
    if (!back) normal = -normal, face = -face;
    photic_bent_touched = true;
    if (dot(p, face) <= 0.0) {
        // It was bent off the face on its last step.
        photicBentBegin(place, p, weight, photicBentSamples(place));
        return;
    }
    if (dot(p, normal) <= 0.0) normal = face;
    if (photicBentFaces(object) >= PHOTIC_BENT_MIRROR) {
        photicBentTwoSided(place, normal, face);
        return;
    }
    int was = photic_bent_body;
    photic_bent_crossing = PhoticBentCrossing(object, normal, face, photic_bent_inside, 1.0);
    photicBentInto(back ? photic_bent_inside & ~(1 << object) : photic_bent_inside | 1 << object);
    int samples = photicBentSamples(place);
    photicBentBegin(place, p, weight, samples);
    if (photic_bent_body == was) return;  // inside of what is there instead, it does nothing
    photic_bent_crossing.square = 1.0 + 2.0 * photic_bent_base;
    photic_bent_ray.look = samples < 0 ? PHOTIC_BENT_CROSS : PHOTIC_BENT_MEET;
}
