// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/terminal.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "bake/report/printable.h"

namespace photic::cli {

namespace {

std::atomic<bool> g_interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

/// The share of a bake that lies before a stage and in it: only the order and rough size matter, for the bar and the
/// ETA.
struct StageShare {
    std::string_view stage;
    double begin, end;
};
constexpr StageShare kStages[] = {{"scene", 0.0, 0.05},    {"needed", 0.05, 0.08}, {"trace", 0.08, 0.25},
                                  {"deposit", 0.25, 0.75}, {"field", 0.75, 0.82},  {"write", 0.82, 1.0}};
constexpr double kSecondsBetweenUpdates = 0.1;

}  // namespace

void installSignalHandlers() {
    struct sigaction action {};
    action.sa_handler = [](int) { g_interrupted.store(true); };
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    // A write past the file-size limit, or into a pipe that nobody reads, then returns an error that is reported.
    std::signal(SIGXFSZ, SIG_IGN);
    std::signal(SIGPIPE, SIG_IGN);
}

bool interrupted() { return g_interrupted.load(); }

Terminal::Terminal(ProgressMode mode) : mode_(mode) {
    if (mode_ == ProgressMode::Auto) mode_ = isatty(STDERR_FILENO) ? ProgressMode::Bar : ProgressMode::None;
}

Terminal::~Terminal() { clearBar(); }

void Terminal::beginPart(int index, int count) {
    const std::lock_guard lock(mutex_);
    part_ = index;
    parts_ = std::max(1, count);
    part_fraction_ = 0;
    stage_.clear();
}

std::vector<std::string> Terminal::takeWarnings() {
    const std::lock_guard lock(mutex_);
    return std::exchange(warnings_, {});
}

double Terminal::overall(std::string_view stage, double fraction) {
    for (const StageShare& share : kStages) {
        if (share.stage == stage)
            part_fraction_ = std::max(part_fraction_, share.begin + fraction * (share.end - share.begin));
    }
    return (part_ + part_fraction_) / parts_;
}

void Terminal::progress(std::string_view stage, double fraction) {
    if (mode_ == ProgressMode::None) return;
    const std::lock_guard lock(mutex_);
    fraction = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
    const bool whole = stage != stage_ || fraction >= 1;
    const auto now = Clock::now();
    if (!whole && std::chrono::duration<double>(now - last_shown_).count() < kSecondsBetweenUpdates) {
        overall(stage, fraction);
        return;
    }
    last_shown_ = now;
    stage_ = stage;
    show(stage, fraction);
}

void Terminal::show(std::string_view stage, double fraction) {
    const double done = overall(stage, fraction);
    const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
    // Too early to tell: an estimate from a few per cent of the work is noise.
    const bool knows_eta = done > 0.05 && elapsed > 0.2;
    const double eta = knows_eta ? elapsed * (1 - done) / done : 0;
    if (mode_ == ProgressMode::Events) {
        nlohmann::ordered_json line{{"event", "progress"}, {"stage", stage}, {"fraction", fraction}, {"overall", done}};
        line["eta_s"] =
            knows_eta ? nlohmann::ordered_json(std::round(eta * 100) / 100) : nlohmann::ordered_json(nullptr);
        write(line.dump());
        return;
    }
    constexpr int kCells = 30;
    const int filled = static_cast<int>(std::lround(done * kCells));
    std::string text = fmt::format("\r\033[K[{}{}] {:3.0f} %  {}", std::string(static_cast<std::size_t>(filled), '#'),
                                   std::string(static_cast<std::size_t>(kCells - filled), '.'), done * 100, stage);
    if (parts_ > 1) text += fmt::format("  {}/{}", part_ + 1, parts_);
    if (knows_eta && eta >= 1) text += fmt::format("  about {:.0f} s left", eta);
    std::fputs(text.c_str(), stderr);
    std::fflush(stderr);
    bar_shown_ = true;
}

void Terminal::clearBar() {
    if (!bar_shown_) return;
    std::fputs("\r\033[K", stderr);
    std::fflush(stderr);
    bar_shown_ = false;
}

void Terminal::write(const std::string& line) {
    clearBar();
    std::fputs((line + "\n").c_str(), stderr);
    std::fflush(stderr);
}

void Terminal::warn(const std::string& message) {
    const std::lock_guard lock(mutex_);
    if (std::find(warnings_.begin(), warnings_.end(), message) != warnings_.end()) return;
    warnings_.push_back(message);
    if (json()) {
        write(nlohmann::ordered_json{{"event", "warning"}, {"message", message}}.dump(
            -1, ' ', false, nlohmann::json::error_handler_t::replace));
    } else {
        write("photic: warning: " + printable(message));
    }
}

void Terminal::say(const std::string& line) {
    const std::lock_guard lock(mutex_);
    if (!json()) write(printable(line));
}

void Terminal::event(const std::string& json_line) {
    const std::lock_guard lock(mutex_);
    if (json()) write(json_line);
}

void Terminal::error(int code, const std::string& where, const std::string& message) {
    const std::lock_guard lock(mutex_);
    if (json()) {
        const nlohmann::ordered_json line{{"event", "error"}, {"code", code}, {"where", where}, {"message", message}};
        write(line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    } else {
        write("photic: error: " + printable((where.empty() ? "" : where + ": ") + message));
    }
}

}  // namespace photic::cli
