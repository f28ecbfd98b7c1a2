(() => {
"use strict";
// SPDX-License-Identifier: Apache-2.0
// Vectors and 4 x 4 matrices as WebGL takes them (columns one after the other). Metres, Z up.

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const lengthOf = (a) => Math.hypot(a[0], a[1], a[2]);
const normalised = (a) => scaled(a, 1 / (lengthOf(a) || 1));
const clamp = (v, low, high) => Math.min(Math.max(v, low), high);

/** A matrix from four rows. */
const fromRows = (rows) => [0, 1, 2, 3].flatMap((column) => rows.map((row) => row[column]));

const multiply = (a, b) =>
    Array.from({ length: 16 }, (_, i) => {
        const column = i >> 2, row = i & 3;
        let sum = 0;
        for (let k = 0; k < 4; ++k) sum += a[4 * k + row] * b[4 * column + k];
        return sum;
    });

/** m times the vector (x, y, z, w). */
const transformed = (m, [x, y, z, w]) =>
    [0, 1, 2, 3].map((row) => m[row] * x + m[4 + row] * y + m[8 + row] * z + m[12 + row] * w);

/** The inverse, by elimination with pivots; the matrices here have one. */
function inverse(m) {
    const rows = [0, 1, 2, 3].map((row) => [0, 1, 2, 3].map((c) => m[4 * c + row]).concat([0, 1, 2, 3].map((c) => +(c === row))));
    for (let column = 0; column < 4; ++column) {
        let pivot = column;
        for (let row = column + 1; row < 4; ++row) if (Math.abs(rows[row][column]) > Math.abs(rows[pivot][column])) pivot = row;
        [rows[column], rows[pivot]] = [rows[pivot], rows[column]];
        const by = rows[column][column];
        rows[column] = rows[column].map((v) => v / by);
        for (let row = 0; row < 4; ++row) {
            if (row === column) continue;
            const times = rows[row][column];
            rows[row] = rows[row].map((v, i) => v - times * rows[column][i]);
        }
    }
    return fromRows(rows.map((row) => row.slice(4)));
}

/** Clip space from the eye's. @param fov_deg of the height */
function perspective(fov_deg, aspect, near, far) {
    const f = 1 / Math.tan((fov_deg * Math.PI) / 360);
    return fromRows([
        [f / aspect, 0, 0, 0],
        [0, f, 0, 0],
        [0, 0, (far + near) / (near - far), (2 * far * near) / (near - far)],
        [0, 0, -1, 0],
    ]);
}

/** The eye's space from the world's. */
function lookAt(eye, target, up) {
    const back = normalised(subtract(eye, target));
    const right = normalised(cross(up, back));
    const above = cross(back, right);
    return fromRows([
        [...right, -dot(right, eye)],
        [...above, -dot(above, eye)],
        [...back, -dot(back, eye)],
        [0, 0, 0, 1],
    ]);
}

/** Clip space of parallel light that covers a box, from the world's. @param direction of travel */
function alongLight(direction, low, high) {
    const middle = scaled(add(low, high), 0.5), half = 0.5 * lengthOf(subtract(high, low));
    const up = Math.abs(direction[2]) > 0.9 ? [0, 1, 0] : [0, 0, 1];
    const seen = lookAt(subtract(middle, scaled(direction, half)), middle, up);
    // What lies before the box towards the light casts shadows on it too: depth begins one box earlier.
    const square = fromRows([[1 / half, 0, 0, 0], [0, 1 / half, 0, 0], [0, 0, -1 / (1.5 * half), -1 / 3], [0, 0, 0, 1]]);
    return multiply(square, seen);
}
// SPDX-License-Identifier: Apache-2.0
// What the files beside the page hold. They are scripts, since a page that was opened by double click may load nothing else.

/** Bytes of a packed array: base64 of gzip of the numbers' first bytes, then their second ones, and so on. */
async function unpacked(text, bytes_a_number) {
    const letters = atob(text);
    const packed = Uint8Array.from({ length: letters.length }, (_, i) => letters.charCodeAt(i));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    const planes = new Uint8Array(await new Response(stream).arrayBuffer());
    const count = planes.length / bytes_a_number;
    const bytes = new Uint8Array(planes.length);
    for (let plane = 0; plane < bytes_a_number; ++plane) {
        const from = plane * count;
        for (let i = 0, to = plane; i < count; ++i, to += bytes_a_number) bytes[to] = planes[from + i];
    }
    return bytes.buffer;
}

/** Frames by number, each loaded once, when it is asked for. */
class FrameFiles {
    constructor(frames) {
        this.waiting = new Map();
        this.files = new Map(frames.map(({ frame, file }) => [frame, file]));
        window.photicFrame = (frame, data) => this.waiting.get(frame)?.resolve(data);
    }

    /** A promise of what the frame's file says, unpacked. */
    async load(frame) {
        const data = await new Promise((resolve, reject) => {
            this.waiting.set(frame, { resolve, reject });
            const script = document.createElement("script");
            script.src = this.files.get(frame);
            script.onerror = () => reject(new Error(`${script.src} cannot be read; keep all files of this page in one folder`));
            script.onload = () => script.remove();
            document.head.append(script);
        });
        this.waiting.delete(frame);
        const arrays = {};
        for (const name of ["light", "rgb", "light_2", "rgb_2", "heights"])
            arrays[name] = data[name] ? new Uint16Array(await unpacked(data[name], 2)) : null;
        return { ...data, ...arrays };
    }
}
// SPDX-License-Identifier: Apache-2.0
// The little of WebGL 2 that is needed: programs, meshes, textures, targets.

/** A program whose uniforms are set by name. */
class Program {
    constructor(gl, vertex, fragment) {
        this.gl = gl;
        this.name = gl.createProgram();
        for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
            const shader = gl.createShader(type);
            gl.shaderSource(shader, "#version 300 es\n" + text);
            gl.compileShader(shader);
            if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(gl.getShaderInfoLog(shader));
            gl.attachShader(this.name, shader);
        }
        ["a_position", "a_normal"].forEach((attribute, i) => gl.bindAttribLocation(this.name, i, attribute));
        gl.linkProgram(this.name);
        if (!gl.getProgramParameter(this.name, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(gl.getProgramInfoLog(this.name));
        this.uniforms = new Map();
        const count = gl.getProgramParameter(this.name, gl.ACTIVE_UNIFORMS) || 0;
        for (let i = 0; i < count; ++i) {
            const { name, type } = gl.getActiveUniform(this.name, i);
            this.uniforms.set(name, { type, at: gl.getUniformLocation(this.name, name) });
        }
    }

    use(values) {
        const gl = this.gl;
        gl.useProgram(this.name);
        let unit = 0;
        for (const [name, { type, at }] of this.uniforms) {
            const value = values[name];
            if (value === undefined) throw new Error(`no value for ${name}`);
            if (type === gl.SAMPLER_2D || type === gl.SAMPLER_3D) {
                gl.activeTexture(gl.TEXTURE0 + unit);
                gl.bindTexture(type === gl.SAMPLER_3D ? gl.TEXTURE_3D : gl.TEXTURE_2D, value);
                gl.uniform1i(at, unit++);
            } else if (type === gl.FLOAT) gl.uniform1f(at, value);
            else if (type === gl.INT || type === gl.BOOL) gl.uniform1i(at, value);
            else if (type === gl.FLOAT_VEC2) gl.uniform2fv(at, value);
            else if (type === gl.FLOAT_VEC3) gl.uniform3fv(at, value);
            else if (type === gl.FLOAT_VEC4) gl.uniform4fv(at, value);
            else if (type === gl.FLOAT_MAT4) gl.uniformMatrix4fv(at, false, value);
        }
    }
}

/** Triangles on the GPU. @param data positions, normals: Float32Array; triangles: Uint32Array */
class Mesh {
    constructor(gl, { positions, normals, triangles }) {
        this.gl = gl;
        this.count = triangles.length;
        this.array = gl.createVertexArray();
        gl.bindVertexArray(this.array);
        this.buffers = [positions, normals].map((values, i) => {
            const buffer = gl.createBuffer();
            gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
            gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
            gl.enableVertexAttribArray(i);
            gl.vertexAttribPointer(i, 3, gl.FLOAT, false, 0, 0);
            return buffer;
        });
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
        gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
        gl.bindVertexArray(null);
    }
    /** Other positions and normals, as many as before. */
    move(positions, normals) {
        [positions, normals].forEach((values, i) => {
            this.gl.bindBuffer(this.gl.ARRAY_BUFFER, this.buffers[i]);
            this.gl.bufferSubData(this.gl.ARRAY_BUFFER, 0, values);
        });
    }
    draw() {
        this.gl.bindVertexArray(this.array);
        this.gl.drawElements(this.gl.TRIANGLES, this.count, this.gl.UNSIGNED_INT, 0);
    }
}

function texture2d(gl, internal, width, height, format, type, data, filter) {
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, height, 0, format, type, data);
    for (const [key, value] of [["MIN_FILTER", filter], ["MAG_FILTER", filter], ["WRAP_S", gl.CLAMP_TO_EDGE], ["WRAP_T", gl.CLAMP_TO_EDGE]])
        gl.texParameteri(gl.TEXTURE_2D, gl["TEXTURE_" + key], value);
    return texture;
}

/** Half floats, linearly filtered. @param wraps of x, y, z: whether the texture repeats */
function texture3d(gl, [x, y, z], halves, wraps) {
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_3D, texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGBA16F, x, y, z, 0, gl.RGBA, gl.HALF_FLOAT, halves);
    gl.texParameteri(gl.TEXTURE_3D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_3D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    ["S", "T", "R"].forEach((axis, i) =>
        gl.texParameteri(gl.TEXTURE_3D, gl["TEXTURE_WRAP_" + axis], wraps[i] ? gl.REPEAT : gl.CLAMP_TO_EDGE));
    return texture;
}

/** Where a pass draws: a colour texture, with `samples` a multisampled one beside it and depth. */
class Target {
    constructor(gl, width, height, internal, samples) {
        Object.assign(this, { gl, width, height, samples });
        const type = internal === gl.RGBA16F ? gl.HALF_FLOAT : gl.UNSIGNED_BYTE;
        this.colour = texture2d(gl, internal, width, height, gl.RGBA, type, null, gl.LINEAR);
        this.frame = gl.createFramebuffer();
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.colour, 0);
        if (!samples) return;
        this.depth = texture2d(gl, gl.DEPTH_COMPONENT24, width, height, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, null, gl.NEAREST);
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.depth, 0);
        this.many = gl.createFramebuffer();
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.many);
        this.stores = [[gl.COLOR_ATTACHMENT0, internal], [gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24]].map(([attachment, format]) => {
            const store = gl.createRenderbuffer();
            gl.bindRenderbuffer(gl.RENDERBUFFER, store);
            gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);
            gl.framebufferRenderbuffer(gl.FRAMEBUFFER, attachment, gl.RENDERBUFFER, store);
            return store;
        });
    }
    begin() {
        this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, this.many || this.frame);
        this.gl.viewport(0, 0, this.width, this.height);
    }
    /** Makes the textures of what was drawn. */
    resolve() {
        const gl = this.gl, { width, height } = this;
        gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.many);
        gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, this.frame);
        for (const bit of [gl.COLOR_BUFFER_BIT, gl.DEPTH_BUFFER_BIT]) gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, bit, gl.NEAREST);
    }
    remove() {
        const gl = this.gl;
        for (const frame of [this.frame, this.many]) if (frame) gl.deleteFramebuffer(frame);
        for (const texture of [this.colour, this.depth]) if (texture) gl.deleteTexture(texture);
        for (const store of this.stores || []) gl.deleteRenderbuffer(store);
    }
}

