// SPDX-License-Identifier: Apache-2.0
#include "bake/image/image.h"
#include "tests/fuzz/fuzzed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static photic::fuzz::MemoryFile file;
    file.hold(data, size);
    photic::fuzz::refusedOrRead([&] {
        const std::vector<std::string> names = photic::exrChannelNames(file.path());
        if (names.empty()) return;
        const auto maps = photic::readExrChannels(file.path(), {names.front()});
        photic::fuzz::demand(maps.size() == 1 && maps[0].values.size() == static_cast<std::size_t>(maps[0].width) *
                                                                              static_cast<std::size_t>(maps[0].height));
    });
    photic::fuzz::refusedOrRead([&] { (void)photic::readExr(file.path()); });
    return 0;
}
