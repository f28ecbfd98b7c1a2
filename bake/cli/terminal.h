// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "bake/methods/catalogue.h"
#include "bake/report/monitor.h"

namespace photic::cli {

enum class ProgressMode { Auto, Bar, Events, None };  ///< Auto: a bar when stderr is a terminal

enum class Loudness { Normal, Quiet };  ///< Quiet: nothing but warnings and errors

/// Whether text for `descriptor` may be coloured: it is a terminal, and NO_COLOR (no-color.org) is not set.
bool wantsColour(int descriptor);

/// What people (or, with --progress=json, programs) read on stderr while a verb runs. stdout is for data alone.
class Terminal final : public Monitor {
public:
    explicit Terminal(ProgressMode mode, Loudness loudness = Loudness::Normal);
    ~Terminal() override;

    void progress(std::string_view stage, double fraction) override;
    void warn(const std::string& message) override;
    void note(const std::string& message) override;
    bool cancelled() const override;

    /// The run has `count` parts (frames) of about equal work; number `index` begins.
    void beginPart(int index, int count);
    /// The stages that the part is going to have, one after the other.
    void expect(const std::vector<Stage>& stages);
    /// Warnings since the last call, in order.
    std::vector<std::string> takeWarnings();

    /// A line for people; silent when events are asked for.
    void say(const std::string& line);
    /// One event, a line of JSON; silent otherwise.
    void event(const std::string& json_line);
    /// What went wrong, for people or as an `error` event.
    void error(const Error& error);
    /// The same from beside the work, which may be writing: says nothing then.
    void lastWord(const Error& error);
    /// Clears the bar.
    void finish();

    bool json() const { return mode_ == ProgressMode::Events; }

private:
    void clearBar();
    void writeError(const Error& error);
    /// "photic: warning: " in a colour where there are colours.
    std::string label(const char* text, const char* colour) const;
    void write(const std::string& line);
    /// The share of the run that is done once `fraction` of a stage is.
    double overall(std::string_view stage, double fraction);
    void show(std::string_view stage, double fraction);

    using Clock = std::chrono::steady_clock;
    mutable std::mutex mutex_;
    ProgressMode mode_;
    Loudness loudness_;
    bool colour_;
    int part_ = 0, parts_ = 1;
    std::vector<Stage> stages_;  ///< of the part
    double part_seconds_ = 0;    ///< of all its stages
    double part_fraction_ = 0;
    std::string stage_;
    bool bar_shown_ = false;
    Clock::time_point start_ = Clock::now(), last_shown_{};
    std::vector<std::string> warnings_;
    std::set<std::string> notes_;
};

}  // namespace photic::cli
