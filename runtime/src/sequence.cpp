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

namespace {

/// The frames on either side of a time, and how much of the second.
struct Neighbours {
    int frames[2];
    double weight;
};

}  // namespace

struct VolumeSequence::Impl {
    Impl(std::vector<std::string> files, const SequenceOptions& with)
        : paths(std::move(files)), count(static_cast<int>(paths.size())), options(with) {}
    ~Impl();
    void run();

    bool loops() const { return options.end == SequenceEnd::Loop; }
    /// Frames from the beginning, 0 to below count; up to count - 1 where the end is held.
    double positionOf(double seconds) const;
    /// The frame `steps` after or before one; nothing beyond an end that is held.
    std::optional<int> stepped(int frame, int steps) const;
    // Under the mutex:
    /// The nearest frames before and after that have not failed; nothing when all have.
    std::optional<Neighbours> neighboursOf(double position) const;
    double distance(int frame) const;  ///< from the time that was asked for last [frames]
    /// Of the loaded ones; nothing while there are none.
    std::optional<int> nearestLoaded() const;
    void want(const Neighbours& shown);
    void dropUnwanted();

    const std::vector<std::string> paths;
    const int count;
    const SequenceOptions options;

    std::mutex mutex;
    std::condition_variable wanted_changed, loaded_changed;
    // Guarded by the mutex.
    double position = 0;      ///< that was asked for last
    std::vector<int> wanted;  ///< most urgent first
    std::map<int, Volume> loaded;
    std::map<int, Error> failed;
    bool stopping = false;

    std::thread thread;  ///< last: it uses all of the above
};

VolumeSequence::Impl::~Impl() {
    {
        const std::lock_guard lock(mutex);
        stopping = true;
    }
    wanted_changed.notify_all();
    if (thread.joinable()) thread.join();
}

double VolumeSequence::Impl::positionOf(double seconds) const {
    const double frames = seconds * options.frames_per_second;
    if (!loops()) return std::clamp(frames, 0.0, static_cast<double>(count - 1));
    const double rest = frames - count * std::floor(frames / count);
    return rest < count ? rest : 0;  // rounding may have made it the count itself
}

std::optional<int> VolumeSequence::Impl::stepped(int frame, int steps) const {
    const int to = frame + steps;
    if (loops()) return (to % count + count) % count;
    if (to < 0 || to >= count) return std::nullopt;
    return to;
}

std::optional<Neighbours> VolumeSequence::Impl::neighboursOf(double at) const {
    const int frame = static_cast<int>(at);
    // How many steps it is to the next frame that has not failed, from `frame` on.
    const auto search = [&](int first, int direction) -> std::optional<int> {
        for (int steps = first; steps < first + count; ++steps) {
            const std::optional<int> to = stepped(frame, direction * steps);
            if (!to) return std::nullopt;
            if (failed.count(*to) == 0) return steps;
        }
        return std::nullopt;
    };
    std::optional<int> before = search(0, -1), after = search(1, 1);
    if (!before && !after) return std::nullopt;
    if (!before) before = -*after;  // beyond the first or the last frame that loads, that one stays
    if (!after) after = -*before;
    const int span = *before + *after;
    return Neighbours{{*stepped(frame, -*before), *stepped(frame, *after)},
                      span == 0 ? 0 : std::clamp((at - frame + *before) / span, 0.0, 1.0)};
}

double VolumeSequence::Impl::distance(int frame) const {
    const double apart = std::fabs(frame - position);
    return loops() ? std::min(apart, count - apart) : apart;
}

std::optional<int> VolumeSequence::Impl::nearestLoaded() const {
    const auto nearest = std::min_element(loaded.begin(), loaded.end(), [&](const auto& a, const auto& b) {
        return distance(a.first) < distance(b.first);
    });
    return nearest == loaded.end() ? std::nullopt : std::optional(nearest->first);
}

