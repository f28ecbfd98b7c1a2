// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/stop.h"

#include <fmt/format.h>
#include <semaphore.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <ctime>
#include <fstream>
#include <thread>
#include <utility>

namespace photic::cli {

namespace {

std::atomic<Stop> g_stop{Stop::No};
std::atomic<std::int64_t> g_most_bytes{0};  // 0: no limit
sem_t g_wake;
static_assert(std::atomic<Stop>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

void askFor(Stop why) {
    Stop none = Stop::No;
    g_stop.compare_exchange_strong(none, why);
    sem_post(&g_wake);
}

/// Memory that the process holds [bytes].
std::int64_t heldBytes() {
    std::int64_t total = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> total >> resident;
    return resident * sysconf(_SC_PAGE_SIZE);
}

/// Returns when woken or after some seconds.
void waitFor(double seconds) {
    timespec until{};
    clock_gettime(CLOCK_REALTIME, &until);
    const auto nanoseconds = until.tv_nsec + static_cast<long>(seconds * 1e9);
    until.tv_sec += nanoseconds / 1000000000, until.tv_nsec = nanoseconds % 1000000000;
    while (sem_timedwait(&g_wake, &until) != 0 && errno == EINTR) {
    }
}

void watch(const std::function<void(const Error&)>& last_word) {
    constexpr double kBetweenLooks = 0.01;
    while (g_stop == Stop::No) {
        const std::int64_t most = g_most_bytes;
        waitFor(most > 0 ? kBetweenLooks : 3600);
        if (most > 0 && heldBytes() > most) askFor(Stop::Memory);
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(kPatience));
    const Error why = explained(Error(ErrorCode::Cancelled, "cancelled"));
    last_word(why);
    _exit(static_cast<int>(why.code()));
}

}  // namespace

Stop stopWanted() { return g_stop.load(); }

void watchSignals(std::function<void(const Error&)> last_word) {
    sem_init(&g_wake, 0, 0);
    struct sigaction action {};
    action.sa_handler = [](int) { askFor(Stop::Signal); };
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    // A write past the file-size limit, or into a pipe that nobody reads, then returns an error that is reported.
    std::signal(SIGXFSZ, SIG_IGN);
    std::signal(SIGPIPE, SIG_IGN);
    std::thread([last_word = std::move(last_word)] { watch(last_word); }).detach();
}

void watchMemory(std::int64_t most_bytes) {
    g_most_bytes = most_bytes;
    sem_post(&g_wake);
}

std::int64_t memoryAllowed() { return g_most_bytes.load(); }

Error explained(const Error& error) {
    if (error.code() != ErrorCode::Cancelled) return error;
    if (stopWanted() == Stop::Memory) {
        return {ErrorCode::Failed,
                fmt::format("took more memory than the {:.3g} GB allowed; use a larger voxel_size, where = "
                            "\"receivers\", fewer grids, or allow more",
                            static_cast<double>(g_most_bytes.load()) * 1e-9),
                "--max-memory"};
    }
    return {ErrorCode::Cancelled, "interrupted; nothing was written that was not whole", error.where()};
}

}  // namespace photic::cli
