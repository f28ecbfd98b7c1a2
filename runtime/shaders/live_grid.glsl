// SPDX-License-Identifier: Apache-2.0
// The sums of a live bake: whole numbers, so that their order does not matter and a frame is the same bits each time.
// Per voxel flux x, y, z and irradiance, in colour red, green and blue behind them, in 1 / photicLiveUnit of the reference.
#ifndef PHOTIC_COLOURED
#define PHOTIC_COLOURED 0
#endif
const float photicLiveUnit = 262144.0;  // 8000 times the reference irradiance fit 32 bits
const int photicLiveValues = PHOTIC_COLOURED != 0 ? 7 : 4;

layout(std430, binding = 0) buffer photic_live_buffer { int photic_live_sums[]; };
uniform ivec4 photic_live_cells;  // along x, y, z; w: 1 where x and y repeat
uniform int photic_live_pad;      // cells more on each side of x and y, from which the disc's blur draws

/// Index of the first value of a cell, which may be as far outside as the pad is wide; -1 farther off.
int photicLiveAt(ivec2 cell, int layer) {
    ivec2 cells = photic_live_cells.xy;
    if (photic_live_cells.w != 0) cell -= ivec2(floor((vec2(cell) + 0.5) / vec2(cells))) * cells;
    ivec2 at = cell + photic_live_pad, size = cells + 2 * photic_live_pad;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) return -1;
    return ((layer * size.y + at.y) * size.x + at.x) * photicLiveValues;
}