void VolumeSequence::Impl::want(const Neighbours& shown) {
    wanted.assign(shown.frames, shown.frames + 2);
    std::optional<int> next = shown.frames[1];
    for (int n = 0; n < options.ahead; ++n) {
        next = stepped(*next, 1);
        if (!next) break;
        if (failed.count(*next) == 0) wanted.push_back(*next);
    }
    wanted_changed.notify_all();
}

void VolumeSequence::Impl::dropUnwanted() {
    // Until the frames of now are there, the nearest one is shown: it stays.
    const std::optional<int> nearest = nearestLoaded();
    std::erase_if(loaded, [&](const auto& entry) {
        return entry.first != *nearest && std::find(wanted.begin(), wanted.end(), entry.first) == wanted.end();
    });
}

void VolumeSequence::Impl::run() {
    std::unique_lock lock(mutex);
    while (true) {
        const auto missing = [&] {
            return std::find_if(wanted.begin(), wanted.end(),
                                [&](int frame) { return loaded.count(frame) == 0 && failed.count(frame) == 0; });
        };
        wanted_changed.wait(lock, [&] { return stopping || missing() != wanted.end(); });
        if (stopping) return;
        const int frame = *missing();
        dropUnwanted();  // makes room first
        lock.unlock();
        Result<Volume> volume = loadVolume(paths[static_cast<std::size_t>(frame)], options.load);
        lock.lock();
        if (volume) {
            loaded.emplace(frame, std::move(*volume));
        } else {
            failed.emplace(frame, volume.error());
        }
        loaded_changed.notify_all();
    }
}

VolumeSequence::VolumeSequence(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VolumeSequence::VolumeSequence(VolumeSequence&&) noexcept = default;
VolumeSequence& VolumeSequence::operator=(VolumeSequence&&) noexcept = default;
VolumeSequence::~VolumeSequence() = default;

int VolumeSequence::frameCount() const { return impl_->count; }

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
        std::unique_lock lock(impl.mutex);
        impl.position = impl.positionOf(seconds);
        const int frame = static_cast<int>(impl.position);
        Moment moment;
        while (true) {
            const std::optional<Neighbours> shown = impl.neighboursOf(impl.position);
            if (!shown) return impl.failed.begin()->second;
            impl.want(*shown);
            const bool ready = impl.loaded.count(shown->frames[0]) != 0 && impl.loaded.count(shown->frames[1]) != 0;
            if (ready || when_late == WhenLate::ShowNearest) {
                std::copy_n(shown->frames, 2, moment.frames);
                moment.weight = shown->weight;
                moment.late = !ready;
                break;
            }
            // A frame that turns out not to load changes who the neighbours are.
            const std::size_t failures = impl.failed.size();
            impl.loaded_changed.wait(lock, [&] {
                return impl.failed.size() != failures ||
                       (impl.loaded.count(shown->frames[0]) != 0 && impl.loaded.count(shown->frames[1]) != 0);
            });
        }
        for (const std::optional<int> own : {std::optional(frame), impl.stepped(frame, 1)}) {
            const auto failure = own ? impl.failed.find(*own) : impl.failed.end();
            if (failure != impl.failed.end() && !moment.failure) moment.failure = failure->second;
        }
        // Behind the two that are shown stand those that are loaded ahead.
        for (std::size_t n = 2; n < impl.wanted.size() && moment.next < 0; ++n) {
            const auto ahead = impl.loaded.find(impl.wanted[n]);
            if (ahead != impl.loaded.end()) moment.next = ahead->first, moment.next_volume = ahead->second;
        }
        if (moment.late) {
            const std::optional<int> nearest = impl.nearestLoaded();
            if (!nearest) return moment;
            moment.frames[0] = moment.frames[1] = *nearest;
            moment.weight = 0;
        }
        for (int n = 0; n < 2; ++n) moment.volumes[n] = impl.loaded.at(moment.frames[n]);
        return moment;
    });
}

}  // namespace photic::runtime
