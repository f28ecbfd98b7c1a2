// SPDX-License-Identifier: Apache-2.0
// One triangle over the whole viewport, without vertex data: draw 3 vertices with an empty vertex array.
out vec2 photic_uv;  // (0, 0) lower left to (1, 1) upper right

void main() {
    photic_uv = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));
    gl_Position = vec4(photic_uv * 2.0 - 1.0, 0.0, 1.0);
}
