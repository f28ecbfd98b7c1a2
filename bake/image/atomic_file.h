// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace photic {

/// Writes `bytes` beside `path` under a temporary name, flushes them to the disk, and renames. On failure the old file
/// is intact and the temporary one is gone.
/// @throws Error{Failed} with the path and the system's reason
void writeFileAtomically(const std::string& path, std::string_view bytes);

/// All bytes of a file.
/// @throws Error{Input} with the path and the system's reason
std::string readFileBytes(const std::string& path);

}  // namespace photic
