// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>

#include "photic/gpu_upload.h"
#include "photic/runtime_gl.h"
#include "runtime/src/guarded.h"

namespace photic::runtime {

struct GpuSequence::Impl {
    Impl(const GpuContext& c, VolumeSequence s, const UploadOptions& o, std::uint64_t bytes)
        : context(c), sequence(std::move(s)), options(o), bytes_a_call(bytes) {}

    /// Has a frame on its way to the GPU, if it is not there.
    /// @throws Failure
    void request(int frame, const Volume& volume);
    /// Sends up to `bytes` of a frame, which may then be there. @return what is left of them. @throws Failure
    std::uint64_t send(int frame, std::uint64_t bytes);
    /// Sends the rest. @throws Failure
    void finish(int frame);

    GpuContext context;
    VolumeSequence sequence;
    UploadOptions options;
    std::uint64_t bytes_a_call;
    std::map<int, GpuVolume> uploaded;
    std::map<int, GpuUpload> coming;
    std::vector<std::pair<int, float>> shown;  ///< by the last call, and their shares
};

void GpuSequence::Impl::request(int frame, const Volume& volume) {
    if (uploaded.count(frame) != 0 || coming.count(frame) != 0) return;
    Result<GpuUpload> started = GpuUpload::start(context, volume, options);
    if (!started) throw Failure{started.error()};
    coming.emplace(frame, std::move(*started));
}

std::uint64_t GpuSequence::Impl::send(int frame, std::uint64_t bytes) {
    const auto upload = coming.find(frame);
    if (upload == coming.end() || bytes == 0) return bytes;
    if (upload->second.step(bytes)) finish(frame);
    return 0;  // whole layers go at a time: one frame a call
}

void GpuSequence::Impl::finish(int frame) {
    const auto upload = coming.find(frame);
    if (upload == coming.end()) return;
    Result<GpuVolume> volume = upload->second.take();
    coming.erase(upload);
    if (!volume) throw Failure{volume.error()};
    uploaded.emplace(frame, std::move(*volume));
}

GpuSequence::GpuSequence(const GpuContext& context, VolumeSequence sequence, const UploadOptions& options,
                         std::uint64_t bytes_a_call)
    : impl_(std::make_unique<Impl>(context, std::move(sequence), options, bytes_a_call)) {}
GpuSequence::GpuSequence(GpuSequence&&) noexcept = default;
GpuSequence& GpuSequence::operator=(GpuSequence&&) noexcept = default;
GpuSequence::~GpuSequence() = default;

void GpuSequence::abandon() {
    for (auto& [frame, volume] : impl_->uploaded) volume.abandon();
    for (auto& [frame, upload] : impl_->coming) upload.abandon();
    impl_->uploaded.clear();
    impl_->coming.clear();
}

Result<std::vector<LitVolume>> GpuSequence::at(double seconds, WhenLate when_late) {
    return guarded([&]() -> Result<std::vector<LitVolume>> {
        Impl& impl = *impl_;
        const Result<Moment> moment = impl.sequence.at(seconds, when_late);
        if (!moment) return moment.error();
        const bool loaded = !moment->late || moment->volumes[0].litVoxelCount() > 0;  // or nothing has come yet
        const int first = moment->frames[0], second = moment->frames[1];

        // What is neither shown, nor on its way to be, makes room.
        const auto kept = [&](int frame) {
            return (loaded && (frame == first || frame == second)) || frame == moment->next;
        };
        std::erase_if(impl.coming, [&](const auto& entry) { return !kept(entry.first); });
        std::uint64_t bytes = impl.bytes_a_call;
        for (int n = 0; loaded && n < 2; ++n) {
            impl.request(moment->frames[n], moment->volumes[n]);
            if (when_late == WhenLate::Wait) impl.finish(moment->frames[n]);
            bytes = impl.send(moment->frames[n], bytes);
        }
        if (moment->next >= 0) {
            impl.request(moment->next, moment->next_volume);
            impl.send(moment->next, bytes);
        }

        const auto there = [&](int frame) { return impl.uploaded.count(frame) != 0; };
        if (loaded && (there(first) || there(second))) {
            const auto weight = static_cast<float>(moment->weight);
            if (there(first) && there(second) && first != second)
                impl.shown = {{first, 1 - weight}, {second, weight}};
            else
                impl.shown = {{there(first) ? first : second, 1.0F}};
        }
        std::erase_if(impl.uploaded, [&](const auto& entry) {
            return !kept(entry.first) && std::none_of(impl.shown.begin(), impl.shown.end(),
                                                      [&](const auto& shown) { return shown.first == entry.first; });
        });
        std::vector<LitVolume> lit;
        for (const auto& [frame, share] : impl.shown) {
            const auto volume = impl.uploaded.find(frame);
            if (volume != impl.uploaded.end()) lit.push_back({&volume->second, share});
        }
        return lit;
    });
}

}  // namespace photic::runtime
