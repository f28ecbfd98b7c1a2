// SPDX-License-Identifier: Apache-2.0
// The only file that includes CLI11: it takes five seconds to compile.
#include "bake/cli/arguments.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <string_view>

#include "bake/cli/version.h"
#include "bake/image/colour_map.h"
#include "bake/methods/catalogue.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"
#include "bake/threads/parallel_for.h"

namespace photic::cli {

namespace {

constexpr const char* kExitCodes =
    "Exit codes: 0 done, 1 a check found more than was allowed, 2 usage, 3 input, 4 bake or write failed,\n"
    "75 try again, 130 interrupted. Data goes to stdout, messages to stderr.";

struct PlannedVerb {
    std::string_view name, what;
};
constexpr PlannedVerb kPlannedVerbs[] = {{"merge", "summing tiles and batches"}};

/// "7" or "1-48".
FrameRange parseFrames(const std::string& text) {
    FrameRange range;
    int used = 0;
    const bool pair = std::sscanf(text.c_str(), "%9d-%9d%n", &range.first, &range.last, &used) == 2 &&
                      used == static_cast<int>(text.size());
    if (!pair) {
        used = 0;
        if (std::sscanf(text.c_str(), "%9d%n", &range.first, &used) != 1 || used != static_cast<int>(text.size())) {
            throw Error(ErrorCode::Usage,
                        fmt::format("'{}' is no range of frames; write --frames 1-48 or --frames 7", text), "--frames");
        }
        range.last = range.first;
    }
    if (range.first < 0 || range.last < range.first || range.last - range.first >= 1000000) {
        throw Error(
            ErrorCode::Usage,
            fmt::format(
                "frames {} to {} are no range; the first must be 0 or more and not after the last, at most 1000000",
                range.first, range.last),
            "--frames");
    }
    return range;
}

std::string optionTable() {
    std::string text = "Methods and their options (--set METHOD.OPTION=VALUE, or [bake.METHOD] in the scene):\n";
    for (const Method& method : methodCatalogue()) {
        text += fmt::format("  {}: {}\n", method.name, method.summary);
        for (const OptionSpec& option : method.options) {
            text += fmt::format("    {}.{}{}: {}\n", method.name, option.name,
                                option.unit.empty() ? "" : " [" + option.unit + "]", option.help);
        }
    }
    text.pop_back();
    return text;
}

void addProgress(CLI::App& verb, std::string& progress, int& threads) {
    verb.add_option("--progress", progress, "On stderr: a bar, JSON lines or nothing (default: a bar on a terminal)")
        ->check(CLI::IsMember({"bar", "json", "none"}));
    verb.add_option("--threads", threads, "Threads; 0 takes all cores. Results don't depend on it")
        ->check(CLI::Range(0, 1024));
}

/// CLI11 reads "-1" as a size of two to the 64th less one.
const CLI::Validator kNotNegative(
    [](std::string& text) { return text.starts_with('-') ? "a size is wanted, not " + text : std::string(); }, "",
    "not negative");

void addBake(CLI::App& app, BakeArguments& a, std::string& frames, std::string& compression) {
    app.add_option("SCENE", a.scene, "Scene file (.toml)")->required();
    app.add_option("-o,--output", a.output,
                   "Volume to write (default: the scene's name, .vdb, in the current directory)");
    app.add_option("--method", a.method, "Bake method, or auto");
    app.add_option("--frames", frames,
                   "Frames A-B of an animated surface; writes NAME.0001.vdb ... Unchanged frames are kept");
    app.add_flag("--force", a.force, "Bake frames again even when their inputs have not changed");
    app.add_flag("--dry-run", a.dry_run, "Estimate voxels, memory and time; bake nothing");
    app.add_option("--report", a.report_file, "Write the report as JSON to a file");
    app.add_flag("--json", a.json, "Print the report (or the estimate) as JSON on stdout");
    app.add_option("--voxel-size", a.voxel_size, "Voxel size [m] instead of the scene's");
    app.add_option("--resolution", a.resolution,
                   "Voxels along the domain's longest side instead of the scene's voxel size");
    app.add_option("--where", a.where, "everywhere, receivers or media")
        ->check(CLI::IsMember({"everywhere", "receivers", "media"}));
    app.add_option("--paths", a.paths, "caustic (at least one specular event) or all")
        ->check(CLI::IsMember({"caustic", "all"}));
    app.add_option("--quadrature", a.quadrature,
                   "Points across a layer: 1, 2 or 4; by the slant of the light if not given")
        ->check(CLI::IsMember({1, 2, 4}));
    app.add_option("--tolerance", a.tolerance, "Refinement tolerance [voxels]");
    app.add_flag_function(
        "--prefilter,!--no-prefilter", [&a](std::int64_t count) { a.prefilter = count > 0; },
        "Invert the blur of trilinear look-ups");
    app.add_option("--grids", a.grids, "Grids to write, comma-separated: irradiance, direction, caustic, density ...")
        ->delimiter(',');
    app.add_option("--post", a.post,
                   "A step on the caustic grid: sharpen=A,B or dissipate=Z,SPEED; may be repeated (photic post --help)")
        ->allow_extra_args(false);
    app.add_option("--set", a.set, "METHOD.OPTION=VALUE, for instance beams.mesh=512; may be repeated")
        ->allow_extra_args(false);
    app.add_flag("!--f32", a.file.half, "Store 32-bit floats instead of half floats");
    app.add_option("--compression", compression, "Of the .vdb (default mask)")
        ->check(CLI::IsMember({"none", "mask", "blosc", "zip"}));
    app.add_option("--standard-error", a.standard_error_file,
                   "Also write the standard error per voxel, as irradiance, to a .vdb (photons)");
    app.add_option("--max-memory", a.max_memory_bytes,
                   "Refuse to bake above this estimate, for instance 8GB (default: the machine's)")
        ->check(kNotNegative)
        ->transform(CLI::AsSizeValue(false));
    app.footer(optionTable);
}

/// NaN passes CLI11's own ranges: no comparison with it is false that should be.
const CLI::Validator kNotNan(
    [](std::string& text) {
        double value = 0;
        return CLI::detail::lexical_cast(text, value) && std::isnan(value) ? "a number is wanted, not " + text
                                                                           : std::string();
    },
    "", "not NaN");

void addPicture(CLI::App& app, PictureArguments& a) {
    app.add_option("SCENE", a.scene, "Scene file (.toml)")->required();
    app.add_option("VOLUME", a.volumes, "Volumes baked from it; several with --film-strip")->required();
    app.add_option("-o,--output", a.directory, "Folder for the pictures (default: the current one)");
    app.add_option("--receiver", a.receivers, "Planar receiver to picture; may be repeated (default: all)")
        ->allow_extra_args(false);
    app.add_option("--slice", a.slices, "A layer of voxels, for instance z=-0.5 [m]; may be repeated")
        ->allow_extra_args(false);
    app.add_option("--xray", a.xrays, "Mean along x, y or z; may be repeated (default: y)")
        ->allow_extra_args(false)
        ->check(CLI::IsMember({"x", "y", "z"}));
    app.add_option("--resolution", a.resolution, "Texels along a receiver's longer side")->check(CLI::Range(1, 16384));
    app.add_option("--exposure", a.exposure, "Brightness of the display pictures")
        ->check(CLI::PositiveNumber)
        ->check(kNotNan);
    app.add_option("--max", a.max, "Top of the colour bar [W/m2] (default: from the picture)")
        ->check(CLI::PositiveNumber)
        ->check(kNotNan);
    app.add_option("--colour-map", a.colour_map, "Colours of the mapped pictures")
        ->check(CLI::IsMember(colourMapNames()));
    app.add_flag("--film-strip", a.film_strip, "One picture with all volumes side by side, of each thing asked for");
    app.add_option("--columns", a.columns, "Pictures a row of a film strip")->check(CLI::Range(1, 1000));
    app.add_flag("--view", a.view, "Also a perspective view of the lit scene through its water");
    app.add_flag("--view-only", a.view_only, "Only that view");
    app.add_option("--eye", a.eye, "Camera position x,y,z [m], written --eye=-2,-3,2");
    app.add_option("--target", a.target, "Point looked at x,y,z [m]");
    app.add_option("--fov", a.field_of_view_deg, "Field of view [degrees]")
        ->check(CLI::Range(1.0, 150.0))
        ->check(kNotNan);
    app.add_option("--size", a.size, "Size of the view, for instance 960x640");
    app.add_option("--samples", a.samples, "Samples a side and pixel of the view")->check(CLI::Range(1, 16));
    app.add_option("--tiles", a.tile_size, "Draw tiles of this size [m] on receivers in the view")
        ->check(CLI::NonNegativeNumber)
        ->check(kNotNan);
    app.add_option("--shafts", a.shafts, "Scattering [1/m] shown in the view instead of the medium's")
        ->check(CLI::NonNegativeNumber)
        ->check(kNotNan);
    app.add_option("--shafts-g", a.shaft_anisotropy, "Anisotropy of that scattering")
        ->check(CLI::Range(-0.99, 0.99))
        ->check(kNotNan);
    app.add_option("--look", a.look,
                   "cutaway (open sides, straight eye rays) or natural (solid sides, eye rays refract)")
        ->check(CLI::IsMember({"cutaway", "natural"}));
    app.add_flag("!--no-surface", a.show_surface, "Look through the water surface as if it were not there");
}

void addExport(CLI::App& app, ExportArguments& a) {
    app.add_option("VOLUME", a.volumes, "Light volume (.vdb); several are frames, laid out alike")->required();
    app.add_option(
           "-o,--output", a.output,
           "File to write; its extension is the format: .nvdb, .ktx2, .dds, .vf or .exr. #### is the frame of a volume")
        ->required();
    const std::map<std::string, NvdbPrecision> precisions{{"half", NvdbPrecision::Half},
                                                          {"float", NvdbPrecision::Float}};
    app.add_option("--precision", a.precision, "Of an .nvdb: half (default) or float")
        ->transform(CLI::CheckedTransformer(precisions).description("{half,float}"));
    const std::map<std::string, NvdbCodec> codecs{
        {"none", NvdbCodec::None}, {"zip", NvdbCodec::Zip}, {"blosc", NvdbCodec::Blosc}};
    app.add_option("--codec", a.codec,
                   "Of an .nvdb: blosc (default), none, or zip, which the run-time library does not read")
        ->transform(CLI::CheckedTransformer(codecs).description("{none,zip,blosc}"));
    app.add_option("--budget", a.budget_mb,
                   "Memory that a volume may take in a game [MiB]: leaves out what it must, and says what that costs");
    app.add_option("--scene", a.scene,
                   "Scene file that it was baked from: --budget keeps voxels around its receivers, and measures there");
    app.add_option("--sequence", a.sequence,
                   "All volumes of the sequence that VOLUME... are a part of: parts that are exported apart then share "
                   "one box, and one --budget");
    app.add_option(
        "--box", a.box,
        "Of .ktx2, .dds, .vf and .exr: corners x,y,z,x,y,z [m] of what they hold, instead of the voxels with "
        "light; written --box=-1,-1,-2,1,1,0");
    app.add_flag("--json", a.json, "Print what was written as JSON on stdout");
}

/// "Perhaps you meant bake?" for verbs that do not exist; planned ones are refused by name.
void refuseUnknownVerb(const std::string& name, const std::vector<std::string>& known) {
    for (const PlannedVerb& planned : kPlannedVerbs) {
        if (planned.name == name) {
            throw Error(ErrorCode::Usage, fmt::format("'{}' ({}) is not built yet; built are: {}", name, planned.what,
                                                      fmt::join(known, ", ")));
        }
    }
    if (std::find(known.begin(), known.end(), name) != known.end()) return;
    const std::string near = nearestName(name, known);
    throw Error(ErrorCode::Usage,
                fmt::format("unknown verb '{}'; {}the verbs are: {}", name,
                            near.empty() ? "" : "did you mean '" + near + "'? ", fmt::join(known, ", ")));
}

Compression compressionNamed(const std::string& name) {
    if (name == "none") return Compression::None;
    if (name == "blosc") return Compression::Blosc;
    return name == "zip" ? Compression::Zip : Compression::Mask;
}

}  // namespace

ProgressMode progressMode(int argc, const char* const* argv) {
    ProgressMode mode = ProgressMode::Auto;
    for (int i = 1; i < argc; ++i) {
        std::string_view text = argv[i];
        if (text == "--progress" && i + 1 < argc) {
            text = argv[i + 1];
        } else if (text.starts_with("--progress=")) {
            text.remove_prefix(11);
        } else {
            continue;
        }
        if (text == "bar") mode = ProgressMode::Bar;
        if (text == "json") mode = ProgressMode::Events;
        if (text == "none") mode = ProgressMode::None;
    }
    return mode;
}

Verb parseArguments(int argc, const char* const* argv) {
    if (argc > 1 && std::string_view(argv[1]) == "view") return ViewArguments{{argv + 2, argv + argc}};
    CLI::App app{"Bakes the light that water and mirrors focus into sparse OpenVDB volumes.", "photic"};
    app.set_version_flag("--version", std::string("photic ") + kVersion);
    app.require_subcommand(1);
    app.footer(kExitCodes);

    BakeArguments bake;
    InspectArguments inspect;
    CompareArguments compare;
    PictureArguments picture;
    ExportArguments exported;
    MethodsArguments methods;
    PostArguments post;
    std::string frames, compression = "mask", progress;
    int threads = 0;

    CLI::App* bake_app = app.add_subcommand("bake", "Bake a scene into a light volume");
    addBake(*bake_app, bake, frames, compression);
    CLI::App* inspect_app = app.add_subcommand("inspect", "Say what a volume holds and check its laws");
    inspect_app->add_option("VOLUME", inspect.volume, "Light volume (.vdb)")->required();
    inspect_app->add_flag("--json", inspect.json, "Print JSON on stdout");
    inspect_app->add_flag("--strict", inspect.strict, "Exit with 1 when a law does not hold");
    CLI::App* compare_app = app.add_subcommand("compare", "Measure how far two volumes or two EXR images are apart");
    compare_app->add_option("A", compare.a, "Volume (.vdb) or image (.exr)")->required();
    compare_app->add_option("B", compare.b, "The reference, of the same kind")->required();
    compare_app
        ->add_option("--max-error", compare.max_error, "Exit with 1 above this relative L1 error, for instance 0.01")
        ->check(CLI::NonNegativeNumber)
        ->check(kNotNan);
    compare_app->add_option("--standard-error", compare.standard_error,
                            "Volume of B's standard error: adds chi-squared and z scores");
    compare_app->add_option("--bias-allowance", compare.bias_allowance, "Relative bias that the scores forgive")
        ->check(CLI::Range(0.0, 1.0))
        ->check(kNotNan);
    compare_app->add_option("--difference", compare.difference, "Write A - B as a colour-mapped PNG (images only)");
    compare_app->add_flag("--json", compare.json, "Print JSON on stdout");
    CLI::App* picture_app =
        app.add_subcommand("picture", "Show receivers as they will be lit, slices, x-rays and views");
    addPicture(*picture_app, picture);
    CLI::App* export_app =
        app.add_subcommand("export", "Write a volume for games: .nvdb, .ktx2, .dds, .vf, or a slice atlas (.exr)");
    addExport(*export_app, exported);
    CLI::App* methods_app = app.add_subcommand("methods", "List the bake methods and their options");
    methods_app->add_flag("--json", methods.json, "Print JSON on stdout");
    CLI::App* post_app = app.add_subcommand("post", "Sharpen or dissipate the caustic grid of a volume");
    post_app->add_option("VOLUME", post.volume, "Light volume (.vdb) with a grid 'caustic'")->required();
    post_app->add_option("-o,--output", post.output, "Volume to write")->required();
    post_app
        ->add_option(
            "--step", post.steps,
            "sharpen=A,B: a * phi^b. dissipate=Z,SPEED: below the height Z [m] each layer is a step of a wave of "
            "SPEED voxels a layer. May be repeated; applied in order")
        ->allow_extra_args(false);
    post_app->add_flag("--as-light", post.as_light,
                       "Make the caustic grid the irradiance, for pictures and readers that want light");
    post_app->add_flag("!--f32", post.file.half, "Store 32-bit floats instead of half floats");
    app.add_subcommand("view", "Show volumes, or water without a bake, in a window or as a screenshot");
    for (CLI::App* verb : {bake_app, inspect_app, compare_app, picture_app, export_app, methods_app, post_app})
        addProgress(*verb, progress, threads);

    std::vector<std::string> known;
    for (const CLI::App* verb : app.get_subcommands({})) known.push_back(verb->get_name());
    if (argc > 1 && argv[1][0] != '-') refuseUnknownVerb(argv[1], known);

    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) {
        app.exit(help);
        return NothingToDo{};
    } catch (const CLI::ParseError& error) {
        const std::string verb = argc > 1 && argv[1][0] != '-' ? std::string(" ") + argv[1] : "";
        throw Error(ErrorCode::Usage, fmt::format("{}; see photic{} --help", error.what(), verb));
    }
    setThreadCount(threads);

    if (bake_app->parsed()) {
        if (!frames.empty()) bake.frames = parseFrames(frames);
        bake.file.compression = compressionNamed(compression);
        return bake;
    }
    if (inspect_app->parsed()) return inspect;
    if (compare_app->parsed()) return compare;
    if (picture_app->parsed()) return picture;
    if (export_app->parsed()) return exported;
    if (post_app->parsed()) return post;
    return methods;
}

}  // namespace photic::cli
