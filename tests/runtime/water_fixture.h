// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "runtime/src/live_water_impl.h"
#include "tests/runtime/gl_fixture.h"
#include "tests/runtime/water_model.h"

namespace photic::test {

/// A test with a LiveWater under the sun of pool3; fill() gives it heights.
class WithWater : public WithGl {
protected:
    void SetUp() override {
        WithGl::SetUp();
        if (!context_) return;
        const auto gpu = runtime::GpuContext::create(context_->loader());
        ASSERT_TRUE(gpu.ok()) << gpu.error().message;
        auto made = runtime::LiveWater::create(*gpu);
        ASSERT_TRUE(made.ok()) << made.error().message;
        water_.emplace(std::move(made).value());
        ASSERT_TRUE(water_->setLight(pool3Light()).ok());
    }
    void TearDown() override {
        water_.reset();
        WithGl::TearDown();
    }

    void fill(const SampledWater& sampled) { ASSERT_TRUE(water_->setHeights(sampled.water).ok()); }

    std::optional<runtime::LiveWater> water_;
};

}  // namespace photic::test
