// SPDX-License-Identifier: Apache-2.0
// GLSL ES 3.00. Radiance is in units of the light's reference irradiance, so that one exposure suits every scene.

const kPrecision = `
precision highp float;
precision highp sampler3D;
precision highp sampler2D;
`;

/** The look-up: what docs/light_volume.md says, from the texture of a .ktx2. Two frames are mixed. */
const kLight = kPrecision + `
uniform sampler3D u_light, u_light_next;      // flux x, y, z and irradiance, in units of the reference
uniform sampler3D u_rgb, u_rgb_next;          // red, green, blue of the irradiance, and their mean
uniform sampler3D u_light_2, u_light_2_next;  // the second lobe, alike: light that opposes the first
uniform sampler3D u_rgb_2, u_rgb_2_next;
uniform float u_opposed;                      // 1: there is a second lobe
uniform float u_blend;                        // 0: this frame, 1: the next
uniform mat4 u_texture_from_world;
uniform vec3 u_size;                          // texels
uniform vec3 u_period;                        // in widths of the texture; 0: the light does not repeat
uniform float u_coloured;

struct Light {
    vec3 irradiance;  // of all sides, a channel each
    vec3 flux;        // of the mean of the channels, along the light's travel
    float mean;
};
struct Lobes {
    Light first, second;
};

vec4 blended(sampler3D now, sampler3D next, vec3 place) {
    vec4 value = texture(now, place);
    return u_blend > 0.0 ? mix(value, texture(next, place), u_blend) : value;
}

Light lightOf(vec4 value, vec3 rgb) { return Light(u_coloured > 0.0 ? rgb : vec3(value.w), value.xyz, value.w); }

Lobes lightAt(vec3 world) {
    vec3 place = (u_texture_from_world * vec4(world, 1.0)).xyz;
    // Beyond the last texel's centre the light fades to nothing within a texel: WebGL has no border of its own.
    vec3 fade = clamp(min(place, 1.0 - place) * u_size + 0.5, 0.0, 1.0);
    for (int axis = 0; axis < 3; ++axis) {
        if (u_period[axis] <= 0.0 || u_period[axis] > 1.0) continue;
        fade[axis] = 1.0;
        float first = 0.5 / u_size[axis];
        // A texture that is one period wide repeats by itself.
        if (u_period[axis] < 0.999999) place[axis] = first + mod(place[axis] - first, u_period[axis]);
    }
    float there = fade.x * fade.y * fade.z;
    Light dark = Light(vec3(0.0), vec3(0.0), 0.0);
    Lobes lobes = Lobes(dark, dark);
    if (there <= 0.0) return lobes;
    vec3 rgb = u_coloured > 0.0 ? blended(u_rgb, u_rgb_next, place).rgb : vec3(0.0);
    lobes.first = lightOf(blended(u_light, u_light_next, place) * there, rgb * there);
    if (u_opposed <= 0.0) return lobes;
    rgb = u_coloured > 0.0 ? blended(u_rgb_2, u_rgb_2_next, place).rgb : vec3(0.0);
    lobes.second = lightOf(blended(u_light_2, u_light_2_next, place) * there, rgb * there);
    return lobes;
}

/** What a face with a unit normal gets of one lobe: exact where none of its light comes from behind. */
vec3 onFace(Light light, vec3 normal) {
    if (light.mean <= 0.0) return vec3(0.0);
    return light.irradiance * (max(0.0, -dot(normal, light.flux)) / light.mean);
}
`;

/** The ball's shadow, along the mean direction of the light: a decoration, the bake knows no ball. */
const kBall = `
uniform vec4 u_ball;  // centre [m], radius
float besideBall(vec3 world, Light light) {
    float strength = length(light.flux);
    if (light.mean <= 0.0 || strength <= 0.0) return 1.0;
    vec3 to_light = -light.flux / strength, to_ball = u_ball.xyz - world;
    float along = dot(to_ball, to_light);
    if (along <= 0.0 || dot(to_ball, to_ball) <= u_ball.w * u_ball.w * 1.02) return 1.0;
    float away = length(to_ball - along * to_light), soft = 0.004 * along + 0.06 * u_ball.w;
    float open = smoothstep(u_ball.w - soft, u_ball.w + soft, away);
    return mix(1.0, open, min(1.0, strength / light.mean));
}
`;

