// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <utility>

#include "bake/baker/bake_cost.h"
#include "bake/baker/bake_scene.h"
#include "bake/baker/bake_slabs.h"
#include "bake/baker/copy_frame.h"
#include "bake/baker/error_goal.h"
#include "bake/baker/lookup_advice.h"
#include "bake/baker/post_steps.h"
#include "bake/baker/version.h"
#include "bake/cli/bake_plan.h"
#include "bake/cli/json.h"
#include "bake/cli/stop.h"
#include "bake/cli/verbs.h"
#include "bake/field/scene_grid.h"
#include "bake/field/scene_needed_voxels.h"
#include "bake/file/output_set.h"
#include "bake/image/atomic_file.h"
#include "bake/methods/catalogue.h"
#include "bake/methods/kept_shapes.h"
#include "bake/report/error.h"
#include "bake/report/error_text.h"
#include "bake/scene/kept_meshes.h"
#include "bake/scene/load_toml.h"
#include "bake/scene/plausibility.h"
#include "bake/threads/parallel_for.h"

namespace photic::cli {

namespace {

namespace fs = std::filesystem;

double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

BakeChoices choicesOf(const BakeArguments& arguments) {
    if (arguments.detail && !(*arguments.detail > 0 && std::isfinite(*arguments.detail)))
        throw Error(ErrorCode::Usage, fmt::format("texels of {} m; they must be above 0", *arguments.detail),
                    "--detail");
    BakeChoices choices;
    const auto limit = [](const std::optional<double>& given, const char* option, double unit, double& to) {
        if (!given) return;
        if (!(*given > 0 && std::isfinite(*given)))
            throw Error(ErrorCode::Usage, fmt::format("{} is not possible; it must be above 0", *given), option);
        to = *given * unit;
    };
    limit(arguments.budget, "--budget", 1e6, choices.budget_bytes);
    limit(arguments.seconds, "--seconds", 1, choices.seconds);
    choices.post = arguments.post, choices.file = arguments.file, choices.max_memory_bytes = memoryAllowed();
    const auto measure = std::find(kMeasureNames.begin(), kMeasureNames.end(), arguments.measure);
    choices.measure = static_cast<Measure>(measure - kMeasureNames.begin());
    choices.detail = arguments.detail.value_or(0);
    choices.tile = arguments.tile;
    if (choices.tile) choices.measure = Measure::Nothing;  // what lies beside it is dark
    return choices;
}

/// The scene of a frame, with the settings of the command line.
Scene sceneOf(const BakeArguments& arguments, int frame, Terminal& terminal) {
    Scene scene = loadScene(arguments.scene, frame, terminal);
    applySettings(arguments, scene);
    return scene;
}

std::string standardErrorPath(const BakeArguments& arguments, int frame) {
    BakeArguments named = arguments;
    named.output = arguments.standard_error_file;
    return outputPath(named, frame);
}

/// True when `path` is a volume, or this tile of one, that was baked from these very inputs.
bool upToDate(const std::string& path, const std::string& hash, const std::optional<Tile>& tile) {
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored)) return false;
    try {
        const auto metadata = readVdb(path).metadata;
        const auto found = metadata.find("scene_hash");
        if (found == metadata.end() || found->second != hash) return false;
        const auto place = metadata.find("tile");
        if (!tile || place == metadata.end()) return !tile && place == metadata.end();
        const auto placed = readTile(place->second);
        return placed && placed->tile.name() == tile->name();
    } catch (const Error&) {
        return false;  // damaged: bake it again
    }
}

