// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <optional>

#include "bake/baker/game_budget.h"
#include "bake/cli/another_scene.h"
#include "bake/cli/bake_plan.h"
#include "bake/cli/export_error.h"
#include "bake/cli/export_index.h"
#include "bake/cli/export_usd.h"
#include "bake/cli/export_web.h"
#include "bake/cli/json.h"
#include "bake/cli/verbs.h"
#include "bake/file/compressed_light.h"
#include "bake/file/l1_textures.h"
#include "bake/file/nvdb.h"
#include "bake/file/output_set.h"
#include "bake/file/runtime_size.h"
#include "bake/file/sidecar.h"
#include "bake/file/slice_atlas.h"
#include "bake/file/texture_3d.h"
#include "bake/image/atomic_file.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"

namespace photic::cli {
namespace {

/// Far below half a voxel, over any index that a grid holds.
constexpr double kMiB = 1 << 20;  // as the run-time library counts its budget
constexpr double kSamePlace = 1e-9;

bool sameGrid(const GridFrame& a, const GridFrame& b) {
    double apart = 0;
    const double size = std::cbrt(a.voxelVolume());
    for (int i = 0; i < 3; ++i) {
        apart = std::max(apart, std::fabs(a.origin_world[i] - b.origin_world[i]));
        for (int j = 0; j < 3; ++j)
            apart = std::max(apart, std::fabs(a.worldFromIndex()[i][j] - b.worldFromIndex()[i][j]));
    }
    return apart <= kSamePlace * size;
}

int frameInSequence(const LightVolume& volume, const std::string& path) {
    const std::optional<int> frame = frameOf(volume);
    if (!frame) {
        throw Error(ErrorCode::Input, "has no photic:frame; a sequence is made of what photic bake --frames wrote",
                    path);
    }
    return *frame;
}

/// What is left out of the volumes, and why.
struct Selection {
    std::optional<Scene> scene;
    std::optional<ExportPlan> plan;  ///< of a budget
    const Scene* receivers() const { return scene ? &*scene : nullptr; }
    bool compresses() const { return plan && plan->texels == GameTexels::Bc6h; }
    LightVolume of(const LightVolume& volume, Terminal& terminal) const {
        LightVolume out = planned(volume, *plan, receivers(), terminal);
        if (compresses()) compressLight(out, terminal);
        return out;
    }
};

/// Corners of a box [m].
struct WorldBox {
    glm::dvec3 low{0}, high{0};
};

std::optional<WorldBox> parseBox(const std::string& text) {
    if (text.empty()) return {};
    WorldBox box;
    int used = 0;
    const int read = std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf%n", &box.low.x, &box.low.y, &box.low.z,
                                 &box.high.x, &box.high.y, &box.high.z, &used);
    const bool sound = read == 6 && used == static_cast<int>(text.size()) && box.low.x < box.high.x &&
                       box.low.y < box.high.y && box.low.z < box.high.z && std::isfinite(glm::length(box.low)) &&
                       std::isfinite(glm::length(box.high));
    if (sound) return box;
    throw Error(ErrorCode::Usage,
                fmt::format("'{}' is no box; write x,y,z,x,y,z in metres, the lower corner first, for instance "
                            "--box=-1,-1,-2,1,1,0",
                            text),
                "--box");
}

/// The voxels of a dense file whose centres lie in a box.
VoxelBox voxelsIn(const WorldBox& box, const LightVolume& volume) {
    const StraightField straight(volume);
    const GridFrame& frame = straight.field().frame();
    constexpr double kRounding = 1e-6;  // of a voxel, so that a box of whole voxels holds them all
    const glm::dvec3 a = frame.indexFromWorld(box.low), b = frame.indexFromWorld(box.high);
    const glm::dvec3 low = glm::ceil(glm::min(a, b) - kRounding), high = glm::floor(glm::max(a, b) + kRounding);
    constexpr double kFarthest = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
        if (low[axis] <= high[axis] && low[axis] > -kFarthest && high[axis] < kFarthest) continue;
        throw Error(ErrorCode::Usage,
                    "holds no voxel's centre, or too many; make it as large as what is to be exported", "--box");
    }
    return {glm::ivec3(low), glm::ivec3(high)};
}

/// What a first look at the volumes finds.
struct Survey {
    std::vector<std::string> outputs;  ///< of each volume
    std::vector<int> frames;           ///< of each volume, where the outputs are numbered
    /// That holds the light of all volumes. One volume needs none: its file finds it.
    std::optional<VoxelBox> box;
    bool second_lobe = false;  ///< of any volume: files of a sequence are alike
};

