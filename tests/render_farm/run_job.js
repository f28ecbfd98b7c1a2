// SPDX-License-Identifier: Apache-2.0
// run_job.js JOB_TYPE PHOTIC SCENE OUTPUT FRAMES TILES [OPTION]...: compiles a Flamenco job as Flamenco Manager does, its
// documented interface mocked (author.Task, author.Command, job.addTask, task.addDependency, frameChunker), checks what
// comes of it, and runs the tasks in an order that their dependencies allow.
"use strict";
const assert = require("assert");
const child_process = require("child_process");
const fs = require("fs");
const vm = require("vm");

const [file, photic, scene, output, frames, tiles, ...options] = process.argv.slice(2);

function makeInterface() {
    const tasks = [];
    return {
        tasks,
        job: { addTask: task => tasks.push(task) },
        author: {
            Task: (name, type) => {
                const task = { name, type, commands: [], dependencies: [] };
                task.addCommand = command => task.commands.push(command);
                task.addDependency = other => task.dependencies.push(other);
                return task;
            },
            Command: (name, parameters) => ({ name, parameters }),
        },
        // "1-3,7" in chunks of so many frames, each written as a range.
        frameChunker: (text, size) => {
            const all = [];
            for (const range of text.split(",")) {
                const [first, last] = range.split("-").map(Number);
                for (let frame = first; frame <= (last === undefined ? first : last); ++frame) all.push(frame);
            }
            const chunks = [];
            for (let i = 0; i < all.length; i += size) {
                const chunk = all.slice(i, i + size);
                chunks.push(chunk.length === 1 ? String(chunk[0]) : `${chunk[0]}-${chunk[chunk.length - 1]}`);
            }
            return chunks;
        },
    };
}

function compile(settings) {
    const flamenco = makeInterface();
    const context = vm.createContext({ author: flamenco.author, frameChunker: flamenco.frameChunker, print: () => {} });
    vm.runInContext(fs.readFileSync(file, "utf8") + "\n;globalThis.JOB_TYPE = JOB_TYPE;", context);
    const types = { string: "string", int32: "number", float: "number", bool: "boolean" };
    const given = {};
    for (const setting of context.JOB_TYPE.settings) {
        assert(types[setting.type], `setting ${setting.key} is of an unknown type ${setting.type}`);
        assert(setting.required || setting.default !== undefined, `setting ${setting.key} has no default`);
        given[setting.key] = settings[setting.key] !== undefined ? settings[setting.key] : setting.default;
        assert.strictEqual(typeof given[setting.key], types[setting.type], setting.key);
    }
    for (const key of Object.keys(settings)) assert(key in given, `no setting ${key}`);
    flamenco.job.settings = given;
    context.compileJob(flamenco.job);
    return flamenco.tasks;
}

// One frame whole, and one that does not move in tiles.
const plain = compile({ scene: "a.toml", output: "out/a.vdb", photic: "/photic" });
assert.deepEqual(plain.map(task => task.commands[0].parameters),
                 [{ exe: "/photic", args: ["bake", "a.toml", "-o", "out/a.vdb", "--progress=none"] }]);
const still = compile({ scene: "a.toml", output: "out/a.vdb", tiles: 12 });
assert.strictEqual(still.length, 13);
assert.strictEqual(still[12].commands[0].parameters.args[3], "out/a.tile03of12.vdb");
assert.throws(() => compile({ scene: "a.toml", output: "a.nvdb" }), /\.vdb/);

const tasks = compile({ scene, output, frames, tiles: Number(tiles), options: options.join(" "), photic });
const done = new Set();
while (done.size < tasks.length) {
    // The last that may run: what relies on the order of tasks alone is found out.
    const next = tasks.filter(task => !done.has(task) && task.dependencies.every(other => done.has(other))).pop();
    assert(next, "tasks wait for one another");
    for (const command of next.commands) {
        assert.strictEqual(command.name, "exec");
        child_process.execFileSync(command.parameters.exe, command.parameters.args, { stdio: ["ignore", "ignore", "inherit"] });
    }
    done.add(next);
}