/** A square of depths alone, for shadows. */
class DepthTarget {
    constructor(gl, side) {
        Object.assign(this, { gl, side });
        this.depth = texture2d(gl, gl.DEPTH_COMPONENT24, side, side, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, null, gl.NEAREST);
        this.frame = gl.createFramebuffer();
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.depth, 0);
        gl.drawBuffers([gl.NONE]);
    }
    begin() {
        const { gl, side } = this;
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
        gl.viewport(0, 0, side, side);
        gl.enable(gl.DEPTH_TEST);
        gl.clear(gl.DEPTH_BUFFER_BIT);
    }
}
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
// SPDX-License-Identifier: Apache-2.0
// Frames of a sequence on the GPU: loaded when their time comes, the ones longest unused given up.

const kMostTextureBytes = 400e6;
const kTextures = ["light", "rgb", "light_2", "rgb_2"];

class Frames {
    constructor(gl, scene) {
        Object.assign(this, { gl, scene, files: new FrameFiles(scene.frames), held: new Map(), loading: new Map(), clock: 0 });
        const period = scene.metadata.period || [0, 0, 0];
        // The texture stands straight in the world: its rows lie along x, y and z.
        this.period = [0, 1, 2].map((axis) => Math.abs(period[axis] / scene.world_from_texture[axis][axis]));
        this.wraps = this.period.map((width) => Math.abs(width - 1) < 1e-6);
        const texels = scene.texture_size.reduce((a, b) => a * b, 1);
        this.most = Math.max(3, Math.floor(kMostTextureBytes / (texels * (scene.coloured ? 32 : 16))));
        this.none = texture3d(gl, [1, 1, 1], new Uint16Array(4), [false, false, false]);
    }

