// SPDX-License-Identifier: Apache-2.0
// Water as a game has it, without a bake: heights over a rectangle, and one sun. LiveWater (runtime_water.h) sets the
// uniforms. Outside the rectangle the sampler's wrap mode decides: flat (border of zeros) or periodic.
uniform highp sampler2D photic_water_map;  // r: height above the level [m]; g, b: slopes dh/dx and dh/dy
uniform vec4 photic_water_rect;            // lower corner x, y [m]; 1 / width, 1 / depth [1/m]
uniform vec2 photic_water_level;           // x: level z [m]; y: index below / index above
uniform vec3 photic_water_extinction;      // [1/m], per channel
uniform vec3 photic_sun_direction;         // unit, of travel, in air
uniform vec3 photic_sun_irradiance;        // across the beam, in air [W/m2]

// Height above the level [m] and slopes at world x, y [m].
vec3 photicWaterAt(vec2 xy) {
    return textureLod(photic_water_map, (xy - photic_water_rect.xy) * photic_water_rect.zw, 0.0).rgb;
}

// Upward unit normal from slopes.
vec3 photicWaterNormal(vec2 slopes) { return normalize(vec3(-slopes, 1.0)); }

// Direction of the sun's light in still water, unit, of travel.
vec3 photicStillWaterDirection() {
    return refract(photic_sun_direction, vec3(0.0, 0.0, 1.0), 1.0 / photic_water_level.y);
}

// Power transmittance into the water for unpolarised light, (Ts + Tp)/2 (Born and Wolf, section 1.5).
// cos_in: of the angle of incidence in air, in (0, 1].
float photicTransmittance(float cos_in) {
    float n = photic_water_level.y;
    float cos_out = sqrt(max(0.0, 1.0 - (1.0 - cos_in * cos_in) / (n * n)));
    float rs = (cos_in - n * cos_out) / (cos_in + n * cos_out);
    float rp = (n * cos_in - cos_out) / (n * cos_in + cos_out);
    return 1.0 - 0.5 * (rs * rs + rp * rp);
}
