// SPDX-License-Identifier: Apache-2.0
// Inside a warped caustic volume (Ernst et al. 2005, sections 3.3 and 3.5). Coordinates are the triangle's own: see
// warped_volume.vert.glsl.

// Twice the areas beta of the three triangles that a point makes with the corners' rays at its own depth (section 3.3); all
// of one sign inside. The paper multiplies the products out; differences first keep precision far from the triangle.
vec3 photicVolumeAreas(vec2 point, vec3 cx, vec3 cz) {
    vec3 ex = point.x - cx, ez = point.y - cz;
    return ex.yzx * ez.zxy - ez.yzx * ex.zxy;
}

bool photicInsideVolume(vec3 areas) {
    return all(greaterThanEqual(areas, vec3(0.0))) || all(lessThanEqual(areas, vec3(0.0)));
}

// The stretch of a ray inside a triangle, both in one plane: the ray is y = 0, and x grows along it. x > y: none.
vec2 photicRayInTriangle(vec3 x, vec3 y) {
    vec2 span = vec2(1e30, -1e30);
    for (int i = 0; i < 3; ++i) {
        int k = (i + 1) % 3;
        if ((y[i] < 0.0) == (y[k] < 0.0)) continue;
        float crossing = x[i] + (x[k] - x[i]) * (y[i] / (y[i] - y[k]));
        span = vec2(min(span.x, crossing), max(span.y, crossing));
    }
    return span;
}
