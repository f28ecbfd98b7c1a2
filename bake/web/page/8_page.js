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