    get count() { return this.scene.frames.length; }
    ready(index) { return this.held.get(index % this.count); }

    /** A promise of the frame, on the GPU. */
    load(index) {
        index %= this.count;
        if (this.held.has(index)) return Promise.resolve(this.held.get(index));
        if (!this.loading.has(index)) {
            this.loading.set(index, this.files.load(this.scene.frames[index].frame).then((data) => this.keep(index, data))
                .finally(() => this.loading.delete(index)));
        }
        return this.loading.get(index);
    }

    keep(index, data) {
        const { gl, scene } = this, frame = { used: ++this.clock };
        for (const name of kTextures) frame[name] = data[name] ? texture3d(gl, scene.texture_size, data[name], this.wraps) : this.none;
        if (data.heights) frame.heights = waterHeights(data);
        if (this.held.size >= this.most) {
            const [oldest, given] = [...this.held].reduce((a, b) => (a[1].used < b[1].used ? a : b));
            for (const name of kTextures) if (given[name] !== this.none) gl.deleteTexture(given[name]);
            this.held.delete(oldest);
        }
        this.held.set(index, frame);
        return frame;
    }

    /** What shaders need of the light between a frame and the next. */
    uniforms(now, next, blend) {
        now.used = next.used = ++this.clock;
        const textures = {};
        for (const name of kTextures) Object.assign(textures, { ["u_" + name]: now[name], [`u_${name}_next`]: next[name] });
        return {
            ...textures, u_blend: blend, u_opposed: now.light_2 !== this.none || next.light_2 !== this.none ? 1 : 0,
            u_texture_from_world: this.texture_from_world ??= inverse(fromRows(this.scene.world_from_texture)),
            u_size: this.scene.texture_size, u_period: this.period, u_coloured: this.scene.coloured ? 1 : 0,
        };
    }
}
// SPDX-License-Identifier: Apache-2.0
// Draws the scene: solids, the light in the water, the water's surface.

