// SPDX-License-Identifier: Apache-2.0
// Bounding prisms of warped caustic volumes: M. Ernst, T. Akenine-Moeller, H. W. Jensen, "Interactive Rendering of Caustics
// using Interpolated Warped Volumes" (2005), sections 3.2 and 4.3. Six corners a triangle of the water's mesh: the top
// is the triangle, the bottom the smallest triangle with parallel sides that holds the three rays' ends. The paper builds
// them on the CPU.
uniform highp sampler2D photic_ray_starts;      // water_rays.frag.glsl
uniform highp sampler2D photic_ray_directions;
uniform mat4 photic_clip_from_world;
uniform int photic_mesh_step;        // vertices of the mesh from one corner to the next
uniform float photic_volume_bottom;  // z [m] that every volume reaches down to

// The triangle's frame: y along `normal`, 0 at the triangle, growing with the light; its rays have y = 1.
flat out vec3 photic_frame_origin, photic_frame_x, photic_frame_normal;
flat out vec3 photic_vx, photic_vz, photic_rx, photic_rz;  // of the three corners
flat out float photic_power;                               // over the sun's irradiance [m2]

void main() {
    int triangle = gl_VertexID / 6, corner = gl_VertexID % 6;
    int columns = (textureSize(photic_ray_starts, 0).x - 1) / photic_mesh_step;
    ivec2 cell = ivec2((triangle / 2) % columns, (triangle / 2) / columns);
    // Clockwise from above, so that the normal follows the light.
    ivec2 index[3];
    index[0] = cell;
    index[1] = cell + ((triangle & 1) == 0 ? ivec2(1, 1) : ivec2(0, 1));
    index[2] = cell + ((triangle & 1) == 0 ? ivec2(1, 0) : ivec2(1, 1));
    vec3 position[3], ray[3];
    float power = 0.0;
    for (int i = 0; i < 3; ++i) {
        vec4 start = texelFetch(photic_ray_starts, index[i] * photic_mesh_step, 0);
        position[i] = start.xyz;
        power += start.w / 3.0;
        ray[i] = texelFetch(photic_ray_directions, index[i] * photic_mesh_step, 0).xyz;
    }
    vec3 e1 = position[1] - position[0], e2 = position[2] - position[0];
    vec3 normal = normalize(cross(e1, e2)), x = normalize(e1), z = cross(normal, x);
    photic_frame_origin = position[0], photic_frame_x = x, photic_frame_normal = normal;
    photic_vx = vec3(0.0, dot(e1, x), dot(e2, x));
    photic_vz = vec3(0.0, 0.0, dot(e2, z));
    float reach = 0.0;
    for (int i = 0; i < 3; ++i) {
        vec3 r = ray[i] / dot(ray[i], normal);
        photic_rx[i] = dot(r, x), photic_rz[i] = dot(r, z);
        reach = max(reach, (photic_volume_bottom - position[i].z) / r.z);
    }
    // The mesh is regular in x and y: its triangles are alike seen from above.
    photic_power = power * 0.5 * abs(e1.x * e2.y - e1.y * e2.x);

    // Barycentric coordinates of the rays' ends with respect to the triangle, and the least of each.
    vec3 bx = photic_vx + reach * photic_rx, bz = photic_vz + reach * photic_rz;
    float twice_area = photic_vx.y * photic_vz.z;
    vec3 l2 = bz / photic_vz.z;
    vec3 l1 = (bx * photic_vz.z - bz * photic_vx.z) / twice_area;
    vec3 l0 = 1.0 - l1 - l2;
    vec3 least = vec3(min(l0.x, min(l0.y, l0.z)), min(l1.x, min(l1.y, l1.z)), min(l2.x, min(l2.y, l2.z)));
    // A little larger, so that rounding loses no pixel; the test in the fragment shader decides.
    vec3 bound = (corner < 3 ? vec3(0.0) : least) - 1e-3;
    int k = corner % 3;
    vec3 weight = bound;
    weight[k] = 1.0 - bound[(k + 1) % 3] - bound[(k + 2) % 3];
    vec3 place = position[0] * weight.x + position[1] * weight.y + position[2] * weight.z +
                 normal * (corner < 3 ? -1e-3 * length(e1) : reach);
    gl_Position = photic_clip_from_world * vec4(place, 1.0);
}
