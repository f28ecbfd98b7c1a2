// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/cli/verbs.h"

namespace photic::cli {

/// `export -o NAME.usda`: one text layer that refers to all volumes given, as frames where they are several.
int exportUsd(const ExportArguments& arguments, Terminal& terminal);

}  // namespace photic::cli