class View {
    constructor(canvas, scene) {
        const gl = canvas.getContext("webgl2", { antialias: false, depth: true, powerPreference: "high-performance" });
        if (!gl) throw new Error("This page needs WebGL 2, which this browser does not offer. Any browser since 2022 does; " +
                                 "where it is switched off, allow hardware acceleration in the settings.");
        const float = gl.getExtension("EXT_color_buffer_float");
        this.internal = float || gl.getExtension("EXT_color_buffer_half_float") ? gl.RGBA16F : gl.RGBA8;
        Object.assign(this, { gl, canvas, scene, measures: !!float, quality: 1 });
        const largest = gl.getParameter(gl.MAX_3D_TEXTURE_SIZE), side = Math.max(...scene.texture_size);
        if (side > largest) throw new Error(`The light is ${side} texels wide, and this device takes ${largest}. Export it with --budget, ` +
                                            "or bake it with a larger voxel_size.");
        this.solid = new Program(gl, kSolidVertex, kSolidFragment);
        this.shell = new Program(gl, kSolidVertex, kShellFragment);
        this.shade = new Program(gl, kSolidVertex, kShadowFragment);
        this.shadow = new DepthTarget(gl, 1024);
        this.shadow_from_world = alongLight(scene.light.direction, scene.domain.min, scene.domain.max);
        this.medium = new Program(gl, kScreenVertex, kMediumFragment);
        this.tint = new Program(gl, kSolidVertex, kTintFragment);
        this.display = new Program(gl, kScreenVertex, kDisplayFragment);
        this.frames = new Frames(gl, scene);
        this.ball = new Mesh(gl, ballData());
        this.screen = gl.createVertexArray();
        this.heights = texture2d(gl, gl.R16F, 1, 1, gl.RED, gl.FLOAT, new Float32Array(1), gl.LINEAR);
    }

    async prepare() {
        const { gl, scene } = this, plain = [0.8, 0.82, 0.84];
        const shaped = async (body) => new Mesh(gl, body.mesh ? await meshData(body.mesh) : planeData(body.plane));
        this.bodies = await Promise.all(scene.receivers.map(async (body) => ({ ...body, albedo: body.albedo || plain, shape: await shaped(body) })));
        this.shells = await Promise.all(scene.shells.map(async (body) => ({ ...body, shape: await shaped(body) })));
    }

