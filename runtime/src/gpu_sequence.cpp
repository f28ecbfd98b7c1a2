// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>

#include "photic/runtime_gl.h"
#include "runtime/src/guarded.h"

namespace photic::runtime {

struct GpuSequence::Impl {
    Impl(const GpuContext& c, VolumeSequence s, const UploadOptions& o)
        : context(c), sequence(std::move(s)), options(o) {}
    GpuContext context;
    VolumeSequence sequence;
    UploadOptions options;
    std::map<int, GpuVolume> uploaded;
};

GpuSequence::GpuSequence(const GpuContext& context, VolumeSequence sequence, const UploadOptions& options)
    : impl_(std::make_unique<Impl>(context, std::move(sequence), options)) {}
GpuSequence::GpuSequence(GpuSequence&&) noexcept = default;
GpuSequence& GpuSequence::operator=(GpuSequence&&) noexcept = default;
GpuSequence::~GpuSequence() = default;

void GpuSequence::abandon() {
    for (auto& [frame, volume] : impl_->uploaded) volume.abandon();
    impl_->uploaded.clear();
}

Result<std::vector<LitVolume>> GpuSequence::at(double seconds, WhenLate when_late) {
    return guarded([&]() -> Result<std::vector<LitVolume>> {
        const Result<Moment> moment = impl_->sequence.at(seconds, when_late);
        if (!moment) return moment.error();
        auto& uploaded = impl_->uploaded;
        std::erase_if(uploaded, [&](const auto& entry) {
            return entry.first != moment->frames[0] && entry.first != moment->frames[1];
        });
        std::vector<LitVolume> lit;
        for (int n = 0; n < 2; ++n) {
            const int frame = moment->frames[n];
            const double share = n == 0 ? 1 - moment->weight : moment->weight;
            if (moment->late && moment->volumes[n].litVoxelCount() == 0) continue;  // nothing has been loaded yet
            if (n == 1 && frame == moment->frames[0]) {
                lit.front().weight = 1;
                continue;
            }
            auto known = uploaded.find(frame);
            if (known == uploaded.end()) {
                Result<GpuVolume> volume = GpuVolume::upload(impl_->context, moment->volumes[n], impl_->options);
                if (!volume) return volume.error();
                known = uploaded.emplace(frame, std::move(*volume)).first;
            }
            lit.push_back({&known->second, static_cast<float>(share)});
        }
        return lit;
    });
}

}  // namespace photic::runtime
