// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace photic {

/// "0.1.0", from the project's CMakeLists.txt.
const std::string& programVersion();
/// "photic 0.1.0", as volumes and reports name what made them.
const std::string& programName();

}  // namespace photic
