// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bake/report/monitor.h"

namespace photic {

/// For work of several parts that each run through one stage (lights, directions, channels): to the outside it is one
/// stage.
class PartMonitor final : public Monitor {
public:
    PartMonitor(Monitor& to, int parts) : to_(to), parts_(parts) {}
    void nextPart() { ++part_; }

    void progress(std::string_view stage, double fraction) override {
        to_.progress(stage, (part_ + fraction) / parts_);
    }
    void warn(const std::string& message) override { to_.warn(message); }
    bool cancelled() const override { return to_.cancelled(); }

private:
    Monitor& to_;
    int parts_, part_ = 0;
};

}  // namespace photic
