// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "runtime/src/gl_functions.h"
#include "tests/support/gl_context.h"

namespace photic::test {

/// A test that needs GL: skipped, with the reason, where there is none. Fails when a GL error is left at its end.
class WithGl : public testing::Test {
protected:
    void SetUp() override { open(GlApi::Core43); }
    void TearDown() override {
        if (!context_) return;
        EXPECT_EQ(gl_.firstError(), static_cast<GLenum>(GL_NO_ERROR));
    }

    void open(GlApi api) {
        std::string reason;
        context_.reset();
        context_ = HeadlessGl::make(reason, api);
        if (!context_) GTEST_SKIP() << reason;
        const auto loaded = runtime::loadGlFunctions(context_->loader());
        ASSERT_TRUE(loaded.ok()) << loaded.error().message;
        gl_ = *loaded;
    }

    std::unique_ptr<HeadlessGl> context_;
    runtime::GlFunctions gl_;
};

}  // namespace photic::test
