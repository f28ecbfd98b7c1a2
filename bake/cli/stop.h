// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

#include "bake/report/error.h"

namespace photic::cli {

/// Why the work is to end before it is done.
enum class Stop {
    No,
    Signal,  ///< SIGINT or SIGTERM has arrived
    Memory   ///< the process holds more than watchMemory() allowed
};
Stop stopWanted();

/// How long [s] the work has for ending by itself once it is told to. Then the process is ended: files are written
/// under temporary names, so that nothing half-written is left under its own.
inline constexpr double kPatience = 1.7;

/// Makes SIGINT and SIGTERM ask for a stop, and writes to closed pipes and full disks fail with an error instead of a
/// signal. A thread then watches that the process ends.
/// @param last_word  says why, when the work did not end by itself
void watchSignals(std::function<void(const Error&)> last_word);

/// From now on asks for a stop when the process holds more [bytes]. Looks twenty times a second.
void watchMemory(std::int64_t most_bytes);
/// What watchMemory() allows [bytes]; 0: no limit.
std::int64_t memoryAllowed();

/// What a stop is for the caller: itself, or for Error{Cancelled} why there was one.
Error explained(const Error& error);

}  // namespace photic::cli
