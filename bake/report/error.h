// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace photic {

/// What kind of failure an Error is. The values are the program's exit codes (docs/command_line.md).
enum class ErrorCode {
    Usage = 2,       ///< the command line is wrong
    Input = 3,       ///< a scene, image, mesh or volume that was given cannot be used
    Failed = 4,      ///< the bake or a write failed (a full disk too)
    TryAgain = 75,   ///< a passing condition; the same command may succeed later
    Cancelled = 130  ///< SIGINT, SIGTERM or Monitor::cancelled()
};

/// The one exception that the baker throws.
///
/// The message gives the value, the limit and the remedy:
/// "voxel_size 0.5 m exceeds the 0.3 m domain; use 0.15 or less".
class Error : public std::runtime_error {
public:
    /// @param where  file:line, node or option that is to blame; may be empty
    Error(ErrorCode code, const std::string& message, std::string where = {})
        : std::runtime_error(message), code_(code), where_(std::move(where)) {}

    ErrorCode code() const noexcept { return code_; }
    const std::string& where() const noexcept { return where_; }

private:
    ErrorCode code_;
    std::string where_;
};

}  // namespace photic
