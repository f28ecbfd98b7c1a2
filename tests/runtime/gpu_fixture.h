// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "photic/runtime_gl.h"
#include "tests/runtime/compute_sampler.h"
#include "tests/runtime/gl_fixture.h"
#include "tests/runtime/nvdb_files.h"

namespace photic::test {

/// A volume read back from a made-up file; fails the test when it does not load.
runtime::Volume makeVolume(const NvdbSpec& spec);

/// A test with a GpuContext.
class WithGpu : public WithGl {
protected:
    void SetUp() override {
        WithGl::SetUp();
        if (!IsSkipped()) makeContext();
    }
    void makeContext() {
        auto made = runtime::GpuContext::create(context_->loader());
        ASSERT_TRUE(made.ok()) << made.error().message;
        gpu_ = std::make_unique<runtime::GpuContext>(*made);
    }

    runtime::GpuVolume upload(const runtime::Volume& volume, const runtime::UploadOptions& options);

    /// Samples on the GPU, in a shader made of volumeGlsl().
    std::vector<GpuSample> sample(runtime::GpuVolume& volume, const std::vector<std::array<float, 4>>& positions,
                                  const runtime::GlslOptions& options = {});

    /// How far the hardware's filter weights are from what they should be: GPUs round them, many to 1/256. Measured
    /// along one axis between a 0 and a 1.
    double filterError();
    /// What filtered look-ups may be off by, of the largest value: 1e-3, and what rounded weights make of values
    /// between minus and plus the largest one along three axes.
    double filterLimit() { return 1e-3 + 6 * filterError(); }

    std::unique_ptr<runtime::GpuContext> gpu_;
};

}  // namespace photic::test
