// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "runtime/viewer/options.h"
#include "runtime/viewer/rebake.h"
#include "runtime/viewer/renderer.h"

namespace photic::viewer {

/// Scene and volumes of a frame, loaded and handed to a renderer, and the picture that the options ask for at first.
class Show {
public:
    /// @throws Error{Input} for files that cannot be read, Error{Failed} for what the GPU refuses
    Show(const Options& options, Renderer& renderer);

    /// Loads what depends on the frame. @throws as the constructor
    void setFrame(int frame);
    int frame() const { return frame_; }

    const Stage& stage() const { return stage_; }
    /// Of the scene, as they are in its file; none without one.
    const std::vector<Light>& lights() const { return lights_; }
    /// Files that the scene names, and its own.
    const std::vector<std::string>& files() const { return files_; }
    Picture picture;

    /// Shines another sun on the stage, for what is not baked.
    void setSun(const glm::vec3& direction);
    /// Shows a scene that was baked anew; its volume is the renderer's already.
    void setBaked(Rebaked baked);

private:
    void firstPicture();
    const Options& options_;
    Renderer& renderer_;
    Stage stage_;
    std::vector<Light> lights_;
    std::vector<std::string> files_;
    int frame_ = -1;
    float level_ = 1;  ///< Stage::level of the first frame: what is played does not flicker
};

/// Draws without a screen and writes `options.screenshot`. @throws Error
void takeScreenshot(const Options& options);

/// Opens a window until it is closed. @throws Error{Failed} without a screen
void openWindow(const Options& options);

/// Makes SIGINT and SIGTERM ask for an end, so that what is under way is put away.
void watchSignals();
bool stopWanted();

/// A failure of the runtime as the program's.
[[noreturn]] void throwFailure(const std::string& where, const std::string& message);

}  // namespace photic::viewer