/// The output's name gets the frame of each volume.
bool numbered(const ExportArguments& arguments) {
    return arguments.volumes.size() > 1 ||
           std::filesystem::path(arguments.output).filename().string().find('#') != std::string::npos;
}

/// Volumes that share what a sequence's files have in common: those to export, and the rest of their sequence.
std::vector<std::string> sharing(const ExportArguments& arguments) {
    std::vector<std::string> all = arguments.sequence;
    for (const std::string& path : arguments.volumes)
        if (std::find(all.begin(), all.end(), path) == all.end()) all.push_back(path);
    return all;
}

Survey surveyed(const ExportArguments& arguments, bool dense, const Selection& selection, Terminal& terminal) {
    const std::vector<std::string> all = sharing(arguments);
    if (!numbered(arguments) && all.size() == 1) return {{arguments.output}, {}};
    Survey survey;
    std::map<std::string, std::string> output_of, volume_of;
    std::map<std::string, int> frame_of;
    std::optional<GridFrame> grid;
    for (std::size_t i = 0; i < all.size(); ++i) {
        terminal.progress("read", static_cast<double>(i) / static_cast<double>(all.size()));
        const LightVolume volume = readVdb(all[i]);
        terminal.checkCancelled();
        if (grid && !sameGrid(*grid, volume.field.frame())) {
            throw Error(ErrorCode::Input,
                        fmt::format("its voxels are not those of '{}'; frames of one sequence share a grid: bake them "
                                    "with one [domain]",
                                    all[0]),
                        all[i]);
        }
        grid = volume.field.frame();
        survey.second_lobe = survey.second_lobe || volume.second;
        output_of[all[i]] = arguments.output;
        if (numbered(arguments)) {
            frame_of[all[i]] = frameInSequence(volume, all[i]);
            output_of[all[i]] = withFrame(arguments.output, frame_of[all[i]]);
        }
        if (dense && arguments.box.empty() && all.size() > 1)
            survey.box = together(survey.box, selection.plan ? litBox(selection.of(volume, terminal)) : litBox(volume));
    }
    for (const std::string& path : arguments.volumes) {
        survey.outputs.push_back(output_of.at(path));
        survey.frames.push_back(frame_of[path]);
        const auto [other, fresh] = volume_of.emplace(survey.outputs.back(), path);
        if (!fresh) {
            throw Error(ErrorCode::Input,
                        fmt::format("holds the same frame as '{}'; both would be {}", other->second, other->first),
                        path);
        }
    }
    return survey;
}

std::vector<WebFrame> webFrames(const Survey& survey) {
    std::vector<WebFrame> frames;
    for (std::size_t i = 0; i < survey.outputs.size(); ++i)
        frames.push_back({survey.frames[i], std::filesystem::path(survey.outputs[i]).filename().string()});
    return frames;
}

/// A file format for other programs: how it is called, and what the command line may say about it.
enum class Format { Nvdb, Ktx2, Dds, UnityVf, SliceAtlas, Web, L1, Usd, Ivol };
struct FormatRow {
    Format format;
    const char *extension, *name;
};
constexpr FormatRow kFormats[] = {{Format::Nvdb, ".nvdb", "nvdb"},       {Format::Ktx2, ".ktx2", "ktx2"},
                                  {Format::Dds, ".dds", "dds"},          {Format::UnityVf, ".vf", "vf"},
                                  {Format::SliceAtlas, ".exr", "atlas"}, {Format::Usd, ".usda", "usda"},
                                  {Format::Ivol, ".ivol", "ivol"}};
constexpr FormatRow kL1Formats[] = {{Format::L1, ".dds", "l1"}, {Format::L1, ".ktx2", "l1"}};

constexpr FormatRow kWebFormat{Format::Web, ".js", "web"};

