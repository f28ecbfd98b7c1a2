// SPDX-License-Identifier: Apache-2.0
// photic_benchmark: run time against error, as tables, CSV and a picture. See README.md.
#include <fmt/format.h>

#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "bake/field/heap.h"
#include "tests/benchmark/sections.h"

namespace {

using namespace photic::benchmark;

struct Section {
    const char* name;
    void (*run)(const Effort&, Findings&);
};
constexpr Section kSections[] = {{"kernels", kernels},   {"bakes", bakes},         {"threads", threadScaling},
                                 {"stages", stages},     {"writes", writes},       {"skipping", skipping},
                                 {"floor", floorErrors}, {"volume", volumeErrors}, {"eikonal", eikonal},
                                 {"waves", waves},       {"fronts", fronts},       {"front_peers", frontPeers}};
// Not run unless asked for.
constexpr Section kLargeSections[] = {{"eikonal512", eikonalLarge}, {"waves512", wavesLarge}};

std::string processor() {
    std::ifstream in("/proc/cpuinfo");
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    }
    return "unknown processor";
}

int usage() {
    std::fputs(
        "usage: photic_benchmark [--quick] [--only SECTION]... [--markdown FILE] [--csv FILE] [--svg FILE]\nsections:",
        stderr);
    for (const Section& s : kSections) fmt::print(stderr, " {}", s.name);
    std::fputs("\nonly when asked for:", stderr);
    for (const Section& s : kLargeSections) fmt::print(stderr, " {}", s.name);
    std::fputs("\n", stderr);
    return 2;
}

bool write(const std::string& path, const std::string& text) {
    if (path.empty()) return true;
    std::ofstream out(path);
    out << text;
    out.close();
    if (!out) fmt::print(stderr, "cannot write {}\n", path);
    return !out.fail();
}

int run(int argc, char** argv) {
    Effort effort;
    std::string markdown_path, csv_path, svg_path;
    std::vector<std::string> only;
    for (int i = 1; i < argc; ++i) {
        const std::string arg = argv[i];
        const bool has_value = i + 1 < argc;
        if (arg == "--quick")
            effort.quick = true;
        else if (arg == "--only" && has_value)
            only.push_back(argv[++i]);
        else if (arg == "--markdown" && has_value)
            markdown_path = argv[++i];
        else if (arg == "--csv" && has_value)
            csv_path = argv[++i];
        else if (arg == "--svg" && has_value)
            svg_path = argv[++i];
        else
            return usage();
    }
    const auto wanted = [&](const char* name) {
        for (const auto& o : only)
            if (o == name) return true;
        return only.empty();
    };
    std::string text = fmt::format("{}, {} hardware threads.\n", processor(), std::thread::hardware_concurrency());
    fmt::print("{}", text);
    Findings findings;
    bool ran = false;
    std::vector<Section> sections(std::begin(kSections), std::end(kSections));
    if (!only.empty()) sections.insert(sections.end(), std::begin(kLargeSections), std::end(kLargeSections));
    for (const Section& s : sections) {
        if (!wanted(s.name)) continue;
        ran = true;
        const std::size_t first = findings.tables.size();
        s.run(effort, findings);
        for (std::size_t t = first; t < findings.tables.size(); ++t) {
            const std::string table = markdown(findings.tables[t]);
            fmt::print("{}", table);
            std::fflush(stdout);
            text += table;
        }
    }
    if (!ran) return usage();
    const bool written = write(markdown_path, text) && write(csv_path, csv(findings.tables)) &&
                         write(svg_path, paretoSvg("Run time against relative RMSE, pool 128^3", findings.points));
    return written ? 0 : 4;
}

}  // namespace

int main(int argc, char** argv) {
    photic::keepFreedMemory();  // as the command line does
    try {
        return run(argc, argv);
    } catch (const std::exception& e) {
        fmt::print(stderr, "{}\n", e.what());
        return 4;
    }
}
