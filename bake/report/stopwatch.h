// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <utility>

namespace photic {

/// Time on the wall [s].
class Stopwatch {
public:
    /// Since it was made, or since the last lap.
    double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
    /// As seconds(), and starts again.
    double lap() {
        const Clock::time_point now = Clock::now();
        return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
    }

private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point start_ = Clock::now();
};

}  // namespace photic