/// The report as people read it.
void summarise(Terminal& terminal, const std::string& output, const std::string& method, const GridFrame& frame,
               const BakeReport& report, std::int64_t file_bytes) {
    const glm::ivec3 size = frame.size();
    terminal.say(fmt::format("{}: {:.4g} of {:.4g} needed voxels lit ({} x {} x {}, {:.4g} mm), {:.1f} MB", output,
                             static_cast<double>(report.active_voxels), static_cast<double>(report.needed_voxels),
                             size.x, size.y, size.z, frame.worldFromIndex()[0].x * 1000,
                             static_cast<double>(file_bytes) * 1e-6));
    std::string stages;
    double total = 0;
    for (const auto& [stage, seconds] : report.seconds) {
        stages += fmt::format("{} {:.2f}, ", stage, seconds);
        total += seconds;
    }
    terminal.say(fmt::format("  {}{}{}, {} thread{}: {}together {:.2f} s", method,
                             report.instruction_set.empty() ? "" : ", ", report.instruction_set, report.threads,
                             report.threads == 1 ? "" : "s", stages, total));
    terminal.say(fmt::format("  power ledger off by {:.1e}, path ledger by {:.1e}", report.power.imbalance(),
                             report.path.imbalance()));
    if (!report.receivers.empty()) {
        terminal.say("  " + wordsOf(report.receivers));
        if (!report.advice.empty()) terminal.say("    " + report.advice);
    }
    if (!report.skipped.empty()) terminal.say(fmt::format("  skipped: {}", fmt::join(report.skipped, "; ")));
}

/// What was baked and is written, but for its last name.
struct Written {
    BakeReport report;
    GridFrame grid;
};

Written bakeWhole(const BakeArguments& arguments, const Scene& scene, const std::string& output, OutputSet& outputs,
                  Terminal& terminal, const BakeChoices& choices) {
    BakedScene baked = bakeToError(scene, terminal, choices);
    const auto start = std::chrono::steady_clock::now();
    terminal.progress("write", 0);
    if (!arguments.standard_error_file.empty())
        writeVdb(outputs, standardErrorPath(arguments, scene.frame), *baked.standard_error, arguments.file);
    // The volume last: whoever finds it finds its standard error too.
    baked.report.active_voxels = writeVdb(outputs, output, baked.volume, arguments.file);
    baked.report.seconds.emplace_back("write", secondsSince(start));
    return {std::move(baked.report), baked.volume.field.frame()};
}

/// As bakeWhole, a part after another.
Written bakeBySlabs(const BakeArguments& arguments, const Scene& scene, int slabs, CheckedFile& output,
                    Terminal& terminal, const BakeChoices& choices) {
    if (!arguments.standard_error_file.empty())
        throw Error(ErrorCode::Failed,
                    fmt::format("the bake does not fit its memory whole, and in {} slabs no standard error is written; "
                                "leave it out, use a larger voxel_size, or allow more memory",
                                slabs),
                    "--standard-error");
    terminal.note(fmt::format("the bake does not fit its memory whole, and is done in {} slabs", slabs));
    BakedSlabs baked = bakeInSlabs(scene, slabs, output, terminal, choices);
    return {std::move(baked.report), baked.frame};
}

/// Frames that a run has made or found, by what they show.
class KnownFrames {
public:
    struct Frame {
        std::string file, hash;
        std::uint64_t scene = 0;
    };
    const Frame* find(const Scene& scene, const std::string& settings) const {
        const auto found = frames_.find({scene.hash, settings});
        return found == frames_.end() ? nullptr : &found->second;
    }
    void add(const Scene& scene, const std::string& settings, const std::string& file, const std::string& hash) {
        frames_.insert_or_assign({scene.hash, settings}, Frame{file, hash, scene.hash});
    }
    /// Whether all frames showed the same.
    bool areEqual() const {
        return std::all_of(frames_.begin(), frames_.end(),
                           [&](const auto& entry) { return entry.second.scene == frames_.begin()->second.scene; });
    }

private:
    std::map<std::pair<std::uint64_t, std::string>, Frame> frames_;
};