/** Where water is: below the heights that are drawn. */
const kWater = `
uniform sampler2D u_heights;
uniform vec4 u_water;    // least x and y, and the width along each [m]; a width of 0: no water
uniform float u_level;   // [m]
uniform vec3 u_box_low, u_box_high;
bool inWater(vec3 world) {
    if (u_water.z <= 0.0) return false;
    vec2 place = (world.xy - u_water.xy) / u_water.zw;
    float texels = float(textureSize(u_heights, 0).x);
    return world.z < texture(u_heights, (place * (texels - 1.0) + 0.5) / texels).r;
}
/** Where a ray is within the box, from x to y [m]; x > y where it misses. */
vec2 throughBox(vec3 eye, vec3 direction, vec3 low, vec3 high) {
    vec3 a = (low - eye) / direction, b = (high - eye) / direction;
    vec3 first = min(a, b), last = max(a, b);
    return vec2(max(0.0, max(first.x, max(first.y, first.z))), min(last.x, min(last.y, last.z)));
}
/** The same of its way through the water at rest. */
vec2 throughWater(vec3 eye, vec3 direction) {
    if (u_water.z <= 0.0) return vec2(1.0, 0.0);
    return throughBox(eye, direction, u_box_low, vec3(u_box_high.xy, min(u_box_high.z, u_level)));
}
`;

const kSky = `
uniform vec3 u_sun_direction;  // of travel
vec3 sky(vec3 direction) {
    float up = clamp(direction.z, 0.0, 1.0);
    vec3 colour = 0.3 * mix(vec3(0.85, 0.92, 1.0), vec3(0.30, 0.52, 0.92), sqrt(up));
    colour = mix(colour, vec3(0.035, 0.04, 0.045), smoothstep(0.0, 0.7, -direction.z));  // the ground
    float cosine = dot(direction, -u_sun_direction);
    return colour + (cosine > 0.0 ? 2.4 * exp(-(1.0 - cosine) / 0.0006) : 0.0) * vec3(1.0, 0.97, 0.9);
}
`;

const kSolidVertex = kPrecision + `
in vec3 a_position, a_normal;
uniform mat4 u_clip_from_world;
uniform vec4 u_place;  // offset [m] and scale
out vec3 v_world, v_normal;
void main() {
    v_world = a_position * u_place.w + u_place.xyz;
    v_normal = a_normal;
    gl_Position = u_clip_from_world * vec4(v_world, 1.0);
}`;

const kShadowFragment = kPrecision + `void main() {}`;

/** Sunlight that has met nothing yet: the volume holds none of it, and whatever stands in its way stops it. */
const kSunlight = `
uniform sampler2D u_shadow;
uniform mat4 u_shadow_from_world;
float sunlit(vec3 world, vec3 normal) {
    float side = float(textureSize(u_shadow, 0).x);
    // A texel off the face, so that it does not shade itself.
    float texel = 2.0 / (side * length(vec3(u_shadow_from_world[0].x, u_shadow_from_world[1].x, u_shadow_from_world[2].x)));
    vec3 place = 0.5 + 0.5 * (u_shadow_from_world * vec4(world + 2.0 * texel * normal, 1.0)).xyz;
    if (any(lessThan(place.xy, vec2(0.0))) || any(greaterThan(place.xy, vec2(1.0)))) return 1.0;
    float open = 0.0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) open += step(place.z - 0.001, texture(u_shadow, place.xy + vec2(x, y) / side).r);
    return open / 9.0;
}
`;

/** Receivers, and whatever else is solid. */
const kSolidFragment = kLight + kBall + kWater + kSunlight + `
in vec3 v_world, v_normal;
out vec4 out_colour;
uniform vec3 u_albedo, u_eye, u_sun_irradiance, u_sun_direction;
uniform float u_tile;       // [m]; 0: plain
uniform float u_two_sided;  // a mesh turns its normals to the eye
uniform float u_is_ball;

vec3 tiled(vec3 base, vec3 normal) {
    if (u_tile <= 0.0) return base;
    vec3 n = abs(normal);
    vec2 place = (n.x > 0.7 ? v_world.yz : n.y > 0.7 ? v_world.zx : v_world.xy) / u_tile;
    vec2 within = fract(place), wide = fwidth(place);
    vec2 edge = min(within, 1.0 - within);
    vec2 joint = 1.0 - smoothstep(vec2(0.012), vec2(0.024) + wide, edge);
    float plain = clamp(1.0 - 2.0 * max(wide.x, wide.y), 0.0, 1.0);
    vec2 tile = floor(place);
    float shade = fract(sin(dot(tile, vec2(12.9898, 78.233))) * 43758.5453);
    return base * (0.95 + 0.05 * shade) * (1.0 - 0.3 * plain * max(joint.x, joint.y));
}

void main() {
    vec3 normal = normalize(v_normal);
    if (u_two_sided > 0.0 && dot(normal, u_eye - v_world) < 0.0) normal = -normal;
    Lobes lobes = lightAt(v_world);
    vec3 irradiance = onFace(lobes.first, normal), opposed = onFace(lobes.second, normal);
    if (u_is_ball == 0.0) {
        irradiance *= besideBall(v_world, lobes.first);
        opposed *= besideBall(v_world, lobes.second);
    }
    irradiance += opposed;
    float facing = -dot(normal, u_sun_direction);
    if (facing > 0.0 && u_sun_irradiance != vec3(0.0) && !inWater(v_world))
        irradiance += u_sun_irradiance * facing * sunlit(v_world, normal);
    irradiance += 0.06 * (0.4 + 0.6 * (0.5 + 0.5 * normal.z)) * vec3(0.85, 0.95, 1.0);
    vec3 albedo = u_is_ball > 0.0 && abs(normal.z * 0.8 + normal.x * 0.6) < 0.22 ? vec3(0.86, 0.33, 0.22) : u_albedo;
    out_colour = vec4(tiled(albedo, normal) / 3.14159265 * irradiance, 1.0);
}`;

