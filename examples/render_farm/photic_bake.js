// SPDX-License-Identifier: Apache-2.0
// A job type of Flamenco 3 (https://flamenco.blender.org/usage/job-types/): copy this file into the folder `scripts`
// beside flamenco-manager, and "Photic Bake" is offered. One task for each tile of each frame, and one for each frame
// that joins its tiles. A task that fails is given to other workers by Flamenco; what is baked already is kept.

const JOB_TYPE = {
    label: "Photic Bake",
    description: "Bake caustics of a scene into light volumes, frame by frame and tile by tile",
    settings: [
        { key: "scene", type: "string", subtype: "file_path", required: true,
          description: "Scene file (.toml or .glb), where all workers see it" },
        { key: "output", type: "string", subtype: "file_path", required: true,
          description: "Volume to write (.vdb); #### is the frame's number" },
        { key: "frames", type: "string", default: "",
          description: "Frames, for instance 1-48 or 1,3,10-20; empty for a scene that does not move" },
        { key: "tiles", type: "int32", default: 1, propargs: { min: 1, max: 100000 },
          description: "Tiles that each frame is shared out in" },
        { key: "options", type: "string", default: "",
          description: "Further options of photic bake, for instance --resolution 256" },
        { key: "photic", type: "string", default: "{photic}", visible: "submission",
          description: "The program: a path, or a variable of Flamenco's" },
    ],
};

function compileJob(job) {
    const settings = job.settings;
    const tiles = Math.max(1, settings.tiles);
    if (!settings.output.endsWith(".vdb")) throw new Error("the output must end in .vdb: " + settings.output);
    // Chunks of one frame each, as Flamenco's own job types make them.
    const frames = settings.frames ? frameChunker(settings.frames, 1) : [null];
    for (const frame of frames) addFrame(job, settings, tiles, frame);
}

function addFrame(job, settings, tiles, frame) {
    const name = frame === null ? settings.output : frameName(settings.output, frame);
    const of_frame = frame === null ? "" : `-${frame}`;
    const bakes = [];
    for (let tile = 1; tile <= tiles; ++tile) {
        const task = author.Task(tiles > 1 ? `bake${of_frame}-tile-${tile}` : `bake${of_frame}`, "misc");
        const args = ["bake", settings.scene, "-o", settings.output, "--progress=none"];
        if (frame !== null) args.push("--frames", frame);
        if (tiles > 1) args.push("--tile", `${tile}/${tiles}`);
        task.addCommand(author.Command("exec", { exe: settings.photic, args: args.concat(words(settings.options)) }));
        job.addTask(task);
        bakes.push(task);
    }
    if (tiles === 1) return;
    const merge = author.Task(`merge${of_frame}`, "misc");
    const files = bakes.map((_, i) => tileName(name, i + 1, tiles));
    merge.addCommand(author.Command("exec", {
        exe: settings.photic, args: ["merge"].concat(files, ["-o", name, "--progress=none"]) }));
    for (const task of bakes) merge.addDependency(task);
    job.addTask(merge);
}

// As photic names them: waves.0007.vdb, or the number in place of ####.
function frameName(output, frame) {
    const slash = Math.max(output.lastIndexOf("/"), output.lastIndexOf("\\")) + 1;
    const folder = output.slice(0, slash), file = output.slice(slash);
    const marks = file.match(/#+/);
    if (marks) return folder + file.replace(marks[0], frame.padStart(marks[0].length, "0"));
    return folder + file.slice(0, -4) + "." + frame.padStart(4, "0") + ".vdb";
}

function tileName(name, tile, tiles) {
    const count = String(tiles);
    return name.slice(0, -4) + ".tile" + String(tile).padStart(count.length, "0") + "of" + count + ".vdb";
}

function words(text) {
    return text.split(" ").filter(word => word !== "");
}