const FormatRow& formatOf(const ExportArguments& arguments) {
    if (!arguments.web.empty()) {
        if (!arguments.output.empty())
            throw Error(ErrorCode::Usage, "makes files in a folder of its own; give either --web or -o", "--web");
        return kWebFormat;
    }
    if (arguments.shared_script)
        throw Error(ErrorCode::Usage, "says where a page's script goes; give --web too", "--shared-script");
    if (arguments.output.empty())
        throw Error(ErrorCode::Usage, "-o says the file to write, or --web the folder of a page; give one", "-o");
    const std::string extension = std::filesystem::path(arguments.output).extension().string();
    std::string known;
    if (arguments.l1) {
        for (const FormatRow& row : kL1Formats)
            if (extension == row.extension) return row;
        throw Error(ErrorCode::Usage, "makes three textures, .dds or .ktx2; give -o such a name", "--l1");
    }
    for (const FormatRow& row : kFormats) {
        if (extension == row.extension) return row;
        known += fmt::format("{}{}", known.empty() ? "" : ", ", row.extension);
    }
    throw Error(ErrorCode::Usage,
                fmt::format("output '{}' has no known extension; the formats are {}", arguments.output, known), "-o");
}

void checkOptions(const ExportArguments& arguments, const FormatRow& format) {
    if (format.format == Format::Nvdb && !arguments.box.empty())
        throw Error(ErrorCode::Usage, "is for dense files; an .nvdb holds the voxels with light, and needs no box",
                    "--box");
    if (format.format == Format::Usd && (!arguments.box.empty() || arguments.budget_mb))
        throw Error(ErrorCode::Usage, "a layer of USD holds no voxels of its own; it refers to the volumes as they are",
                    arguments.budget_mb ? "--budget" : "--box");
    if (format.format == Format::Nvdb) return;
    const auto refuse = [&](const char* option) {
        throw Error(ErrorCode::Usage,
                    fmt::format("for .nvdb only; {} files have one way to store values", format.extension), option);
    };
    if (arguments.precision) refuse("--precision");
    if (arguments.codec) refuse("--codec");
    if (arguments.compress) refuse("--compress");
}

/// Claims the files of one volume, before any is made.
void claim(OutputSet& outputs, const std::string& output, Format format) {
    if (format == Format::L1) {
        for (const std::string& path : l1Paths(output)) outputs.writes("the output", path);
    } else {
        outputs.writes("the output", output);
    }
    if (format == Format::L1 || format == Format::Dds || format == Format::UnityVf || format == Format::SliceAtlas)
        outputs.writesBeside("the sidecar of the output", sidecarPath(output), isSidecar);
}

void checkBudget(const ExportArguments& arguments) {
    if (arguments.compress == ExportTexels::Auto && !arguments.budget_mb)
        throw Error(ErrorCode::Usage, "auto compares errors within a budget; give --budget too, or bc6h", "--compress");
    if (arguments.budget_mb && (!(*arguments.budget_mb > 0) || *arguments.budget_mb > 1e9))
        throw Error(ErrorCode::Usage,
                    fmt::format("a budget of {} MB; it must be above 0 and at most 1e9", *arguments.budget_mb),
                    "--budget");
    if (!arguments.scene.empty() && !arguments.budget_mb && !arguments.compress && arguments.web.empty() &&
        !arguments.output.ends_with(".usda"))
        throw Error(ErrorCode::Usage,
                    "tells --budget where the receivers are, or --web what is to be seen; give one of them", "--scene");
}

MemoryModel memoryOf(Format format, GameTexels texels) {
    if (format != Format::Nvdb) return MemoryModel::Dense;
    return texels == GameTexels::Bc6h ? MemoryModel::RuntimeBc6h : MemoryModel::Runtime;
}

/// One plan for all volumes: that of the one that must leave out the most.
ExportPlan planOf(const ExportArguments& arguments, Format format, GameTexels texels, const Scene* receivers,
                  Terminal& terminal) {
    if (!arguments.budget_mb) return {.texels = texels};
    const auto bytes = static_cast<std::int64_t>(*arguments.budget_mb * kMiB);
    const bool two = format == Format::Nvdb && arguments.levels == 2;
    const std::vector<ExportPlan> plans =
        exportPlans(receivers, two ? ExportLevels::Two : ExportLevels::One, bytes, texels);
    std::size_t chosen = 0;
    const std::vector<std::string> all = sharing(arguments);
    for (const std::string& path : all)
        chosen = fittingPlan(readVdb(path), plans, chosen, bytes, memoryOf(format, texels), receivers, terminal);
    return sharedPlan(readVdb(all.front()), plans[chosen], receivers, terminal);
}

