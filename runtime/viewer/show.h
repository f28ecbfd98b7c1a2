// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "runtime/viewer/options.h"
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
    Picture picture;

private:
    void firstPicture();
    const Options& options_;
    Renderer& renderer_;
    Stage stage_;
    int frame_ = -1;
    float level_ = 1;  ///< Stage::level of the first frame: what is played does not flicker
};

/// Draws without a screen and writes `options.screenshot`. @throws Error
void takeScreenshot(const Options& options);

/// Opens a window until it is closed. @throws Error{Failed} without a screen
void openWindow(const Options& options);

/// A failure of the runtime as the program's.
[[noreturn]] void throwFailure(const std::string& where, const std::string& message);

}  // namespace photic::viewer
