// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/cli/terminal.h"
#include "bake/cli/verbs.h"

namespace photic::cli {

/// What --progress asks for, found before anything is parsed: errors of the command line obey it too.
ProgressMode progressMode(int argc, const char* const* argv);

/// Whether --quiet is given, found before anything is parsed.
Loudness loudness(int argc, const char* const* argv);

/// Turns the command line into a verb with its arguments; --help and --version are verbs here too.
/// Sets the number of threads of the process and its limit of memory.
/// @throws Error{Usage}
VerbRun parseArguments(int argc, const char* const* argv);

}  // namespace photic::cli
