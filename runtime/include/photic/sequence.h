// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "photic/runtime.h"

/// Light that moves: frames that are loaded by a thread of their own while others are shown.
namespace photic::runtime {

enum class SequenceEnd {
    Loop,  ///< after the last frame comes the first
    Hold   ///< the last frame stays
};
enum class WhenLate {
    ShowNearest,  ///< of the frames that are there the one nearest in time: never waits
    Wait
};

struct SequenceOptions {
    double frames_per_second = 24;
    SequenceEnd end = SequenceEnd::Loop;
    int ahead = 1;  ///< frames loaded beyond the two that are shown; each takes its memory
    LoadOptions load;
};

/// What is shown at one time: two frames and how much of the second.
struct Moment {
    int frames[2] = {0, 0};  ///< by number in the list of paths
    Volume volumes[2];       ///< dark while nothing has been loaded at all
    double weight = 0;       ///< 0 to 1, of the second; light is (1 - weight) * first + weight * second
    int next = -1;       ///< the frame after these, once it is loaded: what is prepared meanwhile; -1: there is none
    Volume next_volume;  ///< of it
    bool late = false;   ///< the frames of this time are not loaded yet: the nearest one stands in
    /// Of a frame of this time that is missing or damaged: the frames before and after it stand in.
    std::optional<Error> failure;
};

class VolumeSequence {
public:
    /// Starts the thread; loads nothing yet. @return Error{Usage} without paths or for a rate that is not above 0
    static Result<VolumeSequence> open(std::vector<std::string> paths, const SequenceOptions& options = {});
    VolumeSequence(VolumeSequence&&) noexcept;
    VolumeSequence& operator=(VolumeSequence&&) noexcept;
    ~VolumeSequence();  ///< waits for a load that is under way

    /// Frames at a time, which also has the next ones loaded. One thread at a time may ask. Where loading takes longer
    /// than a frame lasts, frames are left out and the nearest one that is there is shown; the last one that was shown
    /// is kept until a nearer one has come. A frame that does not load is not tried again.
    /// @param seconds  from the first frame on; before it is the last frame's time when looped
    /// @return the error of the first frame when none of them loads
    Result<Moment> at(double seconds, WhenLate when_late = WhenLate::ShowNearest);

    int frameCount() const;

    struct Impl;

private:
    explicit VolumeSequence(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace photic::runtime
