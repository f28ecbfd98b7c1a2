// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace photic::cli {

/// The program's version, from the project's CMakeLists.txt.
inline constexpr const char* kVersion = PHOTIC_VERSION;

}  // namespace photic::cli
