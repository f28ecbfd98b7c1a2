// SPDX-License-Identifier: Apache-2.0
// Reads a CausticMap (runtime_water.h): light on level layers below the water, each a texture, all leaning with the sun's
// light in still water, so that what lies between two layers is found by mixing them.
#include "photic_water.glsl"

uniform highp sampler2DArray photic_caustic_map;  // flux.xyz, fluence rate, over the sun's irradiance; layer 0 the deepest
uniform vec4 photic_caustic_rect;    // lower corner x, y at the water's level [m]; 1 / width, 1 / depth [1/m]
uniform vec4 photic_caustic_layers;  // x: deepest z [m]; y: 1 / distance between layers [1/m]; z: layers - 1;
                                     // w: 1 when the water is periodic

// flux.xyz and fluence rate at a world position, over the sun's irradiance across its beam, without the medium.
vec4 photicCausticSample(vec3 position) {
    vec3 light = photicStillWaterDirection();
    float height = position.z - photic_water_level.x;
    vec2 uv = (position.xy - light.xy / light.z * height - photic_caustic_rect.xy) * photic_caustic_rect.zw;
    if (photic_caustic_layers.w < 0.5 && (any(lessThan(uv, vec2(0.0))) || any(greaterThan(uv, vec2(1.0))))) {
        float still = photicTransmittance(-photic_sun_direction.z) * photic_sun_direction.z / light.z;
        return still * vec4(light, 1.0);
    }
    float layer = clamp((position.z - photic_caustic_layers.x) * photic_caustic_layers.y, 0.0, photic_caustic_layers.z);
    float lower = min(floor(layer), max(0.0, photic_caustic_layers.z - 1.0));
    vec4 deep = textureLod(photic_caustic_map, vec3(uv, lower), 0.0);
    if (photic_caustic_layers.z < 0.5) return deep;
    return mix(deep, textureLod(photic_caustic_map, vec3(uv, lower + 1.0), 0.0), layer - lower);
}

// What a receiver gets without a bake [W/m2, per channel]. position: world; normal: unit, world.
vec3 photicCausticIrradiance(vec3 position, vec3 normal) {
    float height = position.z - photic_water_level.x;
    vec3 light = photicStillWaterDirection();
    vec2 above = position.xy - light.xy / light.z * height;
    if (height > photicWaterAt(above).x) return vec3(0.0);
    vec3 medium = exp(-photic_water_extinction * max(0.0, height / light.z));
    return photic_sun_irradiance * medium * max(0.0, -dot(normal, photicCausticSample(position).xyz));
}