const kScreenVertex = `
out vec2 v_place;
void main() {
    v_place = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(2.0 * v_place - 1.0, 0.0, 1.0);
}`;

/** From the depth of a pixel to the ray through it. */
const kRay = `
uniform sampler2D u_depth;
uniform mat4 u_world_from_clip;
uniform vec3 u_eye;
in vec2 v_place;
/** Direction, and the distance of what is seen there [m]. */
vec4 rayAt(vec2 place, float depth) {
    vec4 world = u_world_from_clip * vec4(2.0 * vec3(place, depth) - 1.0, 1.0);
    vec3 way = world.xyz / world.w - u_eye;
    float far = length(way);
    return vec4(way / far, far);
}
`;

/** Light that the water, or haze, scatters once towards the eye. */
const kMediumFragment = kLight + kBall + kWater + kRay + `
out vec4 out_colour;
uniform vec3 u_extinction;  // of the water [1/m]
uniform float u_scattering, u_anisotropy;
const int kSteps = 24;

float phase(float cosine, float g) {
    return (1.0 - g * g) / (12.5663706 * pow(max(1e-4, 1.0 + g * g - 2.0 * g * cosine), 1.5));
}

/** Of one lobe's light, what is scattered along the ray towards the eye, for each unit of the coefficient and metre. */
vec3 scattered(Light light, vec3 world, vec3 ray) {
    if (light.mean <= 0.0) return vec3(0.0);
    float strength = length(light.flux);
    float cosine = strength > 0.0 ? dot(light.flux, -ray) / strength : 0.0;
    return light.irradiance * phase(cosine, u_anisotropy * min(1.0, strength / light.mean)) * besideBall(world, light);
}

void main() {
    vec4 ray = rayAt(v_place, texture(u_depth, v_place).r);
    out_colour = vec4(0.0, 0.0, 0.0, ray.w);
    vec2 way = throughBox(u_eye, ray.xyz, u_box_low, u_box_high), wet = throughWater(u_eye, ray.xyz);
    way.y = min(way.y, ray.w);
    if (way.x >= way.y || u_scattering <= 0.0) return;
    // Noise that is even over neighbouring pixels (Jimenez 2014).
    float jitter = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    float stride = (way.y - way.x) / float(kSteps);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < kSteps; ++i) {
        float along = way.x + (float(i) + jitter) * stride;
        vec3 world = u_eye + along * ray.xyz;
        Lobes lobes = lightAt(world);
        vec3 seen = exp(-u_extinction * max(0.0, along - max(wet.x, 0.0)));
        sum += scattered(lobes.first, world, ray.xyz) * seen;
        if (u_opposed > 0.0) sum += scattered(lobes.second, world, ray.xyz) * seen;
        if (inWater(world)) sum += 0.06 / 12.5663706 * vec3(0.5, 0.8, 1.0) * seen;
    }
    out_colour.rgb = u_scattering * stride * sum;
}`;

/**
 * The optical depth of wine and coloured glass, of which each face adds or takes away its distance from the eye: what is
 * left is the way in them, as far as something solid.
 */
const kTintFragment = kPrecision + `
in vec3 v_world, v_normal;
out vec4 out_colour;
uniform sampler2D u_depth;
uniform mat4 u_world_from_clip;
uniform vec3 u_eye, u_absorption;  // [1/m]
void main() {
    ivec2 size = textureSize(u_depth, 0);
    vec3 solid = 2.0 * vec3(gl_FragCoord.xy / vec2(size), texelFetch(u_depth, ivec2(gl_FragCoord.xy), 0).r) - 1.0;
    vec4 world = u_world_from_clip * vec4(solid, 1.0);
    float way = min(length(v_world - u_eye), length(world.xyz / world.w - u_eye));
    out_colour = vec4((gl_FrontFacing ? -way : way) * u_absorption, 1.0);
}`;

