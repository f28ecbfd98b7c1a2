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
#include <string>

#include "tests/stability/laws.h"
#include "tests/stability/random_scene.h"

namespace {

using photic::stability::Outcome;
using photic::stability::SceneModel;
using photic::stability::Violation;

constexpr unsigned kSceneSeconds = 120;
constexpr int kShrinkTries = 60;

struct Arguments {
    double seconds = 60;
    std::uint64_t seed = 1;
    std::int64_t scenes = -1;  ///< no more than these
    bool shrink = true;
    std::string keep = "out/stability";  ///< folder of the scenes that failed
};

int usage() {
    fmt::print(
        stderr,
        "photic_stability [--seconds 60] [--seed 1] [--scenes N] [--keep out/stability] [--no-shrink]\n"
        "Bakes random scenes, numbered from the seed on, and checks laws that hold for every scene. A scene that "
        "breaks one is made as simple as it can be and kept. Exit code: 0, or 1 where a law was broken.\n");
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
        const Outcome o = photic::stability::tryScene(other, kSceneSeconds);
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
        else if (word == "--keep")
            arguments.keep = value;
        else
            return usage();
    }

    const auto start = std::chrono::steady_clock::now();
    const auto elapsed = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    std::int64_t held = 0, refused = 0, failures = 0;
    std::map<std::string, int> broken, refusals;
    for (std::uint64_t seed = arguments.seed; elapsed() < arguments.seconds; ++seed) {
        if (arguments.scenes >= 0 && seed >= arguments.seed + static_cast<std::uint64_t>(arguments.scenes)) break;
        const SceneModel scene = photic::stability::randomScene(seed);
        const Outcome outcome = photic::stability::tryScene(scene, kSceneSeconds);
        held += outcome.kind == Outcome::Kind::Held, refused += outcome.kind == Outcome::Kind::Refused;
        if (outcome.kind == Outcome::Kind::Refused) ++refusals[kindOf(outcome.refusal)];
        if (outcome.kind != Outcome::Kind::Broken) continue;
        ++failures;
        for (const Violation& violation : outcome.violations) {
            ++broken[violation.law];
            report(scene, violation, arguments);
        }
    }
    fmt::print("{} scenes held every law, {} were refused, {} broke one or more\n", held, refused, failures);
    for (const auto& [law, count] : broken) fmt::print("  {}: {}\n", law, count);
    for (const auto& [words, count] : refusals) fmt::print("  refused {} times: {}\n", count, words);
    return failures > 0;
}
