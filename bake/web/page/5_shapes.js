// SPDX-License-Identifier: Apache-2.0
// Triangles of what the scene says: planes, meshes, water, and a ball.

async function meshData(mesh) {
    const numbers = async (text, Kind) => new Kind(await unpacked(text, 4));
    return {
        positions: await numbers(mesh.positions, Float32Array),
        normals: await numbers(mesh.normals, Float32Array),
        triangles: await numbers(mesh.triangles, Uint32Array),
    };
}

/** The part of a plane that is seen: a convex polygon. */
function planeData({ corners, normal }) {
    const triangles = corners.slice(2).flatMap((_, i) => [0, i + 1, i + 2]);
    return {
        positions: new Float32Array(corners.flat()),
        normals: new Float32Array(corners.flatMap(() => normal)),
        triangles: new Uint32Array(triangles),
    };
}

function ballData() {
    const rows = 40, columns = 80, positions = [], triangles = [];
    for (let row = 0; row <= rows; ++row) {
        for (let column = 0; column <= columns; ++column) {
            const a = (Math.PI * row) / rows, b = (2 * Math.PI * column) / columns;
            positions.push(Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), Math.cos(a));
            if (row === rows || column === columns) continue;
            const at = row * (columns + 1) + column;
            triangles.push(at, at + columns + 1, at + 1, at + 1, at + columns + 1, at + columns + 2);
        }
    }
    const numbers = new Float32Array(positions);
    return { positions: numbers, normals: numbers, triangles: new Uint32Array(triangles) };
}

/** The water of one frame. @param codes heights, 0 for the lowest and 65535 for the highest */
function waterHeights({ heights, lowest, highest }) {
    return Float32Array.from(heights, (code) => lowest + (code / 65535) * (highest - lowest));
}

function waterData(water, heights) {
    const n = water.side, positions = new Float32Array(3 * n * n), normals = new Float32Array(3 * n * n), triangles = [];
    const step = water.size.map((width) => width / (n - 1));
    const height = (i, j) => heights[clamp(j, 0, n - 1) * n + clamp(i, 0, n - 1)];
    for (let j = 0; j < n; ++j) {
        for (let i = 0; i < n; ++i) {
            const at = j * n + i;
            positions.set([water.low[0] + i * step[0], water.low[1] + j * step[1], height(i, j)], 3 * at);
            const wide = [clamp(i + 1, 0, n - 1) - clamp(i - 1, 0, n - 1), clamp(j + 1, 0, n - 1) - clamp(j - 1, 0, n - 1)];
            normals.set(normalised([(height(i - 1, j) - height(i + 1, j)) / (wide[0] * step[0]),
                                    (height(i, j - 1) - height(i, j + 1)) / (wide[1] * step[1]), 1]), 3 * at);
            if (i + 1 < n && j + 1 < n) triangles.push(at, at + 1, at + n + 1, at, at + n + 1, at + n);
        }
    }
    return { positions, normals, triangles: new Uint32Array(triangles) };
}
