// SPDX-License-Identifier: Apache-2.0
// What a medium leaves of the light of what is behind it, to be multiplied with it.
#include "g_buffer.glsl"
#include "eye_segment.glsl"
in vec2 photic_uv;
layout(location = 0) out vec4 photic_color;
uniform vec3 photic_extinction;

void main() {
    PhoticSegment s = photicSegment(ivec2(photic_uv * vec2(textureSize(photic_depth, 0))));
    photic_color = vec4(exp(-photic_extinction * max(0.0, s.end - s.begin)), 1.0);
}
