// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "bake/cli/bake_plan.h"
#include "bake/cli/json.h"
#include "bake/cli/post_steps.h"
#include "bake/cli/verbs.h"
#include "bake/cli/version.h"
#include "bake/field/density.h"
#include "bake/field/prefilter.h"
#include "bake/field/scene_grid.h"
#include "bake/field/scene_needed_voxels.h"
#include "bake/file/output_set.h"
#include "bake/image/atomic_file.h"
#include "bake/methods/catalogue.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"
#include "bake/threads/parallel_for.h"

namespace photic::cli {

namespace {

namespace fs = std::filesystem;

/// Seconds since its start, or since the last call.
class Stopwatch {
public:
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
    }

private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

double iorOfMedium(const Scene& scene) {
    for (const Surface& surface : scene.surfaces) {
        if (surface.event != SurfaceEvent::Reflect) return surface.ior_below;
    }
    return 1.0;
}

/// A number, or the three of its channels where they differ.
std::string perChannel(const glm::dvec3& v) {
    return v.x == v.y && v.y == v.z ? fmt::format("{}", v.x) : fmt::format("[{},{},{}]", v.x, v.y, v.z);
}

/// After how much [m] along x and y the light repeats, or 0: the water does, nothing that blocks breaks it, and a whole
/// period is in the box.
glm::dvec2 periodOfLight(const Scene& scene) {
    if (scene.surfaces.empty()) return glm::dvec2(0);
    const glm::dvec2 period = scene.surfaces.front().size;
    for (const Surface& surface : scene.surfaces) {
        if (!surface.height_field || surface.outside != Outside::Periodic || surface.size != period)
            return glm::dvec2(0);
    }
    for (const Object& object : scene.objects) {
        const Plane* plane = std::get_if<Plane>(&object.shape);
        if (object.blocks() && (!plane || plane->normal.x != 0 || plane->normal.y != 0)) return glm::dvec2(0);
    }
    const glm::dvec2 size(scene.domain.max - scene.domain.min);
    const double half_voxel = 0.5 * scene.domain.voxel_size;
    return size.x + half_voxel >= period.x && size.y + half_voxel >= period.y ? period : glm::dvec2(0);
}

/// What a run-time reader needs of the scene: its medium, and how the light repeats.
void addSceneMetadata(const Scene& scene, std::map<std::string, std::string>& metadata) {
    if (scene.medium.present()) {
        metadata["scattering"] = perChannel(scene.medium.scattering);
        metadata["absorption"] = perChannel(scene.medium.absorption);
        metadata["anisotropy"] = fmt::format("{}", scene.medium.anisotropy);
    }
    if (const glm::dvec2 period = periodOfLight(scene); period != glm::dvec2(0))
        metadata["period"] = fmt::format("[{},{},0]", period.x, period.y);
}

/// True when `path` is a volume that was baked from these very inputs.
bool upToDate(const std::string& path, const std::string& hash) {
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored)) return false;
    try {
        const auto metadata = readVdb(path).metadata;
        const auto found = metadata.find("scene_hash");
        return found != metadata.end() && found->second == hash;
    } catch (const Error&) {
        return false;  // damaged: bake it again
    }
}

/// A volume as it is written, from a result whose field is moved out.
LightVolume makeVolume(const Scene& scene, const Method& method, const Json& settings, const std::string& hash,
                       BakeResult& result) {
    const GridSet& grids = scene.bake.grids;
    LightVolume volume{std::move(result.field), scene.referenceIrradiance(), grids.irradiance, grids.direction, {}, {}};
    if (grids.caustic && result.caustic) volume.scalars.emplace("caustic", std::move(*result.caustic));
    if (grids.arrival_time && result.arrival_time)
        volume.scalars.emplace("arrival_time", std::move(*result.arrival_time));
    if (grids.density) volume.scalars.emplace("density", mediumDensity(scene, volume.field.neededPtr()));
    volume.metadata = {{"version", "1"},
                       {"program", std::string("photic ") + kVersion},
                       {"method", method.name},
                       {"options", dump(settings)},
                       {"paths", scene.bake.paths == Paths::All ? "all" : "caustic"},
                       {"quadrature", fmt::format("{}", scene.bake.quadrature)},
                       {"prefilter", scene.bake.prefilter ? "true" : "false"},
                       {"reference_irradiance", fmt::format("{}", volume.reference_irradiance)},
                       {"ior", fmt::format("{}", iorOfMedium(scene))},
                       {"up_axis", "Z"},
                       {"frame", fmt::format("{}", scene.frame)},
                       {"ledger", dump(ledgerJson(result.report))},
                       {"scene_hash", hash}};
    addSceneMetadata(scene, volume.metadata);
    for (const auto& [name, text] : result.metadata) {
        if (text.empty()) {
            volume.metadata.erase(name);
        } else {
            volume.metadata[name] = text;
        }
    }
    return volume;
}

std::string standardErrorPath(const BakeArguments& arguments, int frame) {
    BakeArguments named = arguments;
    named.output = arguments.standard_error_file;
    return outputPath(named, frame);
}

