// SPDX-License-Identifier: Apache-2.0
#include "photic/sequence.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include "runtime/src/guarded.h"

namespace photic::runtime {

struct VolumeSequence::Impl {
    Impl(std::vector<std::string> files, const SequenceOptions& with) : paths(std::move(files)), options(with) {}
    ~Impl();
    void run();
    int followerOf(int frame) const;

    const std::vector<std::string> paths;
    const SequenceOptions options;

    std::mutex mutex;
    std::condition_variable wanted_changed, loaded_changed;
    // Guarded by the mutex.
    std::vector<int> wanted;  ///< most urgent first
    std::map<int, Result<Volume>> loaded;
    bool stopping = false;

    std::optional<Moment> last;  ///< only the asking thread's
    std::thread thread;          ///< last: it uses all of the above
};

VolumeSequence::Impl::~Impl() {
    {
        const std::lock_guard lock(mutex);
        stopping = true;
    }
    wanted_changed.notify_all();
    if (thread.joinable()) thread.join();
}

int VolumeSequence::Impl::followerOf(int frame) const {
    const int count = static_cast<int>(paths.size());
    return options.end == SequenceEnd::Loop ? (frame + 1) % count : std::min(frame + 1, count - 1);
}

void VolumeSequence::Impl::run() {
    std::unique_lock lock(mutex);
    while (true) {
        const auto missing = [&] {
            return std::find_if(wanted.begin(), wanted.end(), [&](int frame) { return loaded.count(frame) == 0; });
        };
        wanted_changed.wait(lock, [&] { return stopping || missing() != wanted.end(); });
        if (stopping) return;
        const int frame = *missing();
        // What is no longer wanted makes room first.
        std::erase_if(loaded, [&](const auto& entry) {
            return std::find(wanted.begin(), wanted.end(), entry.first) == wanted.end();
        });
        lock.unlock();
        Result<Volume> volume = loadVolume(paths[static_cast<std::size_t>(frame)], options.load);
        lock.lock();
        loaded.emplace(frame, std::move(volume));
        loaded_changed.notify_all();
    }
}

VolumeSequence::VolumeSequence(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VolumeSequence::VolumeSequence(VolumeSequence&&) noexcept = default;
VolumeSequence& VolumeSequence::operator=(VolumeSequence&&) noexcept = default;
VolumeSequence::~VolumeSequence() = default;

int VolumeSequence::frameCount() const { return static_cast<int>(impl_->paths.size()); }

Result<VolumeSequence> VolumeSequence::open(std::vector<std::string> paths, const SequenceOptions& options) {
    return guarded([&]() -> Result<VolumeSequence> {
        if (paths.empty()) fail(ErrorCode::Usage, "a sequence needs at least one file");
        if (!(options.frames_per_second > 0 && std::isfinite(options.frames_per_second)) || options.ahead < 0) {
            fail(ErrorCode::Usage, std::to_string(options.frames_per_second) + " frames a second, " +
                                       std::to_string(options.ahead) +
                                       " ahead: the first must be above 0, the other not below");
        }
        auto impl = std::make_unique<Impl>(std::move(paths), options);
        impl->thread = std::thread([p = impl.get()] { p->run(); });
        return VolumeSequence(std::move(impl));
    });
}

Result<Moment> VolumeSequence::at(double seconds, WhenLate when_late) {
    return guarded([&]() -> Result<Moment> {
        Impl& impl = *impl_;
        if (!std::isfinite(seconds)) fail(ErrorCode::Usage, "the time is not finite");
        const auto count = static_cast<double>(impl.paths.size());
        double position = seconds * impl.options.frames_per_second;
        if (impl.options.end == SequenceEnd::Loop) {
            position -= count * std::floor(position / count);
        } else {
            position = std::clamp(position, 0.0, count - 1);
        }
        Moment moment;
        // Rounding may have made it the count itself.
        moment.frames[0] = std::min(static_cast<int>(position), static_cast<int>(impl.paths.size()) - 1);
        moment.frames[1] = impl.followerOf(moment.frames[0]);
        moment.weight = std::clamp(position - moment.frames[0], 0.0, 1.0);

        std::unique_lock lock(impl.mutex);
        impl.wanted.assign(moment.frames, moment.frames + 2);
        for (int n = 0, frame = moment.frames[1]; n < impl.options.ahead; ++n) {
            impl.wanted.push_back(frame = impl.followerOf(frame));
        }
        impl.wanted_changed.notify_all();
        const auto ready = [&] { return impl.loaded.count(moment.frames[0]) && impl.loaded.count(moment.frames[1]); };
        if (when_late == WhenLate::Wait) impl.loaded_changed.wait(lock, ready);
        if (!ready()) {
            if (impl.last) moment = *impl.last;
            moment.late = true;
            return moment;
        }
        for (int n = 0; n < 2; ++n) {
            const Result<Volume>& volume = impl.loaded.at(moment.frames[n]);
            if (!volume) return volume.error();
            moment.volumes[n] = *volume;
        }
        lock.unlock();
        impl.last = moment;
        return moment;
    });
}

}  // namespace photic::runtime
