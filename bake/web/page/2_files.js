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