Selection select(const ExportArguments& arguments, Format format, Terminal& terminal) {
    Selection selection;
    const ExportTexels texels = arguments.compress.value_or(ExportTexels::None);
    if (!arguments.budget_mb && texels == ExportTexels::None) return selection;
    if (!arguments.scene.empty()) selection.scene = loadScene(arguments.scene, 0, terminal);
    const auto plan = [&](GameTexels of) { return planOf(arguments, format, of, selection.receivers(), terminal); };
    selection.plan = plan(texels == ExportTexels::Bc6h ? GameTexels::Bc6h : GameTexels::Halves);
    if (texels != ExportTexels::Auto) return selection;
    // Whichever of the two leaves the smaller error in the first volume.
    Selection blocks;
    blocks.plan = plan(GameTexels::Bc6h);
    const LightVolume first = readVdb(sharing(arguments).front());
    const auto errorOf = [&](const ExportPlan& of) {
        const Selection one{selection.scene, of};
        return meanError(exportError(first, one.of(first, terminal), selection.receivers()));
    };
    if (first.field.channels().flux && errorOf(*blocks.plan) < errorOf(*selection.plan)) selection.plan = blocks.plan;
    return selection;
}

/// What a budget cost, said and returned.
Json budgetReport(const LightVolume& source, const LightVolume& exported, const Selection& selection, Format format,
                  Terminal& terminal) {
    const ExportPlan& plan = *selection.plan;
    const std::int64_t bytes = gameBytes(exported, memoryOf(format, plan.texels));
    const Json error = exportError(source, exported, selection.receivers());
    const RuntimeSize size = runtimeSize(exported, plan.texels);
    const double coarse = format == Format::Nvdb && size.bricks > 0
                              ? static_cast<double>(size.coarse) / static_cast<double>(size.bricks)
                              : 0;
    terminal.say(fmt::format(
        "  {:.2f} MiB in a game{}; voxels {}{}, {}", static_cast<double>(bytes) / kMiB,
        selection.compresses() ? " as BC6H" : "",
        plan.factor == 1 ? std::string("as baked") : fmt::format("{} times as wide", plan.factor),
        coarse > 0 ? fmt::format(" and twice that where light is smooth ({} of {} bricks)", size.coarse, size.bricks)
                   : std::string(),
        plan.band ? fmt::format("{} around receivers", *plan.band) : "all kept"));
    terminal.say("  " + errorText(error));
    return {{"game_bytes", bytes},     {"compression", selection.compresses() ? "bc6h" : "none"},
            {"factor", plan.factor},   {"band", plan.band ? Json(*plan.band) : Json(nullptr)},
            {"coarse_bricks", coarse}, {"error", error}};
}

std::string precisionName(const ExportArguments& arguments, Format format) {
    if (format == Format::UnityVf) return "float";
    return arguments.precision == NvdbPrecision::Float ? "float" : "half";
}

/// What was written of one volume.
struct Written {
    DenseWritten dense;
    std::int64_t voxels = 0;  ///< with light, or those of the dense box
};

Written denseWritten(const DenseWritten& written) {
    return {written, std::int64_t{written.size.x} * written.size.y * written.size.z};
}

Written write(const ExportArguments& arguments, Format format, OutputSet& outputs, const std::string& output,
              const LightVolume& volume, const std::optional<VoxelBox>& box) {
    switch (format) {
        case Format::Ktx2:
            return denseWritten(writeTextures(outputs, output, volume, TextureFormat::Ktx2, box));
        case Format::Dds:
            return denseWritten(writeTextures(outputs, output, volume, TextureFormat::Dds, box));
        case Format::UnityVf:
            return denseWritten(writeTextures(outputs, output, volume, TextureFormat::UnityVf, box));
        case Format::SliceAtlas:
            return denseWritten(writeSliceAtlas(outputs, output, volume, box));
        case Format::L1: {
            const bool dds = std::filesystem::path(output).extension() == ".dds";
            return denseWritten(
                writeL1Textures(outputs, output, volume, dds ? TextureFormat::Dds : TextureFormat::Ktx2, box));
        }
        case Format::Web:
        case Format::Usd:
        case Format::Ivol:
        case Format::Nvdb:
            break;
    }
    const NvdbOptions options{arguments.precision.value_or(NvdbPrecision::Half),
                              arguments.codec.value_or(NvdbCodec::Blosc)};
    const NvdbWritten written = writeNvdb(outputs, output, volume, options);
    return {{{output}, volume.field.frame().size(), written.clamped}, written.active_voxels};
}

