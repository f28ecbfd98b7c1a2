// SPDX-License-Identifier: Apache-2.0
// node ktx_parse.mjs FILE: what npm's ktx-parse finds in a KTX2 file, as JSON, the level's bytes as a sum.
// The package is looked for in $KTX_PARSE (an npm prefix).
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const require = createRequire(process.env.KTX_PARSE + "/");
const { read } = await import(pathToFileURL(require.resolve("ktx-parse")).href);

const container = read(new Uint8Array(readFileSync(process.argv[2])));
const level = container.levels[0].levelData;
const text = (v) => (typeof v === "string" ? v : new TextDecoder().decode(v).replace(/\0$/, ""));
console.log(JSON.stringify({
    vkFormat: container.vkFormat,
    typeSize: container.typeSize,
    size: [container.pixelWidth, container.pixelHeight, container.pixelDepth],
    counts: [container.layerCount, container.faceCount, container.levels.length, container.supercompressionScheme],
    bytes: level.byteLength,
    uncompressed: container.levels[0].uncompressedByteLength,
    sum: level.reduce((sum, byte, i) => (sum + byte * ((i % 65521) + 1)) % 4294967296, 0),
    descriptor: container.dataFormatDescriptor[0],
    keys: Object.fromEntries(Object.entries(container.keyValue).map(([key, value]) => [key, text(value)])),
}));
