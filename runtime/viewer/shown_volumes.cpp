// SPDX-License-Identifier: Apache-2.0
#include "runtime/viewer/shown_volumes.h"

#include <utility>

namespace photic::viewer {

using runtime::Done;
using runtime::Status;

Status ShownVolumes::set(const runtime::GpuContext& context, int index, const runtime::Volume& volume) {
    coming_.reset();
    auto uploaded = runtime::GpuVolume::upload(context, volume);
    if (!uploaded) return uploaded.error();
    volumes_[static_cast<std::size_t>(index)].emplace(std::move(uploaded).value());
    return Done{};
}

Status ShownVolumes::send(const runtime::GpuContext& context, int index, const runtime::Volume& volume) {
    auto sent = runtime::GpuUpload::start(context, volume);
    if (!sent) return sent.error();
    coming_.emplace(std::move(sent).value());
    coming_index_ = static_cast<std::size_t>(index);
    return Done{};
}

runtime::Result<bool> ShownVolumes::bring() {
    if (!coming_) return true;
    if (!coming_->step()) return false;
    auto uploaded = coming_->take();
    coming_.reset();
    if (!uploaded) return uploaded.error();
    volumes_[coming_index_].emplace(std::move(uploaded).value());
    return true;
}

}  // namespace photic::viewer