/// Says what was written of `volume`, and returns it for `--json`.
Json reported(const std::string& volume, const Written& written, const ExportArguments& arguments,
              const FormatRow& format, Terminal& terminal) {
    const auto& [dense, voxels] = written;
    if (dense.clamped > 0) {
        terminal.warn(
            fmt::format("{}: {} values were not finite or above 65504, and were cut; photic inspect tells what is "
                        "wrong with the volume",
                        volume, dense.clamped));
    }
    Json files = Json::array();
    std::uintmax_t bytes = 0;
    for (const std::string& file : dense.files) {
        const std::uintmax_t size = std::filesystem::file_size(file);
        files.push_back({{"path", file}, {"bytes", size}});
        bytes += size;
    }
    terminal.say(fmt::format("{}: {}, {} voxels in {} x {} x {}, {:.2f} MB", fmt::join(dense.files, ", "),
                             precisionName(arguments, format.format), voxels, dense.size.x, dense.size.y, dense.size.z,
                             static_cast<double>(bytes) * 1e-6));
    return {{"volume", volume},
            {"files", files},
            {"bytes", bytes},
            {"voxels", voxels},
            {"size", toJson(dense.size)},
            {"cut_values", dense.clamped}};
}

}  // namespace

int run(const ExportArguments& given, Terminal& terminal) {
    const FormatRow& format = formatOf(given);
    if (format.format == Format::Ivol) return exportIndex(given, terminal);
    if (given.bodies) throw Error(ErrorCode::Usage, "for an .ivol only; light volumes hold no bodies", "--bodies");
    if (given.voxel_size)
        throw Error(ErrorCode::Usage, "for an .ivol only; light volumes keep their voxels", "--voxel-size");
    ExportArguments arguments = given;
    if (format.format == Format::Web) arguments.output = WebExport::frameFiles(given.web);
    checkOptions(arguments, format);
    checkBudget(arguments);
    if (format.format == Format::Usd) return exportUsd(arguments, terminal);
    const std::optional<WorldBox> wanted = parseBox(arguments.box);
    OutputSet outputs;
    outputs.reads("the volume", arguments.volumes);
    outputs.reads("a volume of the sequence", arguments.sequence);
    if (!arguments.scene.empty()) outputs.reads("the scene", arguments.scene);
    // A sequence's files are known once their frames are; the first look at the volumes finds them.
    if (!numbered(arguments)) claim(outputs, arguments.output, format.format);
    std::optional<WebExport> page;
    if (format.format == Format::Web) page.emplace(arguments, outputs);
    const FilesRead files;
    const Selection selection = select(arguments, format.format, terminal);
    outputs.reads("a file of the scene", files.paths());
    const Survey survey = surveyed(arguments, format.format != Format::Nvdb, selection, terminal);
    for (const std::string& output : survey.outputs)
        if (numbered(arguments)) claim(outputs, output, format.format);
    if (page) page->expect(webFrames(survey));
    Json frames = Json::array();
    for (std::size_t i = 0; i < arguments.volumes.size(); ++i) {
        terminal.progress("write", static_cast<double>(i) / static_cast<double>(arguments.volumes.size()));
        const std::string& path = arguments.volumes[i];
        LightVolume volume = readVdb(path);
        terminal.checkCancelled();
        // Dense files of a sequence are alike: a frame whose light opposes itself nowhere has a dark second lobe.
        if (!page && survey.second_lobe && !volume.second && volume.field.channels().flux)
            volume.second.emplace(volume.field.neededPtr(), volume.field.channels());
        if (selection.scene && !page) warnOfAnotherScene(*selection.scene, volume, path, terminal);
        std::optional<LightVolume> less;
        if (selection.plan) less.emplace(selection.of(volume, terminal));
        const LightVolume& exported = less ? *less : volume;
        const std::optional<VoxelBox> box = wanted ? voxelsIn(*wanted, exported) : survey.box;
        const Written written =
            page ? denseWritten(page->writeFrame(outputs, survey.outputs[i], {path, exported, box}, terminal))
                 : write(arguments, format.format, outputs, survey.outputs[i], exported, box);
        outputs.commit();
        frames.push_back(reported(path, written, arguments, format, terminal));
        frames.back()["budget"] =
            less ? budgetReport(volume, exported, selection, format.format, terminal) : Json(nullptr);
    }
    if (page) page->finish(outputs, terminal);
    terminal.progress("write", 1);
    if (arguments.json) {
        print({{"schema", "photic-export-1"},
               {"format", format.name},
               {"precision", precisionName(arguments, format.format)},
               {"frames", frames}});
    }
    return 0;
}

}  // namespace photic::cli
