// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/arguments.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <functional>
#include <memory>
#include <string_view>

#include "bake/baker/version.h"
#include "bake/cli/stop.h"
#include "bake/cli/verb_options.h"
#include "bake/cli/verb_text.h"
#include "bake/cli/verbs.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"
#include "bake/threads/parallel_for.h"

namespace photic::cli {

namespace {

constexpr const char* kSummary =
    "Photic bakes caustics, the light that water, glass and mirrors focus, into sparse OpenVDB volumes.";
constexpr const char* kExitCodes =
    "Exit codes: 0 done, 1 a check found more than was allowed, 2 usage, 3 input, 4 bake or write failed, 75 try "
    "again, 130 interrupted. Data goes to stdout, messages to stderr.";

/// One verb of the program: all that the rest of it knows of the verb.
struct VerbRow {
    std::string name, summary;
    std::vector<std::string> examples;
    /// Adds the verb's arguments; what it returns runs the verb once they are parsed.
    std::function<VerbRun(CLI::App&)> add;
    std::string (*notes)() = nullptr;  ///< more for its help page
};

/// A row whose arguments are a struct that `run` takes.
template <class Arguments>
VerbRow verb(std::string name, std::string summary, std::vector<std::string> examples,
             void (*bind)(CLI::App&, Arguments&), std::string (*notes)() = nullptr) {
    return {std::move(name), std::move(summary), std::move(examples),
            [bind](CLI::App& app) -> VerbRun {
                const auto arguments = std::make_shared<Arguments>();
                bind(app, *arguments);
                return [arguments](Terminal& terminal) { return run(*arguments, terminal); };
            },
            notes};
}

/// All verbs, in the order of the help.
const std::vector<VerbRow>& verbTable() {
    static const std::vector<VerbRow> rows{
        verb<BakeArguments>(
            "bake", "Bake a scene into a light volume",
            {"photic bake pool.toml -o out/pool.vdb", "photic bake room.glb -o out/room.vdb",
             "photic bake pool.toml --dry-run", "photic bake waves.toml --frames 1-48 -o out/waves.####.vdb",
             "photic bake pool.toml --tile 3/8 -o out/pool.vdb"},
            bindBake, methodNotes),
        verb<SceneArguments>("scene", "Write what a glTF is taken for as a scene file, to change it",
                             {"photic scene room.glb -o room.toml"}, bindScene),
        verb<InspectArguments>("inspect", "Say what a volume holds and check its laws", {"photic inspect out/pool.vdb"},
                               bindInspect),
        verb<CompareArguments>("compare", "Measure how far two volumes or two EXR images are apart",
                               {"photic compare pool.vdb reference.vdb --max-error 0.01"}, bindCompare),
        verb<PictureArguments>("picture", "Show receivers as they will be lit, slices, x-rays and views",
                               {"photic picture pool.toml out/pool.vdb -o pictures --view"}, bindPicture),
        verb<ExportArguments>(
            "export", "Write a volume for games and other programs, or as a page for browsers",
            {"photic export out/pool.vdb -o game/pool.nvdb",
             "photic export out/waves.*.vdb -o game/waves.####.nvdb --budget 16",
             "photic export out/pool.vdb --scene pool.toml --web page", "photic export glass.toml -o game/glass.ivol"},
            bindExport),
        verb<SampleArguments>("sample", "Measure the light at points: irradiance, direction, what faces get",
                              {"photic sample out/pool.vdb points.csv -o light.csv",
                               "photic sample out/waves.####.vdb - --frames 1-48 < points.csv"},
                              bindSample),
        verb<VoxeliseArguments>("voxelise", "Make a body into samples of its index, for media that bend light",
                                {"photic voxelise ball.ply --ior 1.5 --voxel-size 0.002 -o ball.vdb",
                                 "photic voxelise wine_glass.toml --smooth 1 -o wine_glass.vdb"},
                                bindVoxelise),
        verb<MergeArguments>("merge", "Join the tiles of a volume that was baked in parts",
                             {"photic merge out/pool.tile*.vdb -o out/pool.vdb"}, bindMerge),
        verb<MethodsArguments>("methods", "List the bake methods and their options", {"photic methods"}, bindMethods),
        verb<PostArguments>("post", "Sharpen or dissipate the caustic grid of a volume",
                            {"photic post pool.vdb --step sharpen=0.5,0.8 -o sharp.vdb"}, bindPost),
        {"view",
         "Show volumes, or water without a bake, in a window or as a screenshot",
         {"photic view pool.toml out/pool.vdb"},
         [](CLI::App&) -> VerbRun { return {}; }},
        verb<TextArguments>("completions", "Print the completions for a shell",
                            {"photic completions bash > ~/.local/share/bash-completion/completions/photic"},
                            bindCompletions),
        verb<TextArguments>("man", "Print the manual page", {"photic man | man -l -"}, bindMan)};
    return rows;
}

/// A verb with its arguments, ready to parse them.
struct Parser {
    std::unique_ptr<CLI::App> app;
    VerbRun run;
};

Parser parserOf(const VerbRow& row, SharedArguments& shared) {
    Parser parser{std::make_unique<CLI::App>(row.summary, "photic " + row.name), {}};
    parser.run = row.add(*parser.app);
    if (parser.run) bindShared(*parser.app, shared);
    return parser;
}

OptionText textOf(const CLI::Option& option) {
    OptionText text;
    text.argument = option.get_positional();
    text.required = option.get_required();
    text.repeats = option.get_items_expected_max() > 1;
    text.help = option.get_description();
    if (option.get_type_size_max() > 0) text.value = option.get_type_name();
    // CLI11 appends what it checks, in words of its own.
    text.value.resize(std::min(text.value.size(), text.value.find(':')));
    if (text.argument) {
        text.names = {option.get_single_name()};
        return text;
    }
    for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
    if (text.repeats) text.help += "; may be repeated";
    return text;
}

VerbText textOf(const VerbRow& row) {
    SharedArguments shared;
    const Parser parser = parserOf(row, shared);
    VerbText text{row.name, row.summary, row.examples, {}, row.notes ? row.notes() : ""};
    for (const CLI::Option* option : parser.app->get_options()) text.options.push_back(textOf(*option));
    return text;
}

ProgramText programText() {
    ProgramText text{kSummary, kExitCodes, {}};
    for (const VerbRow& row : verbTable()) text.verbs.push_back(textOf(row));
    return text;
}

const VerbRow& rowNamed(const std::string& name) {
    std::vector<std::string> known;
    for (const VerbRow& row : verbTable()) {
        if (row.name == name) return row;
        known.push_back(row.name);
    }
    const std::string near = nearestName(name, known);
    throw Error(ErrorCode::Usage,
                fmt::format("unknown verb '{}'; {}the verbs are: {}", name,
                            near.empty() ? "" : "did you mean '" + near + "'? ", fmt::join(known, ", ")));
}

VerbRun printed(std::string page) {
    return [page = std::move(page)](Terminal&) {
        std::fputs(page.c_str(), stdout);
        return 0;
    };
}

/// Of an option that does not exist, with the one that may be meant; empty where all are known.
std::string unknownOption(const std::vector<std::string>& known, const std::vector<std::string>& words) {
    for (const std::string& word : words) {
        const std::string name = word.substr(0, word.find('='));
        if (!name.starts_with("-") || name.size() < 3 || std::isdigit(static_cast<unsigned char>(name[1]))) continue;
        const std::string full = name.starts_with("--") ? name : "-" + name;
        const bool is_known = std::find(known.begin(), known.end(), full) != known.end();
        if (name.starts_with("--") ? is_known : !is_known) continue;
        const std::string near = is_known ? full : nearestName(name, known);
        return fmt::format("there is no option {}{}", name, near.empty() ? "" : "; did you mean " + near + "?");
    }
    return {};
}

/// What is wrong with a command line, in words of ours; with a suggestion for an option that does not exist.
std::string complaint(const CLI::App& app, const CLI::ParseError& error, const std::vector<std::string>& words) {
    std::vector<std::string> known;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    known.push_back("--help");
    // A verb that lacks its file may have been asked for help with a slip of the pen.
    const bool extras = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
    if (extras || dynamic_cast<const CLI::RequiredError*>(&error)) {
        if (const std::string unknown = unknownOption(known, words); !unknown.empty()) return unknown;
    }
    if (extras) {
        return fmt::format("more than the verb takes: {}", fmt::join(app.remaining(), " "));
    }
    // CLI11's own words would name types of C++.
    const std::string what = error.what(), name = what.substr(0, what.find(": "));
    if (what.ends_with(" missing")) return name + " wants a value";
    // Its older versions write "At Most".
    for (const char* too_many : {": At most 1 ", ": At Most 1 "})
        if (what.find(too_many) != std::string::npos) return name + " is given more than once";
    constexpr std::string_view kNoNumber = "Could not convert: ";
    if (what.starts_with(kNoNumber))
        return fmt::format("{} is no number that can be used", what.substr(kNoNumber.size()));
    return what;
}

}  // namespace

int run(const TextArguments& arguments, Terminal&) {
    const ProgramText text = programText();
    std::fputs((arguments.shell.empty() ? manPage(text) : completions(text, arguments.shell)).c_str(), stdout);
    return 0;
}

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

Loudness loudness(int argc, const char* const* argv) {
    const bool quiet = std::any_of(argv + std::min(argc, 2), argv + argc,
                                   [](std::string_view word) { return word == "-q" || word == "--quiet"; });
    return quiet ? Loudness::Quiet : Loudness::Normal;
}

VerbRun parseArguments(int argc, const char* const* argv) {
    std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
    if (words.empty())
        throw Error(ErrorCode::Usage, "a verb is wanted, for instance photic bake pool.toml; see photic --help");
    const auto asksHelp = [](const std::string& word) { return word == "-h" || word == "--help"; };
    if (words[0] == "-V" || words[0] == "--version") return printed(programName() + "\n");
    if (asksHelp(words[0]) || (words[0] == "help" && words.size() == 1))
        return printed(helpPage(programText(), pageStyle()));
    if (words[0] == "help") words = {words[1], "--help"};
    if (words[0].starts_with('-'))
        throw Error(ErrorCode::Usage, fmt::format("'{}' stands before the verb; see photic --help", words[0]));
    const VerbRow& row = rowNamed(words[0]);
    words.erase(words.begin());

    SharedArguments shared;
    const Parser parser = parserOf(row, shared);
    // The viewer is a program of its own, which reads its arguments itself.
    if (!parser.run) return [arguments = ViewArguments{words}](Terminal& terminal) { return run(arguments, terminal); };
    if (std::any_of(words.begin(), words.end(), asksHelp)) return printed(helpPage(textOf(row), pageStyle()));
    try {
        std::vector<std::string> reversed(words.rbegin(), words.rend());  // as CLI11 wants them
        parser.app->set_help_flag();
        parser.app->parse(reversed);
    } catch (const CLI::ParseError& error) {
        throw Error(ErrorCode::Usage,
                    fmt::format("{}; see photic {} --help", complaint(*parser.app, error, words), row.name));
    }
    setThreadCount(shared.threads);
    if (shared.max_memory_bytes > 0) watchMemory(shared.max_memory_bytes);
    return parser.run;
}

}  // namespace photic::cli