/// One frame from file to file. Fills its report document as far as it comes.
/// @param kept_light  of the frame before; null for a frame alone
void bakeFrame(const BakeArguments& arguments, OutputSet& outputs, Terminal& terminal, KnownFrames& known,
               KeptLight* kept_light, Json& document) {
    const int frame_number = document["frame"].get<int>();
    const std::string output = document["output"].get<std::string>();
    BakeChoices choices = choicesOf(arguments);
    choices.kept_light = kept_light;
    auto start = std::chrono::steady_clock::now();
    terminal.progress("scene", 0);
    const FilesRead files;
    const Scene scene = sceneOf(arguments, frame_number, terminal);
    outputs.reads("a file of the scene", files.paths());
    const Method& method = chooseMethod(scene.bake.method, scene);
    const bool wants_error = !arguments.standard_error_file.empty();
    if (wants_error && method.standard_error == StandardError::Unknown) {
        throw Error(ErrorCode::Usage,
                    fmt::format("method '{}' knows no standard error; photic methods says which does", method.name),
                    "--standard-error");
    }
    const std::string hash = inputHash(scene, method, choices), settings = settingsText(scene, method, choices);
    document["scene_hash"] = hash;
    document["settings"] = Json::parse(settings);
    const bool kept = (arguments.frames || arguments.tile) && !arguments.force &&
                      upToDate(output, hash, arguments.tile) &&
                      (!wants_error || fs::exists(standardErrorPath(arguments, frame_number)));
    if (kept) {
        terminal.say(output + ": unchanged, kept");
        document["up_to_date"] = true;
        known.add(scene, settings, output, hash);
        return;
    }
    terminal.checkCancelled();
    // A sea that has come round, or a scene that stands still: as one of the frames before, but for its number.
    const KnownFrames::Frame* same = wants_error || arguments.force ? nullptr : known.find(scene, settings);
    if (same && copyFrame(same->file, same->hash, outputs.open(output), frame_number, hash)) {
        const std::int64_t bytes = outputs.pendingBytes(output);
        outputs.commit();
        terminal.expect({{"copy", 1}});
        terminal.progress("copy", 1);
        terminal.say(fmt::format("{}: as {}, copied", output, same->file));
        document["copied_from"] = same->file, document["file_bytes"] = bytes;
        known.add(scene, settings, output, hash);
        return;
    }
    outputs.discard();
    const double scene_seconds = secondsSince(start);

    const std::vector<std::string> scene_warnings = terminal.takeWarnings();
    choices.expect = [&terminal](const std::vector<Stage>& stages) { terminal.expect(stages); };
    const int slabs = slabsToFit(scene, terminal, choices).slabs;
    if (slabs > 1 && kept_light) kept_light->clear();
    Written written = slabs > 1 ? bakeBySlabs(arguments, scene, slabs, outputs.open(output), terminal, choices)
                                : bakeWhole(arguments, scene, output, outputs, terminal, choices);
    BakeReport& report = written.report;
    report.seconds.insert(report.seconds.begin(), {"scene", scene_seconds});
    report.warnings.insert(report.warnings.begin(), scene_warnings.begin(), scene_warnings.end());
    terminal.takeWarnings();
    const std::int64_t file_bytes = outputs.pendingBytes(output);
    outputs.commit();
    terminal.progress("write", 1);

    summarise(terminal, output, method.name, written.grid, report, file_bytes);
    document["grid"] = toJson(written.grid);
    document["file_bytes"] = file_bytes;
    if (slabs > 1) document["slabs"] = slabs;
    document.update(toJson(report));
    known.add(scene, settings, output, hash);
}

/// Names every file that the run will write, so that what cannot be written is refused before any work.
void claimOutputs(const BakeArguments& arguments, const FrameRange& range, OutputSet& outputs) {
    outputs.reads("the scene", arguments.scene);
    if (!arguments.report_file.empty()) outputs.writes("the report", arguments.report_file);
    for (int frame = range.first; frame <= range.last; ++frame) {
        outputs.writes("the volume", outputPath(arguments, frame));
        if (!arguments.standard_error_file.empty())
            outputs.writes("the standard error", standardErrorPath(arguments, frame));
    }
}

Json errorJson(const Error& error) {
    return {{"code", static_cast<int>(error.code())}, {"where", error.where()}, {"message", error.what()}};
}

/// What failed of a sequence whose other frames went well.
class Failures {
public:
    void add(int frame, const Error& error, Terminal& terminal) {
        frames_.push_back(std::to_string(frame));
        terminal.takeWarnings();  // of this frame, and not of the next
        terminal.warn(fmt::format("frame {} failed: {}", frame, errorText(error)));
        terminal.takeWarnings();
    }
    /// @throws Error{Input} when there are any
    void raise(const char* others) const {
        if (frames_.empty()) return;
        throw Error(ErrorCode::Input, fmt::format("frame{} {} failed; {}", frames_.size() == 1 ? "" : "s",
                                                  fmt::join(frames_, ", "), others));
    }

private:
    std::vector<std::string> frames_;
};

