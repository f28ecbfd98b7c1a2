// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/terminal.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <utility>

#include "bake/cli/stop.h"
#include "bake/report/error_text.h"
#include "bake/report/printable.h"

namespace photic::cli {

namespace {

constexpr double kSecondsBetweenUpdates = 0.1;

}  // namespace

bool wantsColour(int descriptor) {
    const char *refused = std::getenv("NO_COLOR"), *terminal = std::getenv("TERM");
    if (refused && *refused) return false;
    return isatty(descriptor) != 0 && !(terminal && std::string_view(terminal) == "dumb");
}

Terminal::Terminal(ProgressMode mode, Loudness loudness)
    : mode_(mode), loudness_(loudness), colour_(wantsColour(STDERR_FILENO)) {
    const bool bar = isatty(STDERR_FILENO) != 0 && loudness_ == Loudness::Normal;
    if (mode_ == ProgressMode::Auto) mode_ = bar ? ProgressMode::Bar : ProgressMode::None;
}

Terminal::~Terminal() { finish(); }

void Terminal::finish() {
    const std::lock_guard lock(mutex_);
    clearBar();
}

void Terminal::beginPart(int index, int count) {
    const std::lock_guard lock(mutex_);
    part_ = index;
    parts_ = std::max(1, count);
    part_fraction_ = 0;
    stages_.clear();
    stage_.clear();
}

void Terminal::expect(const std::vector<Stage>& stages) {
    const std::lock_guard lock(mutex_);
    stages_ = stages;
    part_seconds_ = 0;
    for (const Stage& stage : stages_) part_seconds_ += stage.seconds;
}

bool Terminal::cancelled() const { return stopWanted() != Stop::No; }

std::vector<std::string> Terminal::takeWarnings() {
    const std::lock_guard lock(mutex_);
    return std::exchange(warnings_, {});
}

double Terminal::overall(std::string_view stage, double fraction) {
    double before = 0;
    for (const Stage& expected : stages_) {
        if (expected.name == stage && part_seconds_ > 0)
            part_fraction_ = std::clamp((before + fraction * expected.seconds) / part_seconds_, part_fraction_, 1.0);
        before += expected.seconds;
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
        write(label("photic: warning: ", "\033[1;33m") + printable(message));
    }
}

void Terminal::note(const std::string& message) {
    const std::lock_guard lock(mutex_);
    if (loudness_ != Loudness::Normal || !notes_.insert(message).second) return;
    if (json()) {
        write(nlohmann::ordered_json{{"event", "note"}, {"message", message}}.dump(
            -1, ' ', false, nlohmann::json::error_handler_t::replace));
    } else {
        write(printable(message));
    }
}

void Terminal::say(const std::string& line) {
    const std::lock_guard lock(mutex_);
    if (!json() && loudness_ == Loudness::Normal) write(printable(line));
}

void Terminal::event(const std::string& json_line) {
    const std::lock_guard lock(mutex_);
    if (json()) write(json_line);
}

std::string Terminal::label(const char* text, const char* colour) const {
    return colour_ ? fmt::format("{}{}\033[0m", colour, text) : text;
}

void Terminal::writeError(const Error& error) {
    if (json()) {
        const nlohmann::ordered_json line{{"event", "error"},
                                          {"code", static_cast<int>(error.code())},
                                          {"where", error.where()},
                                          {"message", error.what()}};
        write(line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    } else {
        write(label("photic: error: ", "\033[1;31m") + printable(errorText(error)));
    }
}

void Terminal::error(const Error& error) {
    const std::lock_guard lock(mutex_);
    writeError(error);
}

void Terminal::lastWord(const Error& error) {
    if (const std::unique_lock lock(mutex_, std::try_to_lock); lock.owns_lock()) writeError(error);
}

}  // namespace photic::cli
