// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "bake/cli/verbs.h"

namespace CLI {
class App;
}

namespace photic::cli {

/// What is asked of the program about itself.
struct TextArguments {
    std::string shell;  ///< whose completions; empty: the manual page
};

/// Prints it.
int run(const TextArguments& arguments, Terminal& terminal);

/// What every verb takes.
struct SharedArguments {
    std::string progress;
    bool quiet = false;
    int threads = 0;
    std::int64_t max_memory_bytes = 0;  ///< 0: no limit
};

// The options and arguments of each verb, written into its struct as they are parsed. An option's type name is what
// stands for its value in the help: words between "|" are all that it can be.

void bindBake(CLI::App& app, BakeArguments& arguments);
void bindInspect(CLI::App& app, InspectArguments& arguments);
void bindCompare(CLI::App& app, CompareArguments& arguments);
void bindPicture(CLI::App& app, PictureArguments& arguments);
void bindExport(CLI::App& app, ExportArguments& arguments);
void bindSample(CLI::App& app, SampleArguments& arguments);
void bindScene(CLI::App& app, SceneArguments& arguments);
void bindVoxelise(CLI::App& app, VoxeliseArguments& arguments);
void bindPost(CLI::App& app, PostArguments& arguments);
void bindMerge(CLI::App& app, MergeArguments& arguments);
void bindMethods(CLI::App& app, MethodsArguments& arguments);
void bindCompletions(CLI::App& app, TextArguments& arguments);
void bindMan(CLI::App& app, TextArguments& arguments);
void bindShared(CLI::App& app, SharedArguments& arguments);

/// The methods and their options, for the help of `bake`.
std::string methodNotes();

}  // namespace photic::cli