/// Looks at the inputs of all frames. Returns the scene of the first that can be read.
Scene checkInputs(const BakeArguments& arguments, const FrameRange& range, Terminal& terminal, Failures& failures) {
    std::optional<Scene> first;
    for (int frame = range.first; frame <= range.last; ++frame) {
        terminal.checkCancelled();
        try {
            Scene scene = sceneOf(arguments, frame, terminal);
            chooseMethod(scene.bake.method, scene);
            if (!first) first = std::move(scene);
        } catch (const Error& error) {
            if (!arguments.frames || error.code() != ErrorCode::Input) throw;
            failures.add(frame, error, terminal);
        }
    }
    if (!first) failures.raise("no frame can be baked");
    return std::move(*first);
}

/// As slabsToFit; none where the bake would be refused.
SlabPlan slabsIfAny(const Scene& scene, Terminal& terminal, const BakeChoices& choices) {
    try {
        if (!choices.tile) return slabsToFit(scene, terminal, choices);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::Failed) throw;
    }
    return {0, {}};
}

int dryRun(const BakeArguments& arguments, const FrameRange& range, Terminal& terminal) {
    const int frames = range.last - range.first + 1;
    const std::string output = outputPath(arguments, range.first);
    const BakeChoices choices = choicesOf(arguments);
    Failures failures;
    const Scene scene = checkInputs(arguments, range, terminal, failures);
    const Method& method = chooseMethod(scene.bake.method, scene);
    for (const std::string& warning : sceneWarnings(scene)) terminal.warn(warning);
    const GridFrame frame = sceneFrame(scene);
    BakeCost cost = bakeCost(scene, method, frame, nullptr, choices);
    const std::int64_t limit = memoryLimit(choices);
    if (choices.tile || (scene.bake.where != Where::Everywhere && cost.leaves < limit / 100)) {
        auto needed = std::make_shared<const NeededVoxels>(sceneNeededVoxels(scene, frame, terminal));
        if (choices.tile) needed = cutTile(scene, method, std::move(needed), *choices.tile, choices.post);
        cost = bakeCost(scene, method, frame, needed.get(), choices);
    }
    const SlabPlan plan = cost.memory_bytes <= limit ? SlabPlan{} : slabsIfAny(scene, terminal, choices);
    const int slabs = plan.slabs;
    // All light is traced for each slab.
    const double seconds = (slabs > 1 ? slabs * plan.each.seconds() : cost.seconds()) * frames;
    terminal.say(
        fmt::format("{}: about {:.4g} of {:.4g} voxels needed in {:.4g} leaves, {:.0f} MB of memory{}, {:.0f} MB on "
                    "disk, {:.2g} s{} with {} on {} threads (an estimate, good to a factor of two on a quiet machine)",
                    output, static_cast<double>(cost.needed_voxels), static_cast<double>(frame.voxelCount()),
                    static_cast<double>(cost.leaves), static_cast<double>(cost.memory_bytes) * 1e-6,
                    slabs == 1  ? ""
                    : slabs > 1 ? fmt::format(" (more than there is: it would be baked in {} slabs)", slabs)
                                : " (more than there is: it would be refused)",
                    static_cast<double>(cost.file_bytes) * 1e-6, seconds,
                    frames > 1 ? fmt::format(" for {} frames", frames) : "", method.name, threadCount()));
    if (const double goal = errorGoal(scene.bake); goal > 0)
        terminal.say(fmt::format("  that is for voxels of {:.3g} mm; the bake chooses its own for an error of {:g} %",
                                 1000 * scene.domain.voxel_size, 100 * goal));
    if (!cost.dearest.empty()) terminal.say("  " + cost.dearest);
    if (arguments.json) {
        print({{"schema", "photic-estimate-1"},
               {"scene", arguments.scene},
               {"output", output},
               {"method", method.name},
               {"frames", frames},
               {"grid", toJson(frame)},
               {"box", {{"min", toJson(scene.domain.min)}, {"max", toJson(scene.domain.max)}}},
               {"voxels", frame.voxelCount()},
               {"needed_voxels", cost.needed_voxels},
               {"leaves", cost.leaves},
               {"memory_bytes", cost.memory_bytes},
               {"memory_limit_bytes", limit},
               {"fits", slabs > 0},
               {"slabs", slabs},
               {"file_bytes", cost.file_bytes},
               {"seconds", seconds},
               {"dearest", cost.dearest}});
    }
    failures.raise("the others can be read");
    return 0;
}

