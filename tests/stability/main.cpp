// SPDX-License-Identifier: Apache-2.0
// photic_stability: random scenes until the time is over; see README.md.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "bake/threads/parallel_for.h"
#include "tests/stability/random_scene.h"
#include "tests/stability/trial.h"

namespace {

using photic::stability::Outcome;
using photic::stability::SceneModel;
using photic::stability::Violation;

constexpr int kShrinkTries = 60;

struct Arguments {
    double seconds = 60;
    std::uint64_t seed = 1;
    std::int64_t scenes = -1;  ///< no more than these
    int jobs = 0;              ///< scenes side by side; 0: one a core
    unsigned each = 120;       ///< processor seconds that a scene may take
    bool shrink = true;
    std::string keep = "out/stability";  ///< folder of the scenes that failed
};

int usage() {
    fmt::print(
        stderr,
        "photic_stability [--seconds 60] [--seed 1] [--scenes N] [--jobs N] [--each 120] [--keep out/stability] "
        "[--no-shrink]\n"
        "Bakes random scenes, numbered from the seed on, and checks laws that hold for every scene. A scene that "
        "breaks one is made as simple as it can be and kept. As many are tried side by side as there are cores, or "
        "--jobs says; --each says how many processor seconds a scene may take. Exit code: 0, or 1 where a law was "
        "broken.\n");
    return 2;
}

// A message without its place and its numbers.
std::string kindOf(const std::string& refusal) {
    std::string words = refusal.substr(std::min(refusal.find(": "), refusal.size()));
    words.erase(
        std::remove_if(words.begin(), words.end(), [](char c) { return std::isdigit(static_cast<unsigned char>(c)); }),
        words.end());
    return words.substr(std::min<std::size_t>(2, words.size()), 90);
}

// One law that a scene broke: the smallest scene found that still does is kept.
void report(const SceneModel& scene, const Violation& violation, const Arguments& arguments) {
    fmt::print("seed {}: {}: {}\n", scene.seed, violation.law, violation.what);
    std::fflush(stdout);
    const auto alike = [&](const SceneModel& other) {
        const Outcome o = photic::stability::tryScene(other, arguments.each);
        return std::any_of(o.violations.begin(), o.violations.end(),
                           [&](const Violation& v) { return v.law == violation.law; });
    };
    const SceneModel small = arguments.shrink ? photic::stability::shrink(scene, alike, kShrinkTries) : scene;
    const auto folder = std::filesystem::path(arguments.keep) / fmt::format("{}_{}", violation.law, scene.seed);
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "scene.toml") << small.toml(folder.string());
    std::ofstream(folder / "why.txt") << fmt::format("seed {}: {}: {}\n", scene.seed, violation.law, violation.what);
    fmt::print("  {}\n", (folder / "scene.toml").string());
    std::fflush(stdout);
}

/// What became of all scenes.
class Counts {
public:
    void add(const Outcome& outcome) {
        held_ += outcome.kind == Outcome::Kind::Held;
        failures_ += outcome.kind == Outcome::Kind::Broken;
        if (outcome.kind == Outcome::Kind::Refused) {
            ++refused_, ++refusals_[kindOf(outcome.refusal)];
            return;
        }
        for (const Violation& violation : outcome.violations) ++broken_[violation.law];
        double sum = 0;
        for (const auto& [law, seconds] : outcome.seconds) law_seconds_[law] += seconds, sum += seconds;
        scene_seconds_.push_back(sum);
    }

    std::int64_t failures() const { return failures_; }

    void print() {
        fmt::print("{} scenes held every law, {} were refused, {} broke one or more\n", held_, refused_, failures_);
        for (const auto& [law, count] : broken_) fmt::print("  {}: {}\n", law, count);
        for (const auto& [words, count] : refusals_) fmt::print("  refused {} times: {}\n", count, words);
        if (!scene_seconds_.empty()) printTimes();
    }

private:
    void printTimes() {
        std::sort(scene_seconds_.begin(), scene_seconds_.end());
        const auto total = [](auto from, auto to) { return std::accumulate(from, to, 0.0); };
        const std::size_t count = scene_seconds_.size();
        const double all = std::max(1e-9, total(scene_seconds_.begin(), scene_seconds_.end()));
        const auto slowest = static_cast<std::ptrdiff_t>(count - (count + 19) / 20);
        fmt::print("processor seconds a scene: mean {:.2f}, median {:.2f}; the slowest 5 % take {:.0f} % of all\n",
                   all / static_cast<double>(count), scene_seconds_[count / 2],
                   100 * total(scene_seconds_.begin() + slowest, scene_seconds_.end()) / all);
        for (const auto& [law, seconds] : law_seconds_) fmt::print("  {}: {:.1f} %\n", law, 100 * seconds / all);
    }

    std::int64_t held_ = 0, refused_ = 0, failures_ = 0;
    std::map<std::string, int> broken_, refusals_;
    std::map<std::string, double> law_seconds_;
    std::vector<double> scene_seconds_;
};

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--no-shrink") {
            arguments.shrink = false;
            continue;
        }
        if (i + 1 >= argc) return usage();
        const char* const value = argv[++i];
        if (word == "--seconds")
            arguments.seconds = std::atof(value);
        else if (word == "--seed")
            arguments.seed = std::strtoull(value, nullptr, 10);
        else if (word == "--scenes")
            arguments.scenes = std::atoll(value);
        else if (word == "--jobs")
            arguments.jobs = std::atoi(value);
        else if (word == "--each")
            arguments.each = static_cast<unsigned>(std::clamp(std::atoi(value), 1, 3600));
        else if (word == "--keep")
            arguments.keep = value;
        else
            return usage();
    }

    const auto start = std::chrono::steady_clock::now();
    const auto elapsed = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    Counts counts;
    std::uint64_t seed = arguments.seed;
    const auto next = [&]() -> std::optional<SceneModel> {
        const bool over =
            arguments.scenes >= 0 && seed >= arguments.seed + static_cast<std::uint64_t>(arguments.scenes);
        if (over || elapsed() >= arguments.seconds) return std::nullopt;
        return photic::stability::randomScene(seed++);
    };
    const int jobs = arguments.jobs > 0 ? arguments.jobs : photic::threadCount();
    photic::stability::tryScenes(jobs, arguments.each, next, [&](const SceneModel& scene, const Outcome& outcome) {
        counts.add(outcome);
        for (const Violation& violation : outcome.violations) report(scene, violation, arguments);
    });
    counts.print();
    return counts.failures() > 0;
}
