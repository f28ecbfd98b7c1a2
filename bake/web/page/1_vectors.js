// SPDX-License-Identifier: Apache-2.0
// Vectors and 4 x 4 matrices as WebGL takes them (columns one after the other). Metres, Z up.

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const lengthOf = (a) => Math.hypot(a[0], a[1], a[2]);
const normalised = (a) => scaled(a, 1 / (lengthOf(a) || 1));
const clamp = (v, low, high) => Math.min(Math.max(v, low), high);

/** A matrix from four rows. */
const fromRows = (rows) => [0, 1, 2, 3].flatMap((column) => rows.map((row) => row[column]));

const multiply = (a, b) =>
    Array.from({ length: 16 }, (_, i) => {
        const column = i >> 2, row = i & 3;
        let sum = 0;
        for (let k = 0; k < 4; ++k) sum += a[4 * k + row] * b[4 * column + k];
        return sum;
    });

/** m times the vector (x, y, z, w). */
const transformed = (m, [x, y, z, w]) =>
    [0, 1, 2, 3].map((row) => m[row] * x + m[4 + row] * y + m[8 + row] * z + m[12 + row] * w);

/** The inverse, by elimination with pivots; the matrices here have one. */
function inverse(m) {
    const rows = [0, 1, 2, 3].map((row) => [0, 1, 2, 3].map((c) => m[4 * c + row]).concat([0, 1, 2, 3].map((c) => +(c === row))));
    for (let column = 0; column < 4; ++column) {
        let pivot = column;
        for (let row = column + 1; row < 4; ++row) if (Math.abs(rows[row][column]) > Math.abs(rows[pivot][column])) pivot = row;
        [rows[column], rows[pivot]] = [rows[pivot], rows[column]];
        const by = rows[column][column];
        rows[column] = rows[column].map((v) => v / by);
        for (let row = 0; row < 4; ++row) {
            if (row === column) continue;
            const times = rows[row][column];
            rows[row] = rows[row].map((v, i) => v - times * rows[column][i]);
        }
    }
    return fromRows(rows.map((row) => row.slice(4)));
}

/** Clip space from the eye's. @param fov_deg of the height */
function perspective(fov_deg, aspect, near, far) {
    const f = 1 / Math.tan((fov_deg * Math.PI) / 360);
    return fromRows([
        [f / aspect, 0, 0, 0],
        [0, f, 0, 0],
        [0, 0, (far + near) / (near - far), (2 * far * near) / (near - far)],
        [0, 0, -1, 0],
    ]);
}

/** The eye's space from the world's. */
function lookAt(eye, target, up) {
    const back = normalised(subtract(eye, target));
    const right = normalised(cross(up, back));
    const above = cross(back, right);
    return fromRows([
        [...right, -dot(right, eye)],
        [...above, -dot(above, eye)],
        [...back, -dot(back, eye)],
        [0, 0, 0, 1],
    ]);
}

/** Clip space of parallel light that covers a box, from the world's. @param direction of travel */
function alongLight(direction, low, high) {
    const middle = scaled(add(low, high), 0.5), half = 0.5 * lengthOf(subtract(high, low));
    const up = Math.abs(direction[2]) > 0.9 ? [0, 1, 0] : [0, 0, 1];
    const seen = lookAt(subtract(middle, scaled(direction, half)), middle, up);
    // What lies before the box towards the light casts shadows on it too: depth begins one box earlier.
    const square = fromRows([[1 / half, 0, 0, 0], [0, 1 / half, 0, 0], [0, 0, -1 / (1.5 * half), -1 / 3], [0, 0, 0, 1]]);
    return multiply(square, seen);
}
