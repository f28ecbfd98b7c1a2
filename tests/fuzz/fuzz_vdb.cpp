// SPDX-License-Identifier: Apache-2.0
// A .vdb as a light volume, as an index volume and as one of absorption.
#include <cmath>

#include "bake/file/vdb.h"
#include "bake/scene/index_volume.h"
#include "bake/scene/medium_volume.h"
#include "tests/fuzz/fuzzed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static photic::fuzz::MemoryFile file;
    file.hold(data, size);
    photic::fuzz::refusedOrRead([&] {
        const photic::LightVolume volume = photic::readVdb(file.path());
        photic::fuzz::demand(volume.reference_irradiance > 0);
    });
    const std::string bytes(reinterpret_cast<const char*>(data), size);
    photic::fuzz::refusedOrRead([&] {
        photic::Monitor monitor;
        const photic::IndexVolume index = photic::readIndexVolume("a.vdb", bytes, "", 1.33, monitor);
        photic::fuzz::demand(index.least() >= photic::kLeastIndex && index.largest() <= photic::kLargestIndex);
    });
    photic::fuzz::refusedOrRead([&] {
        const auto absorption = photic::readMediumVolume("a.vdb", bytes, "");
        photic::fuzz::demand(std::isfinite(absorption.at(glm::dvec3(0.1)).x));
    });
    return 0;
}
