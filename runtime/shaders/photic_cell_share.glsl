// SPDX-License-Identifier: Apache-2.0
// What part of a triangle lies in a square cell, by exact area. Nothing depends on where a cell's centre lies, so no light
// is lost or made however thin the triangles grow at a caustic.

// Area of the unit square below the segment from p to q, negative where it runs towards -x.
float photicBelow(vec2 p, vec2 q) {
    float x0 = clamp(p.x, 0.0, 1.0), x1 = clamp(q.x, 0.0, 1.0);
    if (x0 == x1) return 0.0;
    float slope = (q.y - p.y) / (q.x - p.x), low = min(p.y, q.y), high = max(p.y, q.y);
    float y0 = clamp(p.y + (x0 - p.x) * slope, low, high), y1 = clamp(p.y + (x1 - p.x) * slope, low, high);
    // The mean of clamp(y, 0, 1) from y0 to y1; written so that nothing cancels.
    float c0 = clamp(y0, 0.0, 1.0), c1 = clamp(y1, 0.0, 1.0), mean = c0;
    if (y1 != y0) mean = ((c1 - c0) * (c1 + c0) * 0.5 + max(y1 - 1.0, 0.0) - max(y0 - 1.0, 0.0)) / (y1 - y0);
    return mean * (x1 - x0);
}

// The part of a segment's length inside the unit square.
float photicInside(vec2 p, vec2 q) {
    vec2 along = q - p;
    vec2 safe = mix(along, vec2(1e-9), lessThan(abs(along), vec2(1e-9)));
    vec2 t0 = (vec2(0.0) - p) / safe, t1 = (vec2(1.0) - p) / safe;
    vec2 enter = min(t0, t1), leave = max(t0, t1);
    return max(0.0, min(min(leave.x, leave.y), 1.0) - max(max(enter.x, enter.y), 0.0));
}

// The part of triangle a b c, relative to a cell's lower corner and in cells, that lies in the cell, by area; 0 where they
// do not touch.
float photicCellShare(vec2 a, vec2 b, vec2 c) {
    vec2 ab = b - a, ac = c - a, bc = c - b;
    float area = 0.5 * (ab.x * ac.y - ab.y * ac.x);
    // Distances of the cell's centre from the sides, times the sides' lengths; positive inside. And how far the cell
    // reaches in the same measure.
    vec3 distances = vec3(ab.x * (0.5 - a.y) - ab.y * (0.5 - a.x), bc.x * (0.5 - b.y) - bc.y * (0.5 - b.x),
                          ac.y * (0.5 - c.x) - ac.x * (0.5 - c.y)) * (area < 0.0 ? -1.0 : 1.0);
    vec3 reach = 0.5 * vec3(abs(ab.x) + abs(ab.y), abs(bc.x) + abs(bc.y), abs(ac.x) + abs(ac.y));
    if (any(lessThan(distances, -reach - 1e-3))) return 0.0;
    if (all(greaterThan(distances, reach))) return 1.0 / abs(area);
    if (abs(area) > 1e-3) return (photicBelow(a, b) + photicBelow(b, c) + photicBelow(c, a)) / -area;
    // Thinner than rounding can measure: the light lies along the longest side.
    float sides[3];
    sides[0] = dot(ab, ab), sides[1] = dot(bc, bc), sides[2] = dot(ac, ac);
    bool first = sides[0] >= sides[1] && sides[0] >= sides[2];
    return first ? photicInside(a, b) : sides[1] >= sides[2] ? photicInside(b, c) : photicInside(c, a);
}
