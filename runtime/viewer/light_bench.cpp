// SPDX-License-Identifier: Apache-2.0
#include "runtime/viewer/light_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <glm/geometric.hpp>
#include <sstream>
#include <thread>

#include "bake/report/error_text.h"

namespace photic::viewer {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kRest{300};  // of a light, before it is baked
constexpr std::chrono::milliseconds kLook{250};  // between looks at the scene's files

std::vector<std::string> wordsOf(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    return words;
}

bool hasDirection(const Light& light) { return light.type != LightType::Point; }

/// The light that the options mean.
std::size_t chooseLight(const Options& options, const std::vector<Light>& lights) {
    std::optional<std::size_t> best;
    for (std::size_t n = 0; n < lights.size(); ++n) {
        const Light& light = lights[n];
        if (!options.light.empty()) {
            if (light.name == options.light) return n;
            continue;
        }
        if ((options.light_position && !light.position) || (options.light_direction && !hasDirection(light))) continue;
        if (!best || glm::length(light.irradiance) > glm::length(lights[*best].irradiance)) best = n;
    }
    if (best) return *best;
    if (options.light.empty() && !options.light_position && !options.light_direction) return 0;
    std::string names;
    for (const Light& light : lights) names += (names.empty() ? "'" : ", '") + light.name + "'";
    throw Error(ErrorCode::Usage,
                options.light.empty() ? "the scene has no light that can be moved so; it has " + names
                                      : fmt::format("there is no light '{}'; the scene has {}", options.light, names),
                "--light");
}

}  // namespace

std::string photicBesideThis() {
    std::error_code failure;
    return (fs::read_symlink("/proc/self/exe", failure).parent_path() / "photic").string();
}

LightBench::LightBench(const Options& options, Show& show, Renderer& renderer, const std::string& program)
    : options_(options),
      show_(show),
      renderer_(renderer),
      rebake_(program, options.scene, wordsOf(options.bake_arguments)) {
    takeLights();
    chosen_ = chooseLight(options, lights_);
    if (options.light_position || options.light_direction) {
        const Light& light = lights_[chosen_];
        moveTo(options.light_position ? glm::dvec3(*options.light_position) : light.position.value_or(glm::dvec3(0)),
               options.light_direction ? glm::dvec3(*options.light_direction) : light.direction);
    }
    if (options.bake) bake();
}

/// Those of the scene's file, of the frame that is shown.
void LightBench::takeLights() {
    lights_ = show_.lights();
    chosen_ = std::min(chosen_, lights_.empty() ? 0 : lights_.size() - 1);
    frame_ = show_.frame();
    moved_.clear();
    look();
}

void LightBench::moveTo(const glm::dvec3& position, const glm::dvec3& direction) {
    if (chosen_ >= lights_.size() || !(glm::length(direction) > 0)) return;
    Light& light = lights_[chosen_];
    auto moved = std::find_if(moved_.begin(), moved_.end(), [&](const MovedLight& m) { return m.number == chosen_; });
    if (moved == moved_.end()) moved = moved_.insert(moved_.end(), {chosen_});
    if (light.position) moved->position = light.position = position;
    if (hasDirection(light)) {
        moved->direction = direction;
        light.direction = glm::normalize(direction);
    }
    const auto brighter = [](const Light& a, const Light& b) {
        return glm::length(a.irradiance) < glm::length(b.irradiance);
    };
    const bool is_brightest = &*std::max_element(lights_.begin(), lights_.end(), brighter) == &light;
    if (light.type == LightType::Sun && is_brightest) show_.setSun(glm::vec3(light.direction));
    rebake_.stop();
    wished_ = Clock::now() + kRest;
}

void LightBench::bake() { wished_ = Clock::now(); }

void LightBench::look() {
    seen_.clear();
    looked_ = Clock::now();
    for (const std::string& path : show_.files()) {
        std::error_code gone;
        seen_.push_back({path, fs::last_write_time(path, gone)});
    }
}

bool LightBench::filesChanged() {
    if (!options_.watch || Clock::now() < looked_ + kLook) return false;
    looked_ = Clock::now();
    bool changed = false;
    for (Seen& file : seen_) {
        std::error_code gone;
        const auto time = fs::last_write_time(file.path, gone);
        // An editor may have taken the file away for a moment to put another one in its place.
        if (gone || time == file.time) continue;
        file.time = time;
        changed = true;
    }
    return changed;
}

void LightBench::update() {
    if (show_.frame() != frame_) {
        takeLights();
        rebake_.stop();
        wished_.reset(), coming_.reset();
    }
    if (filesChanged()) {
        moved_.clear();  // the file's lights are those of now
        rebake_.stop();
        wished_ = Clock::now() + kRest;
    }
    if (wished_ && Clock::now() >= *wished_) {
        wished_.reset();
        rebake_.start(frame_, moved_);
    }
    if (auto baked = rebake_.poll()) {
        for (const std::string& warning : baked->warnings)
            std::fprintf(stderr, "photic view: the bake: %s\n", warning.c_str());
        const auto sent = renderer_.sendVolume(0, baked->volume);
        if (!sent) throwFailure("volume", sent.error().message);
        coming_ = std::move(*baked);
    }
    if (!coming_) return;
    const auto brought = renderer_.bringVolume();
    if (!brought) throwFailure("volume", brought.error().message);
    if (!*brought) return;
    show_.setBaked(std::move(*coming_));
    coming_.reset();
    const std::vector<Light> as_they_are = lights_;
    lights_ = show_.lights();
    // A light that was moved on meanwhile stays where it is.
    if (wished_ && as_they_are.size() == lights_.size()) {
        lights_ = as_they_are;
    } else {
        look();
    }
}

void LightBench::finish(const std::function<bool()>& stop) {
    while (busy()) {
        if (stop()) throw Error(ErrorCode::Cancelled, "cancelled");
        update();
        if (rebake_.phase() == Rebake::Phase::Failed) throw rebake_.failure();
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

std::string LightBench::words() const {
    switch (rebake_.phase()) {
        case Rebake::Phase::Baking: {
            const BakeProcess& process = *rebake_.process();
            return process.secondsLeft() < 0
                       ? fmt::format("baking: {}", process.stage())
                       : fmt::format("baking: {}, {:.0f} s left", process.stage(), process.secondsLeft());
        }
        case Rebake::Phase::Loading:
            return "loading the bake";
        case Rebake::Phase::Failed:
            return errorText(rebake_.failure());
        case Rebake::Phase::Idle:
            break;
    }
    return wished_ ? "the light is moved" : coming_ ? "to the GPU" : "";
}

double LightBench::done() const {
    return rebake_.phase() == Rebake::Phase::Baking ? rebake_.process()->done() : coming_ ? 1 : 0;
}

}  // namespace photic::viewer