    /** The water's heights at a moment, on the GPU. */
    moveWater(now, next, blend) {
        const { gl, scene: { water } } = this;
        if (!water || (this.water_at === now && this.water_next === next && this.water_blend === blend)) return;
        [this.water_at, this.water_next, this.water_blend] = [now, next, blend];
        const heights = now.heights.map((height, i) => height + blend * (next.heights[i] - height));
        const data = waterData(water, heights);
        if (this.water) this.water.move(data.positions, data.normals);
        else this.water = new Mesh(gl, data);
        gl.bindTexture(gl.TEXTURE_2D, this.heights);
        gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.R16F, water.side, water.side, 0, gl.RED, gl.FLOAT, heights);
    }

    resize() {
        const { gl, canvas } = this;
        const scale = Math.min(window.devicePixelRatio || 1, 2) * this.quality;
        const width = Math.max(2, Math.round(canvas.clientWidth * scale)), height = Math.max(2, Math.round(canvas.clientHeight * scale));
        if (this.target && canvas.width === width && canvas.height === height) return;
        Object.assign(canvas, { width, height });
        for (const old of [this.target, this.half, this.way]) old?.remove();
        const samples = Math.min(4, gl.getParameter(gl.MAX_SAMPLES));
        this.target = new Target(gl, width, height, this.internal, samples);
        this.half = new Target(gl, Math.ceil(width / 2), Math.ceil(height / 2), this.internal, 0);
        this.way = new Target(gl, width, height, this.internal, 0);
    }

    /** @param state camera, ball, moment and looks (8_page.js) */
    draw(state) {
        const { gl, scene } = this;
        this.resize();
        const { now, next, blend } = state.moment;
        this.moveWater(now, next, blend);
        const clip_from_world = state.camera.matrix(this.canvas.width / this.canvas.height);
        const water = scene.water;
        const values = {
            ...this.frames.uniforms(now, next, blend),
            u_clip_from_world: clip_from_world, u_world_from_clip: inverse(clip_from_world), u_eye: state.camera.eye,
            u_ball: [...state.ball.centre, state.ball.radius], u_heights: this.heights,
            u_water: water ? [...water.low, ...water.size] : [0, 0, 0, 0], u_level: water ? water.level : 0,
            u_box_low: scene.domain.min, u_box_high: scene.domain.max,
            u_sun_direction: scene.light.direction, u_sun_irradiance: scene.light.irradiance,
            u_extinction: scene.medium.absorption.map((a) => a * state.tint + state.haze),
            u_scattering: state.haze, u_anisotropy: scene.medium.anisotropy,
            u_exposure: 2.6 * 2 ** state.exposure,
            u_shadow: this.shadow.depth, u_shadow_from_world: this.shadow_from_world,
        };
        this.drawShadow(state);
        this.drawSolids(values, state);
        this.drawTint(values, state);
        this.half.begin();
        gl.disable(gl.DEPTH_TEST);
        gl.bindVertexArray(this.screen);
        this.medium.use({ ...values, u_depth: this.target.depth });
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
        gl.viewport(0, 0, this.canvas.width, this.canvas.height);
        gl.clear(gl.DEPTH_BUFFER_BIT);
        this.display.use({ ...values, u_depth: this.target.depth, u_colour: this.target.colour, u_medium: this.half.colour,
                           u_tint: this.way.colour });
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        this.drawShells(values, state);
    }

    /** What stands in the sun's way: meshes, glass, mirrors, and the ball. */
    drawShadow(state) {
        this.shadow.begin();
        const cast = (shape, place) => {
            this.shade.use({ u_clip_from_world: this.shadow_from_world, u_place: place });
            shape.draw();
        };
        for (const body of [...this.bodies.filter(({ plane }) => !plane), ...this.shells]) cast(body.shape, [0, 0, 0, 1]);
        cast(this.ball, [...state.ball.centre, state.ball.radius]);
    }

    drawSolids(values, state) {
        const { gl } = this, unmoved = [0, 0, 0, 1];
        this.target.begin();
        gl.enable(gl.DEPTH_TEST);
        gl.clearColor(0, 0, 0, 0);
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
        for (const body of this.bodies) {
            // The room is open towards the eye: a plane is drawn from its lit side alone.
            const { plane } = body;
            if (plane && dot(plane.normal, subtract(state.camera.eye, plane.corners[0])) <= 0) continue;
            this.solid.use({ ...values, u_place: unmoved, u_albedo: body.albedo, u_tile: plane ? this.scene.tile : 0,
                             u_two_sided: plane ? 0 : 1, u_is_ball: 0 });
            body.shape.draw();
        }
        this.solid.use({ ...values, u_place: [...state.ball.centre, state.ball.radius], u_albedo: [0.92, 0.9, 0.86], u_tile: 0,
                         u_two_sided: 0, u_is_ball: 1 });
        this.ball.draw();
        this.target.resolve();
    }

    /** How far one looks through wine and coloured glass. Eye rays go straight. */
    drawTint(values, state) {
        const { gl } = this;
        this.way.begin();
        gl.clearColor(0, 0, 0, 0);
        gl.clear(gl.COLOR_BUFFER_BIT);
        if (this.internal !== gl.RGBA16F) return;      // what cannot be below 0 cannot count
        gl.disable(gl.DEPTH_TEST);
        gl.enable(gl.BLEND);
        gl.blendFunc(gl.ONE, gl.ONE);
        for (const shell of this.shells) {
            if (!shell.absorption.some((a) => a > 0)) continue;
            this.tint.use({ ...values, u_place: [0, 0, 0, 1], u_depth: this.target.depth,
                            u_absorption: shell.absorption.map((a) => a * state.tint) });
            shell.shape.draw();
        }
        gl.disable(gl.BLEND);
    }

    drawShells(values, state) {
        const { gl } = this;
        gl.enable(gl.DEPTH_TEST);
        gl.enable(gl.BLEND);
        gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
        const common = { ...values, u_place: [0, 0, 0, 1], u_depth: this.target.depth };
        for (const shell of this.shells) {
            this.shell.use({ ...common, u_ior: shell.ior, u_mirror: shell.mirror || [0, 0, 0] });
            shell.shape.draw();
        }
        if (this.water && state.surface) {
            this.shell.use({ ...common, u_ior: this.scene.water.ior, u_mirror: [0, 0, 0] });
            this.water.draw();
        }
        gl.disable(gl.BLEND);
    }

    /**
     * Light at points of the first frame, as the page's own shaders look it up, in W/m2.
     * @param points [[x, y, z], ...] or [[x, y, z, nx, ny, nz], ...], unit normals
     * @return [{ irradiance: [r, g, b], flux: [x, y, z], face: [r, g, b] }, ...]
     */
    measure(points, frame) {
        const { gl } = this;
        if (!this.measures) throw new Error("this device draws no 32-bit floats, which measuring needs");
        this.measurer ??= new Program(gl, kScreenVertex, kMeasureFragment);
        const side = Math.ceil(Math.sqrt(points.length)), all = side * side;
        const table = (first) => {
            const numbers = new Float32Array(4 * all);
            points.forEach((point, i) => numbers.set(point.slice(first, first + 3), 4 * i));
            return texture2d(gl, gl.RGBA32F, side, side, gl.RGBA, gl.FLOAT, numbers, gl.NEAREST);
        };
        const inputs = [table(0), table(3)], outputs = [0, 1, 2].map(() => texture2d(gl, gl.RGBA32F, side, side, gl.RGBA, gl.FLOAT, null, gl.NEAREST));
        const target = gl.createFramebuffer();
        gl.bindFramebuffer(gl.FRAMEBUFFER, target);
        outputs.forEach((texture, i) => gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0));
        gl.drawBuffers(outputs.map((_, i) => gl.COLOR_ATTACHMENT0 + i));
        gl.viewport(0, 0, side, side);
        gl.disable(gl.DEPTH_TEST);
        this.measurer.use({ ...this.frames.uniforms(frame, frame, 0), u_points: inputs[0], u_normals: inputs[1] });
        gl.bindVertexArray(this.screen);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        const read = outputs.map((_, i) => {
            const numbers = new Float32Array(4 * all);
            gl.readBuffer(gl.COLOR_ATTACHMENT0 + i);
            gl.readPixels(0, 0, side, side, gl.RGBA, gl.FLOAT, numbers);
            return numbers;
        });
        gl.deleteFramebuffer(target);
        for (const texture of [...inputs, ...outputs]) gl.deleteTexture(texture);
        const reference = this.scene.metadata.reference_irradiance;
        const vector = (numbers, i) => [0, 1, 2].map((c) => numbers[4 * i + c] * reference);
        return points.map((_, i) => ({ irradiance: vector(read[0], i), flux: vector(read[1], i), face: vector(read[2], i) }));
    }
}
// SPDX-License-Identifier: Apache-2.0
// The page: the camera, the ball, time, sliders, and what hands do to them.

