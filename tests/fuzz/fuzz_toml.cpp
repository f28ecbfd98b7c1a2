// SPDX-License-Identifier: Apache-2.0
// Scene files, without the files that they name.
#include "bake/scene/load_toml.h"
#include "tests/fuzz/fuzzed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    photic::fuzz::refusedOrRead([&] {
        photic::Monitor monitor;
        const std::string text(reinterpret_cast<const char*>(data), size);
        (void)photic::parseScene(text, "scene.toml", "/nonexistent", 1, monitor);
    });
    return 0;
}
