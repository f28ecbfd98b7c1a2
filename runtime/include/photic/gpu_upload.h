// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "photic/runtime_gl.h"

/// A volume that goes to the GPU a few megabytes a frame, so that no frame waits for it:
///
///     auto coming = photic::runtime::GpuUpload::start(*gpu, volume);
///     ...each frame: if (coming && coming->step()) { light = coming->take(); coming.reset(); }
namespace photic::runtime {

class GpuUpload {
public:
    /// Starts a thread that lays the texels out as GpuVolume::upload() would. What does not fit is what take() returns.
    /// @return Error{Memory} when the system has no thread left
    static Result<GpuUpload> start(const GpuContext& context, Volume volume, const UploadOptions& options = {});
    GpuUpload(GpuUpload&&) noexcept;
    GpuUpload& operator=(GpuUpload&&) noexcept;
    ~GpuUpload();  ///< waits for the thread

    /// Sends the next texels, or none while they are being laid out; waits for nothing.
    /// @param bytes  about as many at most: whole layers of texels, and at least one
    /// @return whether all is there, or has failed: take() will not wait
    bool step(std::uint64_t bytes = std::uint64_t{4} << 20);

    /// The volume, its rest sent at once if need be; or the error of GpuVolume::upload(). Only once.
    Result<GpuVolume> take();

    /// The context is lost: forgets all GL names without deleting them.
    void abandon();

private:
    struct Impl;
    explicit GpuUpload(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace photic::runtime