/** A camera that turns about what it looks at. */
class Camera {
    /** @param margin how much more than the scene's camera is seen */
    constructor({ eye, target, field_of_view }, margin) {
        this.first = { eye, target };
        Object.assign(this, { fov: field_of_view, margin });
        this.home();
    }
    home() {
        this.target = [...this.first.target];
        const back = subtract(this.first.eye, this.target);
        this.distance = this.first_distance = lengthOf(back);
        this.turn = Math.atan2(back[1], back[0]);
        this.rise = Math.asin(clamp(back[2] / this.distance, -1, 1));
    }
    get back() {
        const level = Math.cos(this.rise);
        return [level * Math.cos(this.turn), level * Math.sin(this.turn), Math.sin(this.rise)];
    }
    get eye() { return add(this.target, scaled(this.back, this.distance)); }
    get right() { return normalised(cross([0, 0, 1], this.back)); }
    get above() { return cross(this.back, this.right); }
    rotate(x, y) {
        this.turn -= x;
        this.rise = clamp(this.rise + y, -1.5, 1.5);
    }
    shift(x, y) { this.target = add(this.target, add(scaled(this.right, x), scaled(this.above, y))); }
    zoom(factor) { this.distance = clamp(this.distance * factor, 0.1 * this.first_distance, 4 * this.first_distance); }
    /** Held upright, a narrow screen sees as much of the scene's width as a wide one. */
    matrix(aspect) {
        const half = Math.tan((this.fov * Math.PI) / 360) * this.margin * Math.max(1, 1.2 / aspect);
        this.height = 2 * half;  // of the picture, at a metre
        const far = 8 * this.first_distance + this.distance;
        return multiply(perspective((2 * Math.atan(half) * 180) / Math.PI, aspect, far / 4000, far), lookAt(this.eye, this.target, [0, 0, 1]));
    }
    /** The ray through a place on the screen, -1..1. */
    ray(x, y, aspect) {
        const half = this.height / 2;
        return normalised(subtract(add(scaled(this.right, x * half * aspect), scaled(this.above, y * half)), this.back));
    }
}

class Page {
    constructor(scene) {
        this.scene = scene;
        this.element = (id) => document.getElementById(id);
        const query = new URLSearchParams(location.search);
        const numbers = (key, count) => {
            const list = (query.get(key) ?? "none").split(",").map(Number);
            return list.length === count && list.every(Number.isFinite) ? list : null;
        };
        document.title = scene.title;
        this.element("title").textContent = scene.title;
        this.element("made").textContent = `Light baked by ${scene.program}`;
        this.view = new View(this.element("view"), scene);
        // The time line takes some of the picture's lower edge.
        this.camera = new Camera(scene.camera, scene.frames.length > 1 ? 1.25 : 1.06);
        const eye = numbers("eye", 3), target = numbers("target", 3);
        if (eye || target) {
            this.camera.first = { eye: eye || scene.camera.eye, target: target || scene.camera.target };
            this.camera.home();
        }
        this.ball = { centre: numbers("ball", 3) || scene.ball.centre, radius: scene.ball.radius };
        this.exposure = numbers("exposure", 1)?.[0] ?? 0;
        this.haze = numbers("haze", 1)?.[0] ?? scene.medium.haze;
        this.tint = numbers("tint", 1)?.[0] ?? 1;
        this.surface = true;
        this.time = numbers("frame", 1)?.[0] ?? 0;
        this.playing = false;
        this.pointers = new Map();
    }

