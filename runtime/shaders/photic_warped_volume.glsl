// SPDX-License-Identifier: Apache-2.0
// Inside a warped caustic volume (Ernst et al. 2005, sections 3.3 to 3.5). Coordinates are the triangle's own: see
// warped_volume.vert.glsl.

// Twice the areas of the three triangles that a point makes with the corners' rays at its own depth; all of one sign inside.
vec3 photicVolumeAreas(vec3 point, vec3 cx, vec3 cz) {
    return point.x * (cz.zxy - cz.yzx) + point.z * (cx.yzx - cx.zxy) + cz.yzx * cx.zxy - cx.yzx * cz.zxy;
}

bool photicInsideVolume(vec3 areas) {
    return all(greaterThanEqual(areas, vec3(0.0))) || all(lessThanEqual(areas, vec3(0.0)));
}

// The stretch of a ray inside a triangle, both in one plane: the ray is y = 0, and x grows along it. x > y: none.
vec2 photicRayInTriangle(vec2 a, vec2 b, vec2 c) {
    vec2 span = vec2(1e30, -1e30);
    vec2 p = a, q = b;
    for (int i = 0; i < 3; ++i) {
        if ((p.y < 0.0) != (q.y < 0.0)) {
            float x = p.x + (q.x - p.x) * (p.y / (p.y - q.y));
            span = vec2(min(span.x, x), max(span.y, x));
        }
        vec2 r = i == 0 ? c : a;
        p = q, q = r;
    }
    return span;
}
