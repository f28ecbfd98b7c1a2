// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "photic/gl_context.h"

namespace photic::runtime {

enum class GlApi { Core43, Core45, Es31 };

/// A GL context without a window or a screen (EGL on a surfaceless or a device platform), current in the thread that
/// made it until it is destroyed.
class HeadlessGl {
public:
    /// Null when there is none; `reason` then says why.
    static std::unique_ptr<HeadlessGl> make(std::string& reason, GlApi api = GlApi::Core43);
    ~HeadlessGl();
    HeadlessGl(const HeadlessGl&) = delete;
    HeadlessGl& operator=(const HeadlessGl&) = delete;

    GlLoader loader() const;
    void makeCurrent() const;

private:
    HeadlessGl() = default;
    void* display_ = nullptr;
    void* context_ = nullptr;
};

}  // namespace photic::runtime
