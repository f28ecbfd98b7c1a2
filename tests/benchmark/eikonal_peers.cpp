// SPDX-License-Identifier: Apache-2.0
#include "tests/benchmark/eikonal_peers.h"

#include <fmt/format.h>
#include <openvdb/tools/FastSweeping.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <utility>

#include "bake/libraries/openvdb.h"

namespace photic::benchmark {

namespace fs = std::filesystem;

namespace {

/// Runs a command that prints its seconds and leaves n^3 doubles in a file.
std::optional<PeerRun> runOf(const std::string& command, int n, const std::string& arrivals) {
    PeerRun run;
    bool good = false;
    if (FILE* pipe = popen(command.c_str(), "r")) {
        good = std::fscanf(pipe, "%lf", &run.seconds) == 1;
        good = pclose(pipe) == 0 && good;
    }
    if (good) {
        run.arrival.resize(std::size_t(n) * std::size_t(n) * std::size_t(n));
        std::ifstream in(arrivals, std::ios::binary);
        in.read(reinterpret_cast<char*>(run.arrival.data()), std::streamsize(run.arrival.size() * sizeof(double)));
        good = bool(in);
    }
    return good ? std::optional(std::move(run)) : std::nullopt;
}

}  // namespace

std::optional<PeerRun> scikitFmm(int n, int order, const std::string& height_in_python) {
    const char* chosen = std::getenv("PHOTIC_PYTHON");
    const std::string python = chosen ? chosen : "python3";
    const std::string base = (fs::temp_directory_path() / fmt::format("photic_skfmm_{}_{}", n, order)).string();
    std::ofstream(base + ".py") << fmt::format(
        "import time, numpy as np, skfmm\n"
        "n = {}\na = (np.arange(n) + 0.5) / n\nz, y, x = np.meshgrid(a, a, a, indexing='ij')\n"
        "phi = z - ({})\nstart = time.process_time()\n"
        "t = skfmm.travel_time(phi, np.ones_like(phi), dx=1.0 / n, order={})\n"
        "seconds = time.process_time() - start\n"
        "np.ma.filled(t, 1e60).astype('<f8').tofile('{}.f64')\nprint(seconds)\n",
        n, height_in_python, order, base);
    std::optional<PeerRun> run = runOf(fmt::format("{} {}.py 2>/dev/null", python, base), n, base + ".f64");
    for (const char* end : {".py", ".f64"}) fs::remove(base + end);
    return run;
}

std::optional<PeerRun> itkMarching([[maybe_unused]] int n, [[maybe_unused]] const std::vector<double>& known) {
#ifdef PHOTIC_ITK_MARCHING
    const std::string base = (fs::temp_directory_path() / fmt::format("photic_itk_{}", n)).string();
    std::ofstream(base + ".in", std::ios::binary)
        .write(reinterpret_cast<const char*>(known.data()), std::streamsize(known.size() * sizeof(double)));
    std::optional<PeerRun> run =
        runOf(fmt::format("{} {} {}.in {}.out", PHOTIC_ITK_MARCHING, n, base, base), n, base + ".out");
    for (const char* end : {".in", ".out"}) fs::remove(base + end);
    return run;
#else
    return std::nullopt;
#endif
}

PeerRun openvdbSweeping(int n, const std::vector<double>& level_set) {
    openvdb::initialize();
    // Positive below the surface, as the background is: no front starts at the sides of the box.
    auto grid = openvdb::FloatGrid::create(static_cast<float>(n));
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    auto access = grid->getAccessor();
    std::size_t at = 0;
    for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) access.setValue({x, y, z}, -static_cast<float>(level_set[at++]));
    grid->setTransform(openvdb::math::Transform::createLinearTransform(1.0 / n));
    const std::clock_t start = std::clock();
    const auto swept = openvdb::tools::sdfToSdf(*grid, 0.0f, 1);
    PeerRun run;
    run.seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
    const auto read = swept->getConstAccessor();
    for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) run.arrival.push_back(double(read.getValue({x, y, z})));
    return run;
}

}  // namespace photic::benchmark
