// SPDX-License-Identifier: Apache-2.0
#include "bake/threads/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#ifndef PHOTIC_STD_THREADS
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#endif
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

#include "bake/report/error.h"
#include "bake/threads/stop_loops.h"

namespace photic {
namespace {
std::atomic<int> g_threads{0};
std::atomic<bool (*)()> g_stop{nullptr};

void endWhereAsked() {
    bool (*const wanted)() = g_stop.load(std::memory_order_relaxed);
    if (wanted && wanted()) throw Error(ErrorCode::Cancelled, "cancelled");
}

// Numbers below 1e-38 count as 0 while it lives, on every thread alike: libraries set that on some threads and leave it
// there, which would let results depend on who does what; and such numbers are slow, and are many behind opaque media.
class [[maybe_unused]] TinyIsZero {
public:
#ifdef __SSE2__
    TinyIsZero() : before_(_mm_getcsr()) { _mm_setcsr(before_ | kFlushToZero | kDenormalsAreZero); }
    ~TinyIsZero() { _mm_setcsr(before_); }
    TinyIsZero(const TinyIsZero&) = delete;
    TinyIsZero& operator=(const TinyIsZero&) = delete;

private:
    static constexpr unsigned kFlushToZero = 0x8000, kDenormalsAreZero = 0x0040;
    unsigned before_;
#endif
};
}  // namespace

void stopLoopsWhen(bool (*wanted)()) { g_stop = wanted; }

int threadCount() {
    const int set = g_threads.load();
    return set > 0 ? set : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

#ifdef PHOTIC_STD_THREADS

void setThreadCount(int count) { g_threads = count; }

void parallelFor(std::int64_t count, const std::function<void(std::int64_t)>& body) {
    std::atomic<std::int64_t> next{0};
    std::exception_ptr failure;
    std::mutex failure_mutex;
    const auto work = [&] {
        for (std::int64_t i; (i = next.fetch_add(1)) < count;) {
            try {
                const TinyIsZero tiny;
                endWhereAsked();
                body(i);
            } catch (...) {
                const std::lock_guard lock(failure_mutex);
                if (!failure) failure = std::current_exception();
                next = count;
            }
        }
    };
    std::vector<std::thread> pool;
    for (int t = 1; t < std::min<std::int64_t>(threadCount(), count); ++t) pool.emplace_back(work);
    work();
    for (auto& t : pool) t.join();
    if (failure) std::rethrow_exception(failure);
}

#else

namespace {
std::unique_ptr<tbb::global_control> g_limit;
}

void setThreadCount(int count) {
    g_threads = count;
    g_limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    static_cast<std::size_t>(threadCount()));
}

void parallelFor(std::int64_t count, const std::function<void(std::int64_t)>& body) {
    if (threadCount() == 1 || count < 2) {
        const TinyIsZero tiny;
        for (std::int64_t i = 0; i < count; ++i) {
            endWhereAsked();
            body(i);
        }
        return;
    }
    tbb::parallel_for(
        std::int64_t{0}, count,
        [&](std::int64_t i) {
            const TinyIsZero tiny;
            endWhereAsked();
            body(i);
        },
        tbb::simple_partitioner{});
}

#endif

}  // namespace photic
