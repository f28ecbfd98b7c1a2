// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "photic/gpu_upload.h"

namespace photic::viewer {

/// The two volumes that a picture may show, and one that is on its way to stand in for either.
class ShownVolumes {
public:
    runtime::Status set(const runtime::GpuContext& context, int index, const runtime::Volume& volume);
    /// Sent a few megabytes at each bring(); one that was on its way is forgotten.
    runtime::Status send(const runtime::GpuContext& context, int index, const runtime::Volume& volume);
    /// @return true once it is there, or where none is on its way
    runtime::Result<bool> bring();
    /// Null where there is none.
    runtime::GpuVolume* at(int index) {
        auto& volume = volumes_[static_cast<std::size_t>(index)];
        return volume ? &*volume : nullptr;
    }
    bool has(int index) const { return volumes_[static_cast<std::size_t>(index)].has_value(); }

private:
    std::array<std::optional<runtime::GpuVolume>, 2> volumes_;
    std::optional<runtime::GpuUpload> coming_;
    std::size_t coming_index_ = 0;
};

}  // namespace photic::viewer
