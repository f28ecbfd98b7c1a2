// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "bake/report/error.h"

namespace photic {

/// Receives progress and warnings from a running bake, and tells it to stop.
/// Methods may call it from any thread; implementations lock.
class Monitor {
public:
    virtual ~Monitor() = default;

    /// @param stage     "scene", "trace", "deposit", "field", "write" ...
    /// @param fraction  of that stage, 0..1
    virtual void progress(std::string_view stage, double fraction) {
        (void)stage;
        (void)fraction;
    }
    /// Something that a user should know and that does not stop the bake.
    virtual void warn(const std::string& message) { (void)message; }
    /// What was assumed where a user said nothing.
    virtual void note(const std::string& message) { (void)message; }
    /// True once the work is no longer wanted.
    virtual bool cancelled() const { return false; }

    /// @throws Error{Cancelled} once cancelled() is true
    void checkCancelled() const {
        if (cancelled()) throw Error(ErrorCode::Cancelled, "cancelled");
    }
};

}  // namespace photic
