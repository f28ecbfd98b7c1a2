// SPDX-License-Identifier: Apache-2.0
#include "bake/report/error_text.h"

#include <gtest/gtest.h>

namespace photic {
namespace {

TEST(ErrorText, NamesTheFileOnce) {
    EXPECT_EQ(errorText({ErrorCode::Input, "cannot read cut.vdb: it ends too soon", "cut.vdb"}),
              "cannot read cut.vdb: it ends too soon");
    EXPECT_EQ(errorText({ErrorCode::Input, "it holds no light", "cut.vdb"}), "cut.vdb: it holds no light");
    EXPECT_EQ(errorText({ErrorCode::Input, "power must be positive", "pool.toml:12"}),
              "pool.toml:12: power must be positive");
    EXPECT_EQ(errorText({ErrorCode::Usage, "give a scene"}), "give a scene");
    EXPECT_EQ(errorText({ErrorCode::Input, "there is no uncut.vdb beside it", "cut.vdb"}),
              "cut.vdb: there is no uncut.vdb beside it");
    EXPECT_EQ(errorText({ErrorCode::Usage, "give --scenes instead", "--scene"}), "--scene: give --scenes instead");
    EXPECT_EQ(errorText({ErrorCode::Input, "cannot read 'out/cut.vdb'", "cut.vdb"}), "cannot read 'out/cut.vdb'");
}

}  // namespace
}  // namespace photic
