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
