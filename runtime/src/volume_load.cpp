// SPDX-License-Identifier: Apache-2.0
#include "photic/volume_load.h"

#include <atomic>
#include <optional>
#include <system_error>
#include <thread>

#include "runtime/src/guarded.h"

namespace photic::runtime {

struct VolumeLoad::Impl {
    ~Impl() { wait(); }
    void wait() {
        if (thread.joinable()) thread.join();
    }

    std::optional<Result<Volume>> result;  ///< the thread's until `done`
    std::atomic<bool> done{false};
    std::thread thread;
};

VolumeLoad::VolumeLoad(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VolumeLoad::VolumeLoad(VolumeLoad&&) noexcept = default;
VolumeLoad& VolumeLoad::operator=(VolumeLoad&&) noexcept = default;
VolumeLoad::~VolumeLoad() = default;

Result<VolumeLoad> VolumeLoad::start(std::string path, const LoadOptions& options) {
    return guarded([&]() -> Result<VolumeLoad> {
        auto impl = std::make_unique<Impl>();
        try {
            impl->thread = std::thread([p = impl.get(), path = std::move(path), options] {
                p->result.emplace(loadVolume(path, options));
                p->done.store(true, std::memory_order_release);
            });
        } catch (const std::system_error&) {
            return Error{ErrorCode::Memory, "the system has no thread left to load a volume with"};
        }
        return VolumeLoad(std::move(impl));
    });
}

bool VolumeLoad::done() const { return impl_->done.load(std::memory_order_acquire); }

Result<Volume> VolumeLoad::take() {
    impl_->wait();
    return *impl_->result;
}

}  // namespace photic::runtime
