// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <mutex>
#include <string>
#include <string_view>

#include "bake/deposit/voxelise.h"
#include "bake/methods/beams.h"
#include "bake/paths/optical_scene.h"
#include "bake/tubes/histories.h"

namespace photic {

/// Whether and how the sun's disc is shown for a light.
BeamsDisc discFor(const Scene& scene, const Light& light, const GridFrame& frame, const BeamsOptions& options);

/// How many directions on its disc stand for a light: 1 unless its disc is sampled.
int discDirections(const OpticalScene& optics, const Light& light, const BeamsOptions& options);

/// How surfaces are cut, and how far light is followed, as a scene and its options ask for.
LaunchOptions launchOptions(const Scene& scene, const BeamsOptions& options);
FollowLimits followLimits(const Scene& scene);

/// How tubes are laid.
VoxeliseOptions voxeliseOptions(const Scene& scene, const BeamsOptions& options);

/// What a bake by beams takes: rays and tubes by how much the surface bends, deposits by the voxels.
MethodCost beamsCost(const CostQuestion& question, const BeamsOptions& options);

/// Makes one stage, "light", of launches that trace and deposit in turns: every launch is traced batch by batch, and
/// tubes are laid once there are enough of them. Whichever takes longer, each is counted as half of the work.
class BeamsProgress final : public Monitor {
public:
    /// @param runs  how often all lights are baked
    BeamsProgress(Monitor& to, int runs) : to_(to), runs_(runs) {}
    /// @param launches  how often a surface is going to be launched from
    void beginRun(int launches) {
        const std::lock_guard lock(mutex_);
        ++run_, launches_ = std::max(1, launches), launch_ = 0, traced_ = laid_ = 0, all_laid_ = false;
    }
    void nextLaunch() {
        const std::lock_guard lock(mutex_);
        ++launch_;
    }

    void progress(std::string_view stage, double fraction) override {
        const std::lock_guard lock(mutex_);
        if (stage == "trace") {
            if (all_laid_) laid_ = traced_;
            all_laid_ = false;
            traced_ = std::max(traced_, launch_ + fraction);
            tell(laid_);
        } else {
            // Launches that ended are traced whole, though only their batches' beginnings were told.
            traced_ = std::max(traced_, static_cast<double>(launch_));
            all_laid_ = true;
            tell(laid_ + (traced_ - laid_) * fraction);
        }
    }
    void warn(const std::string& message) override { to_.warn(message); }
    bool cancelled() const override { return to_.cancelled(); }

private:
    void tell(double laid) {
        // Each history of a launch begins anew; a bar does not go back.
        const double done = (run_ + 0.5 * (traced_ + laid) / launches_) / runs_;
        told_ = std::clamp(done, told_, 1.0);
        to_.progress("light", told_);
    }

    Monitor& to_;
    std::mutex mutex_;
    int runs_, run_ = -1, launches_ = 1, launch_ = 0;
    double traced_ = 0, laid_ = 0;  // launches
    bool all_laid_ = false;         // that are traced
    double told_ = 0;
};

}  // namespace photic
