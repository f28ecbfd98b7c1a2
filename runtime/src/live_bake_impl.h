// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "photic/live_bake.h"
#include "runtime/src/gpu_volume_impl.h"
#include "runtime/src/live_water_impl.h"

namespace photic::runtime {

/// What a LiveBake holds.
struct LiveBake::Impl {
    Impl(const GpuContext& of, const LiveBakeOptions& o) : context(of), options(o) {}
    ~Impl();
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    const GlFunctions& gl() const { return context.gl(); }
    float voxel(std::size_t axis) const {
        return (options.max[axis] - options.min[axis]) / static_cast<float>(options.voxels[axis]);
    }
    std::uint64_t sumCount(bool colour) const {
        return (colour ? std::uint64_t{7} : std::uint64_t{4}) *
               static_cast<std::uint64_t>(options.voxels[0] + 2 * pad) *
               static_cast<std::uint64_t>(options.voxels[1] + 2 * pad) * static_cast<std::uint64_t>(options.voxels[2]);
    }

    void prepare(const LiveWater::Impl& water);
    void setKernel(const WaterLight& light, float level);
    void makeVolume();
    void dispatch(const LiveWater::Impl& water);
    void setGrid(const Uniforms& uniforms, bool repeats) const {
        uniforms.set("photic_live_cells", options.voxels[0], options.voxels[1], options.voxels[2], repeats ? 1 : 0);
        uniforms.set("photic_live_pad", pad);
    }
    GLuint programOf(GLuint (&programs)[2], const char* file);

    GpuContext context;
    LiveBakeOptions options;
    std::unique_ptr<GpuVolume> volume;
    GLuint sums = 0, kernel = 0;                             ///< storage buffers
    GLuint clear[2] = {}, deposit[2] = {}, resolve[2] = {};  ///< programs: white, in colour
    int pad = 0;                                             ///< voxels that the blur reaches
    bool coloured = false, periodic = false;
    std::uint64_t sums_bytes = 0;
    // What the kernel was made for.
    float kernel_light[4] = {0, 0, 0, 0}, kernel_level = 0;
};

}  // namespace photic::runtime
