// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "photic/runtime.h"
#include "tests/runtime/nvdb_files.h"

namespace photic::test {

/// The volume of a file as `spec` has it; a failure of the test, and an empty one, where it cannot be read.
inline runtime::Volume loaded(const NvdbSpec& spec) {
    const auto bytes = makeNvdb(spec);
    auto volume = runtime::readVolume(bytes.data(), bytes.size());
    if (!volume) {
        ADD_FAILURE() << volume.error().message;
        return {};
    }
    return *volume;
}

}  // namespace photic::test