    async start() {
        await this.view.prepare();
        this.first = await this.view.frames.load(Math.floor(this.time));
        this.moment = { now: this.first, next: this.first, blend: 0 };
        this.controls();
        this.hands();
        this.element("message").hidden = true;
        this.element("panel").hidden = false;
        if (matchMedia("(max-width: 640px)").matches) this.element("panel").open = false;
        this.setTime(this.time);
        window.addEventListener("resize", () => this.redraw());
        this.redraw();
    }

    measure(points) { return this.view.measure(points, this.first); }

    redraw() {
        if (this.asked) return;
        this.asked = true;
        requestAnimationFrame((now) => {
            this.asked = false;
            this.pace(now);
            this.view.draw(this);
            this.drawn = (this.drawn || 0) + 1;
        });
    }

    /** While things move a slow device draws fewer pixels; at rest all of them. */
    pace(now) {
        const moving = this.pointers.size > 0 || this.playing;
        const took = now - (this.last || now);
        this.last = now;
        if (moving && took > 70 && took < 2000) this.view.quality = Math.max(0.35, this.view.quality * 0.8);
        else if (moving && took > 0 && took < 24) this.view.quality = Math.min(1, this.view.quality * 1.02);
        clearTimeout(this.rest);
        if (!moving && this.view.quality < 1) this.view.quality = 1;
        if (moving) this.rest = setTimeout(() => this.redraw(), 250);
    }

    controls() {
        const slider = (id, text, set) => {
            const input = this.element(id), output = this.element(id + "_value");
            const show = () => { output.textContent = text(Number(input.value)); };
            input.value = this[id];
            input.addEventListener("input", () => { this[id] = Number(input.value); show(); this.redraw(); });
            show();
        };
        this.element("haze").max = this.scene.medium.most_haze;
        this.element("haze").step = this.scene.medium.most_haze / 200;
        slider("exposure", (v) => `${v > 0 ? "+" : ""}${v.toFixed(1)} stops`);
        slider("haze", (v) => `${v.toPrecision(2)} / m`);
        slider("tint", (v) => `${Math.round(100 * v)} %`);
        this.element("tint").parentElement.hidden = !this.scene.water;
        this.element("home").addEventListener("click", () => { this.camera.home(); this.ball.centre = this.scene.ball.centre; this.redraw(); });
        const surface = this.element("surface");
        surface.hidden = !this.scene.water;
        surface.addEventListener("click", () => {
            this.surface = !this.surface;
            surface.setAttribute("aria-pressed", this.surface);
            this.redraw();
        });
        const still = this.scene.frames.length < 2;
        document.body.classList.toggle("still", still);
        this.element("time").hidden = still;
        this.element("moment").max = this.scene.frames.length - 1;
        this.element("moment").addEventListener("input", () => { this.play(false); this.setTime(Number(this.element("moment").value)); });
        this.element("play").addEventListener("click", () => this.play(!this.playing));
    }

    /** Shows a time, counted in frames from the first, once both frames beside it are there; asks for those that follow. */
    async setTime(time) {
        const { frames } = this.view;
        this.time = time;
        const index = Math.floor(time), blend = time - index;
        this.element("moment").value = time;
        this.element("moment_value").textContent = `frame ${this.scene.frames[index % frames.count].frame}`;
        try {
            const now = await frames.load(index), next = blend > 0 ? await frames.load(index + 1) : now;
            if (this.time !== time) return;
            this.moment = { now, next, blend };
            this.redraw();
            if (frames.count > 1) frames.load(index + 1).catch(() => {});
        } catch (error) {
            this.play(false);
            this.say(error.message);
        }
    }

    play(on) {
        this.playing = on;
        this.element("play").textContent = on ? "❚❚" : "▶";
        this.element("play").setAttribute("aria-label", on ? "Pause" : "Play");
        if (!on) return;
        let last = null;
        const step = async (now) => {
            if (!this.playing) return;
            const { frames } = this.view, passed = last === null ? 0 : Math.min(0.25, (now - last) / 1000);
            last = now;
            // Back to the first frame without a blend: most sequences do not close.
            let time = this.time + passed * this.scene.frame_rate;
            if (time >= frames.count - 1) time = 0;
            await this.setTime(time);
            requestAnimationFrame(step);
        };
        requestAnimationFrame(step);
    }

    say(text) {
        this.element("message").textContent = text;
        this.element("message").hidden = false;
    }

    /** Where a pointer is, -1..1, and the ray through it. */
    rayOf(event) {
        const box = this.element("view").getBoundingClientRect(), aspect = box.width / box.height;
        this.camera.matrix(aspect);
        const x = (2 * (event.clientX - box.left)) / box.width - 1, y = 1 - (2 * (event.clientY - box.top)) / box.height;
        return this.camera.ray(x, y, aspect);
    }

