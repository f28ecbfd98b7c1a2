// SPDX-License-Identifier: Apache-2.0
// Writes the floor map of the focused pool under a sun with a disc: the mean of exact maps, one per direction.
// usage: make_disc_floor OUTPUT.f32 [mesh] [directions]
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <vector>

#include "tests/support/pool3.h"

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: %s OUTPUT.f32 [mesh = 2048] [directions = 512]\n", argv[0]);
        return 2;
    }
    namespace pool3 = photic::truth::pool3;
    const int mesh = argc > 2 ? std::atoi(argv[2]) : 2048, count = argc > 3 ? std::atoi(argv[3]) : 512;
    std::vector<double> sum(512 * 512);
    for (const auto& direction : pool3::discDirections(pool3::sun(), 0.53, count)) {
        const auto map = pool3::traceFloor(mesh, 512, direction);
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += map.values[i] / count;
    }
    const std::vector<float> raw(sum.begin(), sum.end());
    std::ofstream out(argv[1], std::ios::binary);
    out.write(reinterpret_cast<const char*>(raw.data()), static_cast<std::streamsize>(raw.size() * sizeof(float)));
    return out.good() ? 0 : 4;
}
