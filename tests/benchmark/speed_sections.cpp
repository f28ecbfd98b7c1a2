// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "bake/field/scene_grid.h"
#include "bake/file/vdb.h"
#include "bake/paths/launch_domain.h"
#include "bake/scene/load_toml.h"
#include "bake/threads/parallel_for.h"
#include "tests/benchmark/sections.h"

namespace photic::benchmark {
namespace {

std::string milliseconds(double s) { return fmt::format("{:.1f}", 1e3 * s); }
std::string ratio(double r) { return fmt::format("{:.2f}", r); }
std::string percent(double part) { return fmt::format("{:.1f} %", 100 * part); }

template <class Work>
double secondsOf(const Work& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

GivenOptions mesh(std::int64_t cells) { return option("mesh", cells); }

}  // namespace

void kernels(const Effort& effort, Findings& findings) {
    setThreadCount(1);
    const int n = effort.quick ? 16 : 128;
    Table table{
        fmt::format("Deposit kernels, pool {0}^3, mesh {1}, one core", n, 2 * n),
        "The same triangles and the same sums. `scalar` clips each tube against each voxel.",
        {"kernel", "instruction set", "bake [ms]", "deposit [ms]", "bake: scalar / this", "deposit: scalar / this"},
        {}};
    double scalar = 0, scalar_deposit = 0;
    for (const std::string kernel : {"scalar", "portable", "avx2", "avx512"}) {
        const GivenOptions options =
            mesh(2 * n) | option("kernel", std::string(kernel == "scalar" ? "scalar" : "edges"));
        setenv("PHOTIC_INSTRUCTION_SET", kernel == "scalar" ? "portable" : kernel.c_str(), 1);
        const Timed t = measure(poolCase(poolBox(n), "beams", options), effort);
        double deposit = 0;
        for (const auto& [stage, seconds] : t.result.report.seconds) deposit += stage == "deposit" ? seconds : 0;
        if (kernel == "scalar") scalar = t.seconds, scalar_deposit = deposit;
        if (kernel != "scalar" && t.result.report.instruction_set != kernel)
            continue;  // this processor has no such instructions
        table.add({kernel, kernel == "scalar" ? "portable" : kernel, milliseconds(t.seconds), milliseconds(deposit),
                   ratio(scalar / t.seconds), ratio(scalar_deposit / deposit)});
    }
    unsetenv("PHOTIC_INSTRUCTION_SET");
    findings.tables.push_back(table);
    setThreadCount(0);
}

void bakes(const Effort& effort, Findings& findings) {
    setThreadCount(1);
    struct Row {
        std::string name;
        truth::pool3::SceneText text;
        std::int64_t mesh;
        double to_beat;  // [s], measured on a prototype kernel before
    };
    std::vector<Row> rows{{"128^3", poolBox(128), 256, 0.107},
                          {"256^3", poolBox(256), 256, 0.33},
                          {"256^3 sheared", shearedPoolBox(256, 256), 256, 0.161},
                          {"256^3", poolBox(256), 512, 0.95},
                          {"256^3 sheared", shearedPoolBox(256, 256), 512, 0.39},
                          {"512 x 512 x 64 sheared", shearedPoolBox(512, 64), 512, 0.37},
                          {"floor map 512 x 512", poolFloor(512), 512, 0.087}};
    if (effort.quick) rows = {{"16^3", poolBox(16), 32, 0}, {"floor map 32 x 32", poolFloor(32), 32, 0}};
    Table table{"Bakes, irradiance and direction, one core, without the write",
                "`mesh n`: n x n cells of the patch that is launched. `cells 4 m / n`: cells as large as those of n x "
                "n on the whole "
                "pool, [-2, 2]^2.",
                {"bake", "corner rays", "voxels", "[s]", "to beat [s]", "million voxels/s", "instruction set"},
                {}};
    for (const Row& row : rows) {
        Case c = poolCase(row.text, "beams", {});
        const LaunchDomain launched =
            launchDomain(c.scene, c.scene.surfaces[0], c.scene.lights[0], sceneFrame(c.scene));
        const auto alike =
            static_cast<std::int64_t>(std::ceil(std::sqrt(launched.area()) / 4 * static_cast<double>(row.mesh)));
        for (const bool same_cells : {false, true}) {
            c.options = mesh(same_cells ? alike : row.mesh);
            const Timed t = measure(c, effort);
            const auto voxels = static_cast<double>(t.result.report.needed_voxels);
            table.add({fmt::format("{}, {} {}", row.name, same_cells ? "cells 4 m /" : "mesh", row.mesh),
                       std::to_string(t.result.report.corner_rays), fmt::format("{:.2f} M", voxels / 1e6),
                       fmt::format("{:.3f}", t.seconds), row.to_beat > 0 ? fmt::format("{:.3f}", row.to_beat) : "",
                       fmt::format("{:.1f}", voxels / t.seconds / 1e6), t.result.report.instruction_set});
        }
    }
    findings.tables.push_back(table);
    setThreadCount(0);
}

void threadScaling(const Effort& effort, Findings& findings) {
    const int n = effort.quick ? 16 : 256;
    Table table{fmt::format("Threads, pool {0}^3, mesh {0}", n), "", {"threads", "[s]", "one / this"}, {}};
    double one = 0;
    for (const int threads : {1, 2}) {
        setThreadCount(threads);
        const Timed t = measure(poolCase(poolBox(n), "beams", mesh(n)), effort);
        if (threads == 1) one = t.seconds;
        table.add({std::to_string(threads), fmt::format("{:.3f}", t.seconds), ratio(one / t.seconds)});
    }
    setThreadCount(0);
    findings.tables.push_back(table);
}

void stages(const Effort& effort, Findings& findings) {
    setThreadCount(1);
    Table table{"Stages, one core", "", {"bake", "stage", "[ms]", "share"}, {}};
    const int n = effort.quick ? 16 : 256, floor = effort.quick ? 32 : 512;
    const std::vector<std::pair<std::string, truth::pool3::SceneText>> cases{
        {fmt::format("{0}^3, mesh {0}", n), poolBox(n)}, {fmt::format("floor map, mesh {}", floor), poolFloor(floor)}};
    for (const auto& [name, text] : cases) {
        const Timed t = measure(poolCase(text, "beams", mesh(text.layer_height > 0 ? floor : n)), effort);
        double sum = 0;
        for (const auto& [stage, seconds] : t.result.report.seconds) sum += seconds;
        for (const auto& [stage, seconds] : t.result.report.seconds) {
            table.add({fmt::format("{}, {}", name, stage), stage, milliseconds(seconds), percent(seconds / sum)});
        }
    }
    setThreadCount(0);
    findings.tables.push_back(table);
}

void writes(const Effort& effort, Findings& findings) {
    setThreadCount(1);
    const int n = effort.quick ? 16 : 256;
    Timed t = measure(poolCase(poolBox(n), "beams", mesh(n)), effort);
    Table table{
        fmt::format("Writing pool {0}^3, mesh {0}, irradiance and direction", n),
        fmt::format("The bake takes {:.3f} s. Files lie in $TMPDIR. Writing reads all back and compares.", t.seconds),
        {"file", "write [s]", "write / bake", "read [s]", "read / bake", "MB", "bytes a voxel"},
        {}};
    const auto voxels = static_cast<double>(t.result.report.needed_voxels);
    const LightVolume& volume = t.result.volume;
    const std::string path =
        (std::filesystem::temp_directory_path() / fmt::format("photic_benchmark_{}.vdb", n)).string();
    for (const bool half : {true, false}) {
        for (const auto& [name, compression] : {std::pair{"none", Compression::None},
                                                {"mask", Compression::Mask},
                                                {"blosc", Compression::Blosc},
                                                {"zip", Compression::Zip}}) {
            const double written = secondsOf([&] { writeVdb(path, volume, {compression, half}); });
            const double read = secondsOf([&] { readVdb(path); });
            const auto bytes = static_cast<double>(std::filesystem::file_size(path));
            table.add({fmt::format("{}, {}", half ? "half" : "float", name), fmt::format("{:.3f}", written),
                       ratio(written / t.seconds), fmt::format("{:.3f}", read), ratio(read / t.seconds),
                       fmt::format("{:.1f}", bytes / 1e6), fmt::format("{:.2f}", bytes / voxels)});
        }
    }
    std::filesystem::remove(path);
    setThreadCount(0);
    findings.tables.push_back(table);
}

void skipping(const Effort& effort, Findings& findings) {
    setThreadCount(1);
    const int n = effort.quick ? 16 : 128;
    Table table{fmt::format("Skipping, pool {0} x {0} x {0}, adaptive mesh, one core", n),
                "Seconds of trace and deposit; bytes that the field holds.",
                {"bake", "trace + deposit [ms]", "part of full", "field [MB]", "part of full", "needed voxels"},
                {}};
    const auto traceAndDeposit = [](const BakeReport& report) {
        double sum = 0;
        for (const auto& [stage, seconds] : report.seconds) sum += stage == "trace" || stage == "deposit" ? seconds : 0;
        return sum;
    };
    double full_seconds = 0, full_bytes = 0;
    const auto row = [&](const std::string& name, const truth::pool3::SceneText& text, const GivenOptions& options,
                         bool flat) {
        Case c = poolCase(text, "beams", options);
        if (flat) {
            Monitor monitor;
            std::string toml = truth::pool3::sceneToml(text);
            const auto from = toml.find("waves = ["), to = toml.find("]\n", from);
            toml.replace(from, to + 1 - from, "flat = true");
            c = {parseScene(toml, "flat.toml", ".", 0, monitor), "beams", options};
        }
        const Timed t = measure(c, effort);
        const double seconds = traceAndDeposit(t.result.report),
                     bytes = static_cast<double>(t.result.report.field_bytes);
        if (full_seconds == 0) full_seconds = seconds, full_bytes = bytes;
        table.add({name, milliseconds(seconds), percent(seconds / full_seconds), fmt::format("{:.2f}", bytes / 1e6),
                   percent(bytes / full_bytes), std::to_string(t.result.report.needed_voxels)});
    };
    const truth::pool3::SceneText all = poolBox(n);
    row("everything, waves", all, {}, false);
    truth::pool3::SceneText band = all;
    band.objects =
        "[[object]]\nname = \"floor\"\nplane = { point = [0, 0, -1.5], normal = [0, 0, 1] }\nrole = \"receiver\"\n";
    band.bake = "where = \"receivers\"\nband = 2\n";
    row("four-voxel band at the floor", band, {}, false);
    row("everything, flat water", all, {}, true);
    setThreadCount(0);
    findings.tables.push_back(table);
}

}  // namespace photic::benchmark