/** Adds the two, and makes of radiance what a screen shows. */
const kDisplayFragment = kPrecision + kWater + kRay + `
uniform sampler2D u_colour, u_medium, u_tint;
uniform vec3 u_extinction;
uniform float u_exposure;
out vec4 out_colour;

/** The medium is drawn with half as many pixels a side: take those nearby that look at the same distance. */
vec3 mediumAt(float far) {
    ivec2 size = textureSize(u_medium, 0), base = ivec2(floor(v_place * vec2(size) - 0.5));
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int y = -1; y < 3; ++y) {
        for (int x = -1; x < 3; ++x) {
            vec4 texel = texelFetch(u_medium, clamp(base + ivec2(x, y), ivec2(0), size - 1), 0);
            float weight = 1e-4 + exp(-abs(texel.a - far) / (0.02 * far));
            sum += weight * texel.rgb;
            weights += weight;
        }
    }
    return sum / weights;
}

/** A curve of film: the fit of K. Narkowicz (2015) to that of ACES. */
vec3 filmic(vec3 v) { return clamp(v * (2.51 * v + 0.03) / (v * (2.43 * v + 0.59) + 0.14), 0.0, 1.0); }

void main() {
    float depth = texture(u_depth, v_place).r;
    vec4 ray = rayAt(v_place, depth);
    vec2 from_middle = v_place - vec2(0.5, 0.55);
    vec3 room = mix(vec3(0.020, 0.046, 0.062), vec3(0.004, 0.009, 0.014), smoothstep(0.0, 0.75, length(from_middle)));
    vec3 colour = depth < 1.0 ? texture(u_colour, v_place).rgb : room / u_exposure;
    vec2 wet = throughWater(u_eye, ray.xyz);
    wet.y = min(wet.y, ray.w);
    if (wet.x < wet.y && depth < 1.0) colour *= exp(-u_extinction * (wet.y - wet.x));
    colour *= exp(-abs(texture(u_tint, v_place).rgb));
    colour = filmic((colour + mediumAt(ray.w)) * u_exposure);
    vec3 screen = mix(12.92 * colour, 1.055 * pow(max(colour, 1e-6), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, colour));
    // Half a level of noise, against bands in the dark.
    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
    out_colour = vec4(screen + noise / 255.0, 1.0);
}`;

/** Water, glass and mirrors: what they reflect of the sky, over what is seen through them. */
const kShellFragment = kPrecision + kSky + `
in vec3 v_world, v_normal;
out vec4 out_colour;
uniform sampler2D u_depth;
uniform vec3 u_eye, u_mirror;   // colour of a metal; 0: glass or water
uniform float u_ior, u_exposure;

float fresnel(float cosine, float ior) {
    float sine2 = (1.0 - cosine * cosine) / (ior * ior);
    if (sine2 >= 1.0) return 1.0;
    float beyond = sqrt(1.0 - sine2);
    float s = (cosine - ior * beyond) / (cosine + ior * beyond), p = (ior * cosine - beyond) / (ior * cosine + beyond);
    return 0.5 * (s * s + p * p);
}

void main() {
    if (gl_FragCoord.z > texelFetch(u_depth, ivec2(gl_FragCoord.xy), 0).r) discard;
    vec3 normal = normalize(v_normal), view = normalize(u_eye - v_world);
    float ior = u_ior;
    if (dot(normal, view) < 0.0) { normal = -normal; if (u_mirror == vec3(0.0)) ior = 1.0; }
    float cosine = dot(normal, view), share = fresnel(cosine, ior);
    vec3 reflected = sky(reflect(-view, normal)) * u_exposure;
    reflected = reflected / (1.0 + reflected);
    vec3 screen = pow(reflected, vec3(1.0 / 2.2));
    if (u_mirror != vec3(0.0)) { out_colour = vec4(screen * u_mirror + 0.04, 1.0); return; }
    out_colour = vec4(share * screen + 0.015, share);
}`;

/** Measures: light and what faces get, at points of a texture (Page.measure()). */
const kMeasureFragment = kLight + `
uniform sampler2D u_points, u_normals;
layout(location = 0) out vec4 out_irradiance;
layout(location = 1) out vec4 out_flux;
layout(location = 2) out vec4 out_face;
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    Lobes lobes = lightAt(texelFetch(u_points, at, 0).xyz);
    vec3 normal = texelFetch(u_normals, at, 0).xyz;
    out_irradiance = vec4(lobes.first.irradiance + lobes.second.irradiance, 1.0);
    out_flux = vec4(lobes.first.flux + lobes.second.flux, 0.0);
    out_face = vec4(onFace(lobes.first, normal) + onFace(lobes.second, normal), 0.0);
}`;