void writeStandardError(OutputSet& outputs, const std::string& path, BakeResult& result, const Method& method,
                        const BakeArguments& arguments) {
    if (!result.standard_error) {
        throw Error(ErrorCode::Usage,
                    fmt::format("method '{}' knows no standard error; use --method photons", method.name),
                    "--standard-error");
    }
    LightVolume volume{std::move(*result.standard_error), result.report.reference_irradiance, true, false, {}, {}};
    volume.metadata = {
        {"version", "1"}, {"method", method.name}, {"quantity", "standard error of the mean irradiance"}};
    if (result.path_count) volume.scalars.emplace("path_count", std::move(*result.path_count));
    writeVdb(outputs, path, volume, arguments.file);
}

/// The report as people read it.
void summarise(Terminal& terminal, const std::string& output, const Method& method, const GridFrame& frame,
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
    terminal.say(fmt::format("  {}{}{}, {} thread{}: {}together {:.2f} s", method.name,
                             report.instruction_set.empty() ? "" : ", ", report.instruction_set, report.threads,
                             report.threads == 1 ? "" : "s", stages, total));
    terminal.say(fmt::format("  power ledger off by {:.1e}, path ledger by {:.1e}", report.power.imbalance(),
                             report.path.imbalance()));
    if (!report.skipped.empty()) terminal.say(fmt::format("  skipped: {}", fmt::join(report.skipped, "; ")));
}

