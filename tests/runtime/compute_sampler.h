// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "photic/runtime_gl.h"
#include "runtime/src/gl_functions.h"

namespace photic::test {

/// World positions; the fourth component is not used.
using Positions = std::vector<std::array<float, 4>>;

/// In and a little around a volume: at random, or along lines as pixels of a picture are.
Positions randomPositions(const runtime::Volume& volume, std::size_t count, unsigned seed);
Positions coherentPositions(const runtime::Volume& volume, std::size_t count);

/// What photicSample() gives: flux.xyz, mean; irradiance, length of the dark ahead along +x.
using GpuSample = std::array<float, 8>;
enum class SampleRead { Light, LightAndDark };

/// Samples a volume at many positions in a compute shader made of volumeGlsl().
class ComputeSampler {
public:
    /// For volumes of this one's layout.
    static runtime::Result<std::unique_ptr<ComputeSampler>> make(const runtime::GlFunctions& gl,
                                                                 const Positions& positions,
                                                                 const runtime::GpuVolume& volume,
                                                                 runtime::GlslOptions options = {},
                                                                 SampleRead read = SampleRead::LightAndDark);
    ~ComputeSampler();
    ComputeSampler(const ComputeSampler&) = delete;
    ComputeSampler& operator=(const ComputeSampler&) = delete;

    /// Dispatches; does not wait.
    void run(runtime::GpuVolume& volume);
    std::vector<GpuSample> samples() const;

private:
    ComputeSampler(const runtime::GlFunctions& gl, runtime::GlslOptions options, std::size_t count)
        : gl_(gl), options_(std::move(options)), count_(count) {}

    const runtime::GlFunctions& gl_;
    runtime::GlslOptions options_;
    std::size_t count_;
    GLuint program_ = 0, in_ = 0, out_ = 0;
};

}  // namespace photic::test
