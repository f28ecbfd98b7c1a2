// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "bake/report/monitor.h"

namespace photic::cli {

enum class ProgressMode { Auto, Bar, Events, None };  ///< Auto: a bar when stderr is a terminal

/// Makes SIGINT and SIGTERM set a flag, and writes to closed pipes and full disks fail with an error instead of a
/// signal.
void installSignalHandlers();
/// SIGINT or SIGTERM has arrived.
bool interrupted();

/// What people (or, with --progress=json, programs) read on stderr while a verb runs. stdout is for data alone.
class Terminal final : public Monitor {
public:
    explicit Terminal(ProgressMode mode);
    ~Terminal() override;

    void progress(std::string_view stage, double fraction) override;
    void warn(const std::string& message) override;
    bool cancelled() const override { return interrupted(); }

    /// The run has `count` parts (frames) of about equal work; number `index` begins.
    void beginPart(int index, int count);
    /// Warnings since the last call, in order.
    std::vector<std::string> takeWarnings();

    /// A line for people; silent when events are asked for.
    void say(const std::string& line);
    /// One event, a line of JSON; silent otherwise.
    void event(const std::string& json_line);
    /// What went wrong, for people or as an `error` event.
    void error(int code, const std::string& where, const std::string& message);

    bool json() const { return mode_ == ProgressMode::Events; }

private:
    void clearBar();
    void write(const std::string& line);
    double overall(std::string_view stage, double fraction);
    void show(std::string_view stage, double fraction);

    using Clock = std::chrono::steady_clock;
    mutable std::mutex mutex_;
    ProgressMode mode_;
    int part_ = 0, parts_ = 1;
    double part_fraction_ = 0;
    std::string stage_;
    bool bar_shown_ = false;
    Clock::time_point start_ = Clock::now(), last_shown_{};
    std::vector<std::string> warnings_;
};

}  // namespace photic::cli
