// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bake/scene/config_tree.h"

namespace photic {

/// What a value means, the same for the same tables however they are written: without comments, layout, the order of
/// keys, and how a number is spelled.
std::string meaningOf(const ConfigValue& value);

}  // namespace photic
