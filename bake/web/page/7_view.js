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
