// SPDX-License-Identifier: Apache-2.0
#include "live_grid.glsl"
layout(local_size_x = 64) in;

void main() {
    // Rows of 32768 groups: more of them than one dimension may hold.
    uint at = gl_GlobalInvocationID.x + 64u * 32768u * gl_GlobalInvocationID.y;
    if (at < uint(photic_live_sums.length())) photic_live_sums[at] = 0;
}
