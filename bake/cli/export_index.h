// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake/cli/verbs.h"

namespace photic::cli {

/// `export SCENE.toml -o NAME.ivol`: the scene's media whose index varies, for games that look through them.
int exportIndex(const ExportArguments& arguments, Terminal& terminal);

}  // namespace photic::cli