Json newDocument(const BakeArguments& arguments, int frame) {
    Json document{{"schema", "photic-report-1"}, {"program", programName()},
                  {"scene", arguments.scene},    {"frame", frame},
                  {"up_to_date", false},         {"output", outputPath(arguments, frame)}};
    if (arguments.tile) document["tile"] = arguments.tile->name();
    return document;
}

/// Bakes all frames; those whose inputs cannot be used are told and left out.
void bakeFrames(const BakeArguments& arguments, const FrameRange& range, OutputSet& outputs, Terminal& terminal,
                Json& documents) {
    Failures failures;
    KnownFrames known;
    // Meshes that stay as they are, and what is built of them, serve all frames.
    const KeptMeshes meshes;
    const KeptShapes shapes;
    KeptLight light;
    for (int frame = range.first; frame <= range.last; ++frame) {
        terminal.checkCancelled();
        terminal.beginPart(frame - range.first, range.last - range.first + 1);
        Json& document = documents.emplace_back(newDocument(arguments, frame));
        try {
            bakeFrame(arguments, outputs, terminal, known, range.first < range.last ? &light : nullptr, document);
        } catch (const Error& error) {
            outputs.discard();
            document["error"] = errorJson(explained(error));
            if (!arguments.frames || error.code() != ErrorCode::Input) throw;
            failures.add(frame, error, terminal);
        } catch (const std::bad_alloc&) {
            outputs.discard();
            document["error"] = errorJson(Error(ErrorCode::Failed, "out of memory"));
            throw;
        }
        if (arguments.frames) {
            terminal.event(
                dump({{"event", "frame"}, {"frame", frame}, {"output", document["output"]}, {"report", document}}));
        }
    }
    failures.raise("the others are baked");
    if (range.first < range.last && known.areEqual()) {
        terminal.warn(
            fmt::format("nothing in {} changes from frame {} to {}, and the volumes are equal; number the "
                        "frames of a file with ####, or give waves a speed",
                        arguments.scene, range.first, range.last));
    }
}

/// Whether there is a file that is no report of a bake.
bool isOtherFile(const std::string& path) {
    std::error_code none;
    if (!fs::exists(path, none)) return false;
    std::string begin(200, '\0');
    std::ifstream(path, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
    return begin.find("\"photic-report-") == std::string::npos;
}

}  // namespace

int run(const BakeArguments& arguments, Terminal& terminal) {
    checkPostSteps(arguments.post);
    const FrameRange range = arguments.frames.value_or(FrameRange{});
    if (arguments.dry_run) return dryRun(arguments, range, terminal);
    OutputSet outputs;
    claimOutputs(arguments, range, outputs);

    // The report tells what was done and what was not, whatever the end. A bake that failed may not have come to all
    // files of its scene, so that the report's name could be one of them.
    Json documents = Json::array();
    const auto tell = [&](bool failed) {
        if (documents.empty()) return;
        const Json& report = arguments.frames ? documents : documents.front();
        if (!arguments.report_file.empty() && !(failed && isOtherFile(arguments.report_file))) {
            outputs.write(arguments.report_file, dump(report, 2) + "\n");
            outputs.commit();
        }
        if (arguments.json) print(report);
    };
    try {
        bakeFrames(arguments, range, outputs, terminal, documents);
    } catch (...) {
        tell(true);
        throw;
    }
    tell(false);
    Json written = Json::array();
    for (const Json& document : documents) written.push_back(document["output"]);
    terminal.event(
        dump({{"event", "done"}, {"output", written.back()}, {"outputs", written}, {"report", documents.back()}}));
    return 0;
}

}  // namespace photic::cli
