// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "runtime/viewer/rebake.h"
#include "runtime/viewer/show.h"

namespace photic::viewer {

/// The lights of the scene that is shown, to be moved, and the bake that follows them: what is moved is shown at once
/// by what needs no bake, and baked as soon as it rests.
class LightBench {
public:
    /// @param program  path of `photic`
    /// @throws Error{Usage} for a light that `options` names and the scene does not have
    LightBench(const Options& options, Show& show, Renderer& renderer, const std::string& program);

    /// Where they are now.
    const std::vector<Light>& lights() const { return lights_; }
    std::size_t chosen() const { return chosen_; }  ///< the one that is moved
    void choose(std::size_t number) { chosen_ = number; }

    /// Moves the chosen light; what it does not have is ignored.
    void moveTo(const glm::dvec3& position, const glm::dvec3& direction);
    /// Bakes now, without waiting for the light to rest.
    void bake();

    /// Once a frame: listens to the bake and to the scene's files, and swaps new light in. Never waits.
    void update();
    /// Until nothing is under way. @param stop  asked for again and again. @throws the bake's error; Error{Cancelled}
    void finish(const std::function<bool()>& stop);

    bool busy() const { return wished_ || rebake_.phase() != Rebake::Phase::Idle || coming_; }
    const Rebake& rebake() const { return rebake_; }
    std::string words() const;  ///< what is under way, or why the last bake failed; empty otherwise
    double done() const;        ///< of the bake, 0 to 1

private:
    using Clock = std::chrono::steady_clock;
    struct Seen {
        std::string path;
        std::filesystem::file_time_type time{};
    };
    void look();
    bool filesChanged();
    void takeLights();

    const Options& options_;
    Show& show_;
    Renderer& renderer_;
    Rebake rebake_;
    std::vector<Light> lights_;
    std::vector<MovedLight> moved_;
    std::size_t chosen_ = 0;
    int frame_ = 0;
    std::optional<Clock::time_point> wished_;  ///< when a bake is to begin
    std::optional<Rebaked> coming_;            ///< whose volume goes to the GPU
    std::vector<Seen> seen_;
    Clock::time_point looked_{};
};

/// Path of `photic`, beside this program.
std::string photicBesideThis();

}  // namespace photic::viewer
