// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/cli/terminal.h"
#include "bake/cli/verbs.h"

namespace photic::cli {

/// What --progress asks for, found before anything is parsed: errors of the command line obey it too.
ProgressMode progressMode(int argc, const char* const* argv);

/// Turns the command line into one verb's arguments; answers --help and --version on stdout itself.
/// Sets the number of threads of the process.
/// @throws Error{Usage}
Verb parseArguments(int argc, const char* const* argv);

}  // namespace photic::cli