    /** The distance at which a ray meets the ball; a finger hits it a little beside it, too. */
    ballAlong(direction, slack) {
        const from = subtract(this.ball.centre, this.camera.eye), along = dot(from, direction);
        return along > 0 && lengthOf(subtract(from, scaled(direction, along))) <= this.ball.radius * slack ? along : null;
    }

    moveBall(centre) {
        const { min, max } = this.scene.domain, r = this.ball.radius;
        const inside = centre.map((v, axis) => clamp(v, min[axis] + r, max[axis] - r));
        // Not through planes: the ball rests on their lit side.
        for (const { plane } of this.scene.receivers) {
            if (!plane) continue;
            const height = dot(subtract(inside, plane.corners[0]), plane.normal);
            if (height < r) inside.forEach((v, axis) => { inside[axis] = v + (r - height) * plane.normal[axis]; });
        }
        this.ball.centre = inside;
        this.redraw();
    }

    hands() {
        const canvas = this.element("view"), { camera } = this;
        canvas.addEventListener("contextmenu", (event) => event.preventDefault());
        canvas.addEventListener("pointerdown", (event) => {
            canvas.focus({ preventScroll: true });
            if (event.isTrusted) canvas.setPointerCapture(event.pointerId);
            const direction = this.rayOf(event), far = this.ballAlong(direction, event.pointerType === "touch" ? 1.6 : 1.1);
            const grab = this.pointers.size === 0 && event.button === 0 && far !== null;
            const hit = grab ? add(camera.eye, scaled(direction, far)) : null;
            this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, far, offset: grab ? subtract(this.ball.centre, hit) : null,
                                                 shifts: event.button === 2 || event.shiftKey });
            canvas.classList.toggle("turning", !grab);
            this.element("hint").classList.add("done");
        });
        canvas.addEventListener("pointermove", (event) => {
            const pointer = this.pointers.get(event.pointerId);
            if (!pointer) return canvas.classList.toggle("over", this.ballAlong(this.rayOf(event), 1.1) !== null);
            this.drag(pointer, event, canvas.clientHeight);
            Object.assign(pointer, { x: event.clientX, y: event.clientY });
        });
        for (const end of ["pointerup", "pointercancel"]) {
            canvas.addEventListener(end, (event) => {
                this.pointers.delete(event.pointerId);
                canvas.classList.remove("turning");
                this.redraw();
            });
        }
        canvas.addEventListener("wheel", (event) => {
            event.preventDefault();
            camera.zoom(Math.exp(clamp(event.deltaY, -200, 200) * 0.0012));
            this.redraw();
        }, { passive: false });
        canvas.addEventListener("keydown", (event) => this.key(event));
    }

    drag(pointer, event, height) {
        const { camera } = this, x = event.clientX - pointer.x, y = event.clientY - pointer.y, metres = (camera.height * camera.distance) / height;
        const others = [...this.pointers.values()].filter((other) => other !== pointer);
        if (others.length === 1) {
            const before = Math.hypot(pointer.x - others[0].x, pointer.y - others[0].y), after = Math.hypot(event.clientX - others[0].x, event.clientY - others[0].y);
            if (before > 0 && after > 0) camera.zoom(before / after);
            camera.shift((-x * metres) / 2, (y * metres) / 2);
        } else if (pointer.offset) {
            // In the plane across the line of sight, at the distance at which it was taken.
            this.moveBall(add(add(camera.eye, scaled(this.rayOf(event), pointer.far)), pointer.offset));
        } else if (pointer.shifts) {
            camera.shift(-x * metres, y * metres);
        } else {
            camera.rotate(x * 0.006, y * 0.006);
        }
        this.redraw();
    }

    key(event) {
        const by = this.ball.radius * 0.4, { right, back } = this.camera;
        const ahead = normalised([-back[0], -back[1], 0]);
        const moves = { ArrowLeft: scaled(right, -by), ArrowRight: scaled(right, by), ArrowUp: scaled(ahead, by), ArrowDown: scaled(ahead, -by),
                        PageUp: [0, 0, by], PageDown: [0, 0, -by] };
        if (moves[event.key]) this.moveBall(add(this.ball.centre, moves[event.key]));
        else if (event.key === " " && this.scene.frames.length > 1) this.play(!this.playing);
        else if (event.key === "+" || event.key === "-") { this.camera.zoom(event.key === "+" ? 0.9 : 1.1); this.redraw(); }
        else return;
        event.preventDefault();
    }
}

window.photicScene = (scene) => {
    const fail = (error) => {
        const message = document.getElementById("message");
        message.textContent = error.message;
        message.hidden = false;
    };
    window.addEventListener("load", () => {
        try {
            if (typeof DecompressionStream === "undefined")
                throw new Error("This page needs DecompressionStream: Chrome 80, Safari 16.4, Firefox 113, or newer.");
            window.photic = new Page(scene);
            window.photic.started = window.photic.start();
            window.photic.started.catch(fail);
        } catch (error) {
            fail(error);
        }
    });
};
})();
