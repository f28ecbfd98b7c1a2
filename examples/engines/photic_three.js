// SPDX-License-Identifier: Apache-2.0
// three.js: reads NAME.ktx2 of `photic export` (and NAME_rgb.ktx2 of a coloured volume), and looks it up in a shader.
import * as THREE from "three";

/** The texture and metadata of a .ktx2: its header is fixed (docs/files.md), so that no loader is needed. */
async function readKtx2(url) {
    const bytes = await (await fetch(url)).arrayBuffer(), view = new DataView(bytes);
    if (view.getUint32(12, true) !== 97) throw new Error(`${url} is no .ktx2 of photic export`);
    const [width, height, depth] = [20, 24, 28].map((at) => view.getUint32(at, true));
    const first = Number(view.getBigUint64(80, true));
    const texture = new THREE.Data3DTexture(new Uint16Array(bytes, first, 4 * width * height * depth), width, height, depth);
    Object.assign(texture, { format: THREE.RGBAFormat, type: THREE.HalfFloatType, minFilter: THREE.LinearFilter, magFilter: THREE.LinearFilter,
                             unpackAlignment: 1, needsUpdate: true });
    const text = new TextDecoder();
    let metadata = null;
    for (let at = view.getUint32(56, true), end = at + view.getUint32(60, true); at < end;) {
        const length = view.getUint32(at, true), [key, value] = text.decode(new Uint8Array(bytes, at + 4, length)).split("\0");
        if (key === "photic") metadata = JSON.parse(value);
        at += 4 + ((length + 3) & ~3);
    }
    return { texture, size: new THREE.Vector3(width, height, depth), metadata };
}

/** Uniforms of photicGlsl. The world is Photic's: metres, Z up (turn the scene, or camera.up.set(0, 0, 1)). */
export async function loadPhotic(url) {
    const { texture, size, metadata } = await readKtx2(url);
    const rgb = metadata.rgb_texture ? (await readKtx2(new URL(metadata.rgb_texture, new URL(url, document.baseURI)))).texture : texture;
    const world_from_texture = new THREE.Matrix4().set(...metadata.world_from_texture.flat());
    return {
        photic_light: { value: texture }, photic_rgb: { value: rgb }, photic_coloured: { value: rgb !== texture },
        photic_size: { value: size }, photic_reference: { value: metadata.reference_irradiance },
        photic_texture_from_world: { value: world_from_texture.invert() },
    };
}

/** For fragment shaders of GLSL 3 (ShaderMaterial with glslVersion: THREE.GLSL3). */
export const photicGlsl = `
precision highp sampler3D;
uniform sampler3D photic_light, photic_rgb;
uniform bool photic_coloured;
uniform vec3 photic_size;
uniform float photic_reference;
uniform mat4 photic_texture_from_world;

/** What a face gets [W/m2]. */
vec3 photicIrradiance(vec3 world, vec3 normal) {
    vec3 place = (photic_texture_from_world * vec4(world, 1.0)).xyz;
    vec3 fade = clamp(min(place, 1.0 - place) * photic_size + 0.5, 0.0, 1.0);  // no border in WebGL
    vec4 light = texture(photic_light, place) * (fade.x * fade.y * fade.z * photic_reference);
    float lit = max(0.0, -dot(normal, light.xyz));
    if (!photic_coloured || light.w <= 0.0) return vec3(lit);
    return texture(photic_rgb, place).rgb * (fade.x * fade.y * fade.z * photic_reference * lit / light.w);
}
`;
