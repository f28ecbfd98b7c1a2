// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "photic/runtime.h"

/// One volume that is loaded by a thread of its own while the game goes on:
///
///     auto load = photic::runtime::VolumeLoad::start("cave.nvdb");
///     ...each frame: if (load && load->done()) { auto cave = load->take(); ... }
namespace photic::runtime {

class VolumeLoad {
public:
    /// Starts the thread. What is wrong with the file is what take() returns.
    /// @return Error{Memory} when the system has no thread left
    static Result<VolumeLoad> start(std::string path, const LoadOptions& options = {});
    VolumeLoad(VolumeLoad&&) noexcept;
    VolumeLoad& operator=(VolumeLoad&&) noexcept;
    ~VolumeLoad();  ///< waits for the load that is under way

    /// Whether take() will not wait. Never waits itself.
    bool done() const;
    /// What loadVolume() returned, waited for if need be; may be asked for again.
    Result<Volume> take();

private:
    struct Impl;
    explicit VolumeLoad(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace photic::runtime
