// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

namespace photic {

/// Threads that parallelFor uses; at least 1.
int threadCount();

/// Sets the number of threads for the whole process. 0 means all cores.
void setThreadCount(int count);

/// Calls body(i) once for each i in [0, count), in any order, on threadCount() threads.
/// Results must not depend on the order: give every i its own output.
/// An exception of any body ends the loop and is rethrown here.
void parallelFor(std::int64_t count, const std::function<void(std::int64_t)>& body);

}  // namespace photic
