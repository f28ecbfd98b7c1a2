// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "photic/bent_rays.h"
#include "photic/gpu_upload.h"
#include "photic/live_bake.h"
#include "tests/runtime/gpu_fixture.h"
#include "tests/runtime/scene_view.h"
#include "tests/runtime/wrapped_gl.h"

namespace photic::test {

/// A public call of the GPU half, with all that it needs made before it and deleted after it.
struct Call {
    std::string name;
    /// @param view  drawn to by what draws
    std::function<runtime::Status(const runtime::GpuContext& gpu, const DrawnView& view)> run;
};

/// What the calls work on: it needs no GL.
class CallInputs {
public:
    CallInputs();
    ~CallInputs();
    CallInputs(const CallInputs&) = delete;
    CallInputs& operator=(const CallInputs&) = delete;

    /// All public calls that make, fill or draw something on the GPU, but bind(), whose state stays.
    std::vector<Call> everyCall() const;

    Drawing drawing;                            ///< what the camera sees
    runtime::Volume volume, coloured;           ///< light
    std::vector<float> heights;                 ///< of water
    runtime::WaterHeights water;                ///< points to them
    runtime::WaterLight light;                  ///< over it
    runtime::Movers movers;                     ///< in the light
    std::vector<runtime::IndexVolume> objects;  ///< to be seen through
    std::vector<std::string> frames;            ///< files of a sequence
    std::vector<float> clip_from_world;         ///< of `drawing`
};

/// A test of all of them.
class EveryCall : public WithGpu {
protected:
    static void SetUpTestSuite() { inputs_ = std::make_unique<CallInputs>(); }
    static void TearDownTestSuite() { inputs_.reset(); }

    /// What a call draws, in a context.
    std::vector<float> drawn(const Call& call, const runtime::GpuContext& gpu) {
        const DrawnView view(gl_, inputs_->drawing);
        view.fill(0.25F, 0.5F, 0.75F);
        const runtime::Status done = call.run(gpu, view);
        EXPECT_TRUE(done.ok()) << call.name << ": " << (done.ok() ? "" : done.error().message);
        return view.pixels();
    }

    runtime::GpuContext contextOf(WrappedGl& wrapped) {
        auto made = runtime::GpuContext::create(wrapped.loader());
        EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
        return made ? *made : *gpu_;
    }

    static inline std::unique_ptr<CallInputs> inputs_;
};

}  // namespace photic::test
