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