/// One frame from file to file. Returns its report document.
Json bakeFrame(const BakeArguments& arguments, int frame_number, OutputSet& outputs, Terminal& terminal) {
    const std::string output = outputPath(arguments, frame_number);
    Stopwatch watch;
    terminal.progress("scene", 0);
    const FilesRead files;
    Scene scene = loadScene(arguments.scene, frame_number, terminal);
    outputs.reads("a file of the scene", files.paths());
    applySettings(arguments, scene);
    const Method& method = chooseMethod(scene.bake.method, scene);
    for (const auto& [name, wanted] :
         {std::pair{"caustic", scene.bake.grids.caustic}, std::pair{"arrival_time", scene.bake.grids.arrival_time}}) {
        if (wanted && std::find(method.grids.begin(), method.grids.end(), name) == method.grids.end()) {
            throw Error(ErrorCode::Input,
                        fmt::format("method '{}' makes no grid '{}'; it makes {} and density", method.name, name,
                                    fmt::join(method.grids, ", ")),
                        scene.file);
        }
    }
    Json settings = settingsJson(scene, method, arguments.file);
    if (!arguments.post.empty()) settings["post"] = arguments.post;
    const std::string hash = inputHash(scene, settings);
    Json document{{"schema", "photic-report-1"}, {"program", std::string("photic ") + kVersion},
                  {"scene", arguments.scene},    {"scene_hash", hash},
                  {"frame", frame_number},       {"output", output},
                  {"up_to_date", false},         {"settings", settings}};
    const bool wants_error = !arguments.standard_error_file.empty();
    const bool whole = !wants_error || fs::exists(standardErrorPath(arguments, frame_number));
    if (arguments.frames && !arguments.force && whole && upToDate(output, hash)) {
        terminal.say(output + ": unchanged, kept");
        document["up_to_date"] = true;
        return document;
    }
    terminal.checkCancelled();
    const double scene_seconds = watch.lap();

    // The box alone may be more than the machine can hold: find out before a table of it is made.
    const GridFrame frame = sceneFrame(scene);
    if (scene.bake.where == Where::Everywhere)
        checkMemory(estimateBake(scene, method, frame, nullptr, arguments.file), arguments.max_memory_bytes);
    if (const auto names = receiversAtTheEdge(scene, frame); !names.empty()) {
        terminal.warn(
            fmt::format("{} lie{} at the edge of the domain: look-ups there find up to half of the light; extend "
                        "[domain] by two voxels behind",
                        fmt::join(names, ", "), names.size() == 1 ? "s" : ""));
    }
    terminal.progress("needed", 0);
    const auto needed = std::make_shared<const NeededVoxels>(sceneNeededVoxels(scene, frame, terminal));
    checkMemory(estimateBake(scene, method, frame, needed.get(), arguments.file), arguments.max_memory_bytes);
    const double needed_seconds = watch.lap();

    const auto given = scene.bake.method_options.find(method.name);
    BakeResult result =
        method.bake(scene, needed, given == scene.bake.method_options.end() ? GivenOptions{} : given->second, terminal);
    terminal.checkCancelled();
    watch.lap();
    BakeReport& report = result.report;
    report.reference_irradiance = scene.referenceIrradiance();
    report.needed_voxels = needed->count();
    report.threads = threadCount();
    report.seconds.insert(report.seconds.begin(), {{"scene", scene_seconds}, {"needed", needed_seconds}});
    if (scene.bake.prefilter) {
        prefilterForTrilinear(result.field);
        report.seconds.emplace_back("prefilter", watch.lap());
    }
    report.field_bytes = std::max(report.field_bytes, result.field.bytes());

    if (wants_error) writeStandardError(outputs, standardErrorPath(arguments, frame_number), result, method, arguments);
    LightVolume volume = makeVolume(scene, method, settings, hash, result);
    applyPostSteps(arguments.post, volume);
    terminal.checkCancelled();
    terminal.progress("write", 0);
    // The volume last: whoever finds it finds its standard error too.
    report.active_voxels = writeVdb(outputs, output, volume, arguments.file);
    const std::int64_t file_bytes = outputs.pendingBytes(output);
    outputs.commit();
    report.seconds.emplace_back("write", watch.lap());
    terminal.progress("write", 1);

    // What was warned about while it ran and what the method noted, each once.
    std::vector<std::string> warnings = terminal.takeWarnings();
    for (const std::string& warning : report.warnings) {
        if (std::find(warnings.begin(), warnings.end(), warning) != warnings.end()) continue;
        warnings.push_back(warning);
        terminal.warn(warning);
    }
    terminal.takeWarnings();
    report.warnings = std::move(warnings);
    summarise(terminal, output, method, frame, report, file_bytes);
    document["grid"] = toJson(frame);
    document["file_bytes"] = file_bytes;
    document.update(toJson(report));
    return document;
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

int dryRun(const BakeArguments& arguments, int frame_number, int frames, const std::string& output,
           Terminal& terminal) {
    Scene scene = loadScene(arguments.scene, frame_number, terminal);
    applySettings(arguments, scene);
    const Method& method = chooseMethod(scene.bake.method, scene);
    const GridFrame frame = sceneFrame(scene);
    BakeEstimate estimate = estimateBake(scene, method, frame, nullptr, arguments.file);
    const std::int64_t limit = arguments.max_memory_bytes > 0 ? arguments.max_memory_bytes : machineMemory();
    if (scene.bake.where != Where::Everywhere && estimate.leaves < limit / 100) {
        const NeededVoxels needed = sceneNeededVoxels(scene, frame, terminal);
        estimate = estimateBake(scene, method, frame, &needed, arguments.file);
    }
    const bool fits = estimate.memory_bytes <= limit;
    terminal.say(
        fmt::format("{}: about {:.4g} of {:.4g} voxels needed in {:.4g} leaves, {:.0f} MB of memory{}, {:.0f} MB on "
                    "disk, {:.1f} s{} with {} on {} threads (an estimate, good to a factor of three)",
                    output, static_cast<double>(estimate.needed_voxels), static_cast<double>(frame.voxelCount()),
                    static_cast<double>(estimate.leaves), static_cast<double>(estimate.memory_bytes) * 1e-6,
                    fits ? "" : " (more than there is: it would be refused)",
                    static_cast<double>(estimate.file_bytes) * 1e-6, estimate.seconds * frames,
                    frames > 1 ? fmt::format(" for {} frames", frames) : "", method.name, threadCount()));
    if (arguments.json) {
        print({{"schema", "photic-estimate-1"},
               {"scene", arguments.scene},
               {"output", output},
               {"method", method.name},
               {"frames", frames},
               {"grid", toJson(frame)},
               {"voxels", frame.voxelCount()},
               {"needed_voxels", estimate.needed_voxels},
               {"leaves", estimate.leaves},
               {"memory_bytes", estimate.memory_bytes},
               {"memory_limit_bytes", limit},
               {"fits", fits},
               {"file_bytes", estimate.file_bytes},
               {"seconds", estimate.seconds * frames}});
    }
    return 0;
}

}  // namespace

int run(const BakeArguments& arguments, Terminal& terminal) {
    checkPostSteps(arguments.post);
    const FrameRange range = arguments.frames.value_or(FrameRange{});
    const int frames = range.last - range.first + 1;
    const std::string first_output = outputPath(arguments, range.first);
    if (arguments.dry_run) return dryRun(arguments, range.first, frames, first_output, terminal);
    OutputSet outputs;
    claimOutputs(arguments, range, outputs);

    Json documents = Json::array(), written = Json::array();
    for (int frame = range.first; frame <= range.last; ++frame) {
        terminal.checkCancelled();
        terminal.beginPart(frame - range.first, frames);
        const std::string output = outputPath(arguments, frame);
        documents.push_back(bakeFrame(arguments, frame, outputs, terminal));
        written.push_back(output);
        if (arguments.frames) {
            terminal.event(
                dump({{"event", "frame"}, {"frame", frame}, {"output", output}, {"report", documents.back()}}));
        }
    }
    const Json& report = arguments.frames ? documents : documents.front();
    if (!arguments.report_file.empty()) {
        outputs.write(arguments.report_file, dump(report, 2) + "\n");
        outputs.commit();
    }
    terminal.event(
        dump({{"event", "done"}, {"output", written.back()}, {"outputs", written}, {"report", documents.back()}}));
    if (arguments.json) print(report);
    return 0;
}

}  // namespace photic::cli
