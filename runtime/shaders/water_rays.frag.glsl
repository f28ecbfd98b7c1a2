// SPDX-License-Identifier: Apache-2.0
// One texel a vertex of the water's mesh: where the sun meets the surface, with what power, and whereto it is refracted.
// Both the caustic mesh and the warped volumes start from these two textures.
#include "photic_water.glsl"

uniform vec4 photic_mesh;  // x, y of vertex (0, 0) [m]; spacing x, y [m]

layout(location = 0) out vec4 photic_ray_start;      // xyz: world [m]; w: power per level area, over the sun's irradiance
layout(location = 1) out vec4 photic_ray_direction;  // xyz: unit, of travel in the water

void main() {
    vec2 xy = photic_mesh.xy + (gl_FragCoord.xy - 0.5) * photic_mesh.zw;
    vec3 water = photicWaterAt(xy);
    // d(position)/dx x d(position)/dy: its dot with the beam is the beam's width per level area.
    vec3 area = vec3(-water.yz, 1.0);
    float across = dot(-photic_sun_direction, area);
    float power = across > 0.0 ? across * photicTransmittance(across * inversesqrt(dot(area, area))) : 0.0;
    photic_ray_start = vec4(xy, photic_water_level.x + water.x, power);
    // A slope that turns from the sun gets no light; its ray only keeps the mesh whole.
    vec3 normal = normalize(across > 0.0 ? area : vec3(0.0, 0.0, 1.0));
    photic_ray_direction = vec4(refract(photic_sun_direction, normal, 1.0 / photic_water_level.y), 0.0);
}
