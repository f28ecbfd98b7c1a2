// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/fuzzed_mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    photic::fuzz::readMesh(photic::readObj, data, size);
    return 0;
}
