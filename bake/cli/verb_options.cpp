// SPDX-License-Identifier: Apache-2.0
// This file and arguments.cpp alone include CLI11: it takes five seconds to compile.
#include "bake/cli/verb_options.h"
#include "bake/baker/bake_settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <vector>

#include "bake/image/colour_map.h"
#include "bake/methods/catalogue.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"
#include "bake/scene/setting_names.h"

namespace photic::cli {

namespace {

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

/// "3/8".
Tile parseTile(const std::string& text) {
    Tile tile;
    int used = 0;
    constexpr int kMostTiles = 100000;
    if (std::sscanf(text.c_str(), "%6d/%6d%n", &tile.index, &tile.count, &used) != 2 ||
        used != static_cast<int>(text.size()))
        throw Error(ErrorCode::Usage, fmt::format("'{}' is no tile; write --tile 3/8 for the third of eight", text),
                    "--tile");
    if (tile.count < 1 || tile.count > kMostTiles || tile.index < 1 || tile.index > tile.count)
        throw Error(ErrorCode::Usage,
                    fmt::format("there is no tile {}; tiles are numbered from 1 to their count, which is at most {}",
                                tile.name(), kMostTiles),
                    "--tile");
    return tile;
}

/// One of some words, which its help shows as its value: "bar|json|none".
void oneOf(CLI::Option* option, const std::vector<std::string>& words) {
    option->type_name(fmt::format("{}", fmt::join(words, "|")));
    option->check(CLI::Validator(
        [words](std::string& text) {
            if (std::find(words.begin(), words.end(), text) != words.end()) return std::string();
            const std::string near = nearestName(text, words);
            return fmt::format("'{}' is none of {}{}", text, fmt::join(words, ", "),
                               near.empty() ? "" : "; did you mean '" + near + "'?");
        },
        ""));
}

/// NaN passes CLI11's own ranges: no comparison with it is false that should be.
CLI::Validator notNan() {
    return CLI::Validator(
        [](std::string& text) {
            double value = 0;
            return CLI::detail::lexical_cast(text, value) && std::isnan(value) ? "a number is wanted, not " + text
                                                                               : std::string();
        },
        "");
}

/// A number between two others, both of them possible. CLI11's own checks say it in other words in each version.
CLI::Validator between(double least, double most, const std::string& limit) {
    return CLI::Validator(
        [least, most, limit](std::string& text) {
            double value = 0;
            const bool possible =
                CLI::detail::lexical_cast(text, value) && (std::isnan(value) || (value >= least && value <= most));
            return possible ? std::string() : fmt::format("{} is not possible; it must be {}", text, limit);
        },
        "");
}

/// A number from `least` to `most`, which the help tells.
void within(CLI::Option* option, double least, double most) {
    option->check(between(least, most, fmt::format("from {:g} to {:g}", least, most)))->check(notNan());
}

/// A number above 0, or not below it.
constexpr double kLargest = std::numeric_limits<double>::max();
CLI::Validator above0() { return between(std::numeric_limits<double>::min(), kLargest, "above 0"); }
CLI::Validator notBelow0() { return between(0, kLargest, "not below 0"); }
void positive(CLI::Option* option) { option->check(above0())->check(notNan()); }
void notNegative(CLI::Option* option) { option->check(notBelow0())->check(notNan()); }

/// CLI11 reads "-1" as a size of two to the 64th less one.
CLI::Validator sizeNotNegative() {
    return CLI::Validator(
        [](std::string& text) { return text.starts_with('-') ? "a size is wanted, not " + text : std::string(); }, "");
}

CLI::Option* value(CLI::Option* option, const char* name) { return option->type_name(name); }
CLI::Option* repeated(CLI::Option* option) { return option->allow_extra_args(false); }

void addStoredAs(CLI::App& app, VdbOptions& file) {
    app.add_flag("!--f32", file.half, "Store 32-bit floats instead of half floats");
}

/// An option that is one of some names, each of which stands for a value of an enum.
template <class Enum, class Target>
void named(CLI::App& app, const char* option, const std::vector<std::pair<std::string, Enum>>& names, Target& target,
           const char* help) {
    std::vector<std::string> words;
    for (const auto& [name, meaning] : names) words.push_back(name);
    oneOf(app.add_option_function<std::string>(
              option,
              [&target, names](const std::string& given) {
                  for (const auto& [name, meaning] : names)
                      if (name == given) target = meaning;
              },
              help),
          words);
}

/// What is baked, and what is said about it.
void bindRun(CLI::App& app, BakeArguments& a) {
    value(app.add_option("SCENE", a.scene, "Scene file (.toml, .glb or .gltf)"), "FILE")->required();
    value(app.add_option("-o,--output", a.output,
                         "Volume to write (default: the scene's name, .vdb, in the current folder). Folders that it "
                         "names are made"),
          "FILE");
    std::vector<std::string> methods = catalogueNames();
    methods.insert(methods.begin(), "auto");
    value(app.add_option("--method", a.method, "Bake method; auto takes the first that can bake the scene"),
          fmt::format("{}", fmt::join(methods, "|")).c_str());
    value(app.add_option_function<std::string>(
              "--frames", [&a](const std::string& text) { a.frames = parseFrames(text); },
              "Frames of an animated scene, for instance 1-48; writes NAME.0001.vdb ... Unchanged frames are kept"),
          "A-B");
    value(
        app.add_option_function<std::string>(
            "--tile", [&a](const std::string& text) { a.tile = parseTile(text); },
            "One of N tiles of the volume, for instance 3/8, for photic merge; writes NAME.tile3of8.vdb. An unchanged "
            "tile is kept"),
        "I/N");
    app.add_flag("--force", a.force, "Bake frames and tiles again even when their inputs have not changed");
    app.add_flag("--dry-run", a.dry_run, "Check the inputs and estimate voxels, memory and time; bake nothing");
    value(app.add_option("--report", a.report_file, "Write the report as JSON to a file"), "FILE");
    app.add_flag("--json", a.json, "Print the report (or the estimate) as JSON on stdout");
}

/// What stands in for the scene's own settings.
void bindSettings(CLI::App& app, BakeArguments& a) {
    value(app.add_option("--voxel-size", a.voxel_size, "Voxel size [m] instead of the scene's"), "METRES");
    value(app.add_option("--resolution", a.resolution,
                         "Voxels along the domain's longest side instead of the scene's voxel size"),
          "N");
    oneOf(app.add_option("--where", a.where, "Which voxels are baked"), kWhereNames);
    oneOf(app.add_option("--paths", a.paths, "caustic: light that was refracted or reflected at least once; or all"),
          kPathsNames);
    oneOf(app.add_option("--quadrature", a.quadrature,
                         "Points across a layer of voxels (default: by the slant of the light)"),
          {"1", "2", "4", "6", "8", "12"});
    oneOf(app.add_option("--lobes", a.lobes,
                         "Directions that a voxel keeps where light opposes itself (default: 2, where it does)"),
          {"1", "2"});
    value(app.add_option("--tolerance", a.tolerance, "Refinement tolerance [voxels]"), "VOXELS");
    oneOf(app.add_option("--measure", a.measure,
                         "Measure how far look-ups on flat receivers are from the light there: quick takes about a "
                         "quarter of the bake's time (default: quick)"),
          kMeasureNames);
    value(app.add_option(
              "--error", a.error,
              "Choose the voxels so that look-ups on flat receivers are off by at most this, for instance 2% (also "
              "the default where neither scene nor command line say how wide voxels should be)"),
          "SHARE");
    value(app.add_option("--budget", a.budget,
                         "With an error, or where nothing says how wide voxels should be: most "
                         "that a volume may take on disk [MB] (default: 256)"),
          "MB");
    value(app.add_option("--seconds", a.seconds, "Likewise, most that its bake may take [s] (default: 10)"), "SECONDS");
    value(app.add_option("--detail", a.detail,
                         "Texels that look-ups are measured on [m] (default: a 512th of each receiver)"),
          "METRES");
    app.add_flag_function(
        "--prefilter,!--no-prefilter", [&a](std::int64_t count) { a.prefilter = count > 0; },
        "Invert the blur of trilinear look-ups");
}

/// What is written.
void bindWritten(CLI::App& app, BakeArguments& a) {
    value(app.add_option("--grids", a.grids,
                         fmt::format("Grids to write, comma-separated: {}", fmt::join(gridNames(), ", "))),
          "NAMES")
        ->delimiter(',');
    value(repeated(app.add_option("--post", a.post,
                                  "A step on the caustic grid: sharpen=A,B or dissipate=Z,SPEED (photic help post)")),
          "STEP");
    value(repeated(app.add_option("--set", a.set, "An option of a method, as listed below")), "METHOD.OPTION=VALUE");
    addStoredAs(app, a.file);
    named<Compression>(
        app, "--compression",
        {{"none", Compression(0)}, {"mask", Compression(1)}, {"blosc", Compression(2)}, {"zip", Compression(3)}},
        a.file.compression, "How the .vdb is packed (default: mask)");
    value(
        app.add_option("--standard-error", a.standard_error_file,
                       "Also write the standard error per voxel, as irradiance, to a .vdb, where the method knows it"),
        "FILE");
}

}  // namespace

void bindBake(CLI::App& app, BakeArguments& a) {
    bindRun(app, a);
    bindSettings(app, a);
    bindWritten(app, a);
}

std::string methodNotes() {
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

void bindInspect(CLI::App& app, InspectArguments& a) {
    value(app.add_option("VOLUME", a.volume, "Light volume (.vdb)"), "FILE")->required();
    app.add_flag("--json", a.json, "Print JSON on stdout");
    app.add_flag("--strict", a.strict, "Exit with 1 when a law does not hold");
}

void bindCompare(CLI::App& app, CompareArguments& a) {
    value(app.add_option("A", a.a, "Volume (.vdb) or image (.exr)"), "FILE")->required();
    value(app.add_option("B", a.b, "The reference, of the same kind"), "FILE")->required();
    notNegative(
        value(app.add_option("--max-error", a.max_error, "Exit with 1 above this relative L1 error, for instance 0.01"),
              "SHARE"));
    value(app.add_option("--standard-error", a.standard_error,
                         "Volume of B's standard error: adds chi-squared and z scores"),
          "FILE");
    within(value(app.add_option("--bias-allowance", a.bias_allowance, "Relative bias that the scores forgive, 0 to 1"),
                 "SHARE"),
           0, 1);
    positive(value(app.add_option("--most-standard-error", a.most_standard_error,
                                  "Score only voxels whose standard error is at most this share of B's light"),
                   "SHARE"));
    value(app.add_option("--difference", a.difference, "Write A - B as a colour-mapped PNG (images only)"), "FILE");
    app.add_flag("--json", a.json, "Print JSON on stdout");
}

void bindPicture(CLI::App& app, PictureArguments& a) {
    value(app.add_option("SCENE", a.scene, "Scene file (.toml, .glb or .gltf)"), "FILE")->required();
    value(app.add_option("VOLUME", a.volumes, "Volumes baked from it; several with --film-strip"), "FILE")->required();
    value(app.add_option("-o,--output", a.directory, "Folder for the pictures (default: the current one)"), "FOLDER");
    value(repeated(app.add_option("--receiver", a.receivers, "Receiver to picture (default: all)")), "NAME");
    value(repeated(app.add_option("--slice", a.slices, "A layer of voxels, for instance z=-0.5 [m]")), "AXIS=METRES");
    oneOf(repeated(app.add_option("--xray", a.xrays, "Mean along an axis (default: y)")), {"x", "y", "z"});
    within(
        value(app.add_option("--resolution", a.resolution, "Texels along a receiver's longer side, 1 to 16384"), "N"),
        1, 16384);
    positive(value(app.add_option("--exposure", a.exposure, "Brightness of the display pictures"), "FACTOR"));
    positive(value(app.add_option("--max", a.max, "Top of the colour bar [W/m2] (default: from the picture)"), "W/M2"));
    oneOf(app.add_option("--colour-map", a.colour_map, "Colours of the mapped pictures"), colourMapNames());
    app.add_flag("--film-strip", a.film_strip, "One picture with all volumes side by side, of each thing asked for");
    within(value(app.add_option("--columns", a.columns, "Pictures a row of a film strip, 1 to 1000"), "N"), 1, 1000);
    app.add_flag("--view", a.view, "Also a perspective view of the lit scene through its water");
    app.add_flag("--view-only", a.view_only, "Only that view");
    value(app.add_option("--eye", a.eye, "Camera position [m], written --eye=-2,-3,2"), "X,Y,Z");
    value(app.add_option("--target", a.target, "Point looked at [m]"), "X,Y,Z");
    within(value(app.add_option("--fov", a.field_of_view_deg, "Field of view [degrees], 1 to 150"), "DEGREES"), 1, 150);
    value(app.add_option("--size", a.size, "Size of the view, for instance 960x640"), "WIDTHxHEIGHT");
    within(value(app.add_option("--samples", a.samples, "Samples a side and pixel of the view, 1 to 16"), "N"), 1, 16);
    notNegative(value(app.add_option("--tiles", a.tile_size, "Draw tiles of this size [m] on receivers in the view"),
                      "METRES"));
    notNegative(
        value(app.add_option("--shafts", a.shafts, "Scattering [1/m] shown in the view instead of the medium's"),
              "PER_METRE"));
    within(value(app.add_option("--shafts-g", a.shaft_anisotropy, "Anisotropy of that scattering, -0.99 to 0.99"), "G"),
           -0.99, 0.99);
    oneOf(app.add_option("--look", a.look,
                         "cutaway: open sides, straight eye rays; natural: solid sides, eye rays refract"),
          {"cutaway", "natural"});
    app.add_flag("!--no-surface", a.show_surface, "Look through the water surface as if it were not there");
}

void bindExport(CLI::App& app, ExportArguments& a) {
    value(app.add_option("VOLUME", a.volumes,
                         "Light volume (.vdb); several are frames, laid out alike; or, for an .ivol, a scene (.toml)"),
          "FILE")
        ->required();
    value(app.add_option("-o,--output", a.output,
                         "File to write; its extension is the format: .nvdb, .ktx2, .dds, .vf, .exr or .usda, and "
                         ".ivol of a scene's media whose index varies. #### is the frame of a volume"),
          "FILE");
    value(app.add_option("--web", a.web,
                         "Folder for a page that shows the volume in a browser, instead of -o; wants --scene"),
          "FOLDER");
    app.add_flag("--shared-script", a.shared_script,
                 "Of --web: photic.js goes beside FOLDER and not into it, so that pages in one folder share it");
    app.add_flag("--l1", a.l1,
                 "Of .dds and .ktx2: what faces get, by harmonics of order 0 and 1, as VRChat's and Bakery's light "
                 "volumes have it");
    named<NvdbPrecision>(app, "--precision", {{"half", NvdbPrecision::Half}, {"float", NvdbPrecision::Float}},
                         a.precision, "Of an .nvdb (default: half)");
    named<NvdbCodec>(app, "--codec", {{"none", NvdbCodec::None}, {"zip", NvdbCodec::Zip}, {"blosc", NvdbCodec::Blosc}},
                     a.codec, "Of an .nvdb (default: blosc); the run-time library reads all but zip");
    value(app.add_option("--budget", a.budget_mb,
                         "Memory that a volume may take in a game: leaves out what it must, and says what that costs"),
          "MIB");
    value(app.add_option(
                 "--levels", a.levels,
                 "Of an .nvdb with --budget: 2 lets smooth light have voxels twice as wide, 1 does not (default: 2)")
              ->check(CLI::Range(1, 2)),
          "N");
    named<ExportTexels>(
        app, "--compress", {{"none", ExportTexels::None}, {"bc6h", ExportTexels::Bc6h}, {"auto", ExportTexels::Auto}},
        a.compress,
        "Of an .nvdb: light in blocks of BC6H, two bytes a voxel; auto: where --budget leaves a smaller "
        "error with it (default: none)");
    value(
        app.add_option(
            "--scene", a.scene,
            "Scene file that it was baked from: --budget keeps voxels around its receivers, and measures there; --web "
            "shows it"),
        "FILE");
    value(app.add_option("--sequence", a.sequence,
                         "All volumes of the sequence that VOLUME... are a part of: parts that are exported apart then "
                         "share one box, and one --budget"),
          "FILE");
    value(app.add_option("--box", a.box,
                         "Of .ktx2, .dds, .vf and .exr: corners [m] of what they hold, instead of the voxels with "
                         "light; written --box=-1,-1,-2,1,1,0"),
          "X,Y,Z,X,Y,Z");
    auto* voxel_size =
        app.add_option("--voxel-size", a.voxel_size, "Of an .ivol: of formulas' samples [m] (default: the scene's)");
    value(voxel_size, "M");
    positive(voxel_size);
    named<ExportBodies>(app, "--bodies", {{"sharp", ExportBodies::Sharp}, {"samples", ExportBodies::Samples}}, a.bodies,
                        "Of an .ivol: closed meshes and spheres as they are, with sharp faces, or as samples of their "
                        "index (default: sharp)");
    app.add_flag("--json", a.json, "Print what was written as JSON on stdout");
}

void bindSample(CLI::App& app, SampleArguments& a) {
    value(app.add_option("VOLUME", a.volumes,
                         "Light volume (.vdb); several are frames, and #### in a name is the frame of --frames"),
          "FILE")
        ->required();
    value(app.add_option("POINTS", a.points,
                         "Table of points, or - for stdin: x,y,z [m] or x,y,z,nx,ny,nz a line; a first row may name "
                         "the columns"),
          "FILE");
    value(app.add_option("-o,--output", a.output, "Table to write (default: -, which is stdout)"), "FILE");
    value(app.add_option_function<std::string>(
              "--frames", [&a](const std::string& text) { a.frames = parseFrames(text); },
              "Frames that #### in a volume's name stands for, for instance 1-48"),
          "A-B");
    app.add_flag("--json", a.json, "Write JSON instead of a table");
}

void bindScene(CLI::App& app, SceneArguments& a) {
    value(app.add_option("FILE", a.gltf, "glTF with lights and materials (.glb, .gltf)"), "FILE")->required();
    value(app.add_option("-o,--output", a.output, "Scene file to write (.toml)"), "FILE")->required();
}

void bindVoxelise(CLI::App& app, VoxeliseArguments& a) {
    value(app.add_option("FILE", a.input,
                         "A closed mesh (.obj, .ply, .gltf, .glb), a profile that turns about z (.csv: radius, height "
                         "[m]), or several bodies (.toml)"),
          "FILE")
        ->required();
    value(app.add_option("-o,--output", a.output, "Samples to write (.vdb): n, and absorption where there is any"),
          "FILE")
        ->required();
    within(value(app.add_option("--ior", a.ior, "Index of refraction (default: 1.5), 0.01 to 100"), "N"), 0.01, 100);
    positive(value(app.add_option("--voxel-size", a.voxel_size, "Size of a voxel [m]"), "METRES"));
    within(value(app.add_option("--smooth", a.smooth,
                                "Deviation of a Gaussian over n [voxels], 0 to 100; what it does to n is said"),
                 "VOXELS"),
           0, 100);
    value(app.add_option("--absorption", a.absorption, "Of the body [1/m]: one value, or red,green,blue"), "PER_METRE")
        ->delimiter(',')
        ->check(notBelow0());
}

void bindPost(CLI::App& app, PostArguments& a) {
    value(app.add_option("VOLUME", a.volume, "Light volume (.vdb) with a grid 'caustic'"), "FILE")->required();
    value(app.add_option("-o,--output", a.output, "Volume to write"), "FILE")->required();
    value(repeated(app.add_option(
              "--step", a.steps,
              "sharpen=A,B: a * phi^b. dissipate=Z,SPEED: below the height Z [m] each layer is a step of a wave of "
              "SPEED voxels a layer. Applied in order")),
          "STEP");
    app.add_flag("--as-light", a.as_light,
                 "Make the caustic grid the irradiance, for pictures and readers that want light");
    addStoredAs(app, a.file);
}

void bindMerge(CLI::App& app, MergeArguments& a) {
    value(app.add_option("TILE", a.tiles, "All tiles of one volume (.vdb), in any order"), "FILE")->required();
    value(app.add_option("-o,--output", a.output, "Volume to write"), "FILE")->required();
    app.add_flag("--json", a.json, "Print what was merged as JSON on stdout");
}

void bindMethods(CLI::App& app, MethodsArguments& a) { app.add_flag("--json", a.json, "Print JSON on stdout"); }

void bindCompletions(CLI::App& app, TextArguments& a) {
    oneOf(app.add_option("SHELL", a.shell, "Whose completions"), {"bash", "zsh", "fish"});
    app.get_option("SHELL")->required();
}
void bindMan(CLI::App&, TextArguments&) {}

void bindShared(CLI::App& app, SharedArguments& a) {
    oneOf(app.add_option("--progress", a.progress,
                         "On stderr: a bar, JSON lines or nothing (default: a bar on a terminal)"),
          {"bar", "json", "none"});
    app.add_flag("-q,--quiet", a.quiet, "Say nothing but warnings and errors");
    within(value(app.add_option("--threads", a.threads, "Threads; 0 takes all cores. Results don't depend on it"), "N"),
           0, 1024);
    value(app.add_option("--max-memory", a.max_memory_bytes,
                         "Take no more memory, for instance 8GB: what would is baked in slabs, refused or ended")
              ->check(sizeNotNegative())
              ->transform(CLI::AsSizeValue(false)),
          "SIZE");
}

}  // namespace photic::cli
