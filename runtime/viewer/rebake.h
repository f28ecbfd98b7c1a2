// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bake/scene/moved_light.h"
#include "photic/runtime.h"
#include "runtime/viewer/bake_process.h"
#include "runtime/viewer/stage.h"

namespace photic::viewer {

/// A scene as it was baked, and its light.
struct Rebaked {
    runtime::Volume volume;
    Stage stage;                     ///< `level` is that of the volume
    std::vector<Light> lights;       ///< of the scene
    std::vector<std::string> files;  ///< that it names
    std::vector<std::string> warnings;
};

/// Bakes a scene whose lights were moved, beside what is going on: writes the scene with its lights elsewhere to a
/// temporary folder, runs `photic bake` on it, and loads the volume in a thread of its own. Nothing waits for any of
/// it. The folder and the process go with this object.
class Rebake {
public:
    enum class Phase {
        Idle,
        Baking,
        Loading,
        Failed  ///< failure() says why
    };

    /// @param program    path of `photic`
    /// @param scene      .toml
    /// @param arguments  more of `photic bake`
    /// @throws Error{Failed} without a place for temporary files
    Rebake(std::string program, std::string scene, std::vector<std::string> arguments);
    ~Rebake();
    Rebake(const Rebake&) = delete;
    Rebake& operator=(const Rebake&) = delete;

    /// Ends a bake that is under way, and begins another one of the file as it now is. What is wrong with it is in
    /// failure().
    void start(int frame, const std::vector<MovedLight>& moved);
    /// Ends what is under way.
    void stop();
    /// Listens, without waiting. @return the new light, once
    std::optional<Rebaked> poll();

    Phase phase() const { return phase_; }
    const Error& failure() const { return *failure_; }
    const BakeProcess* process() const { return process_.get(); }  ///< null unless Baking
    const std::filesystem::path& folder() const { return folder_; }

private:
    void fail(const Error& error);

    std::string program_, scene_;
    std::vector<std::string> arguments_;
    std::filesystem::path folder_;
    int count_ = 0;  ///< of bakes that were started
    Phase phase_ = Phase::Idle;
    std::optional<Error> failure_;
    std::filesystem::path moved_, baked_;  ///< the scene and the volume under way
    std::string text_;
    std::vector<std::string> warnings_;
    int frame_ = 1;
    std::unique_ptr<BakeProcess> process_;
    std::future<Rebaked> load_;
    std::vector<std::future<Rebaked>> unwanted_;  ///< loads that nobody waits for any more
};

}  // namespace photic::viewer
