// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/baker/lookup_advice.h"
#include "bake/baker/report_json.h"
#include "bake/cli/json.h"
#include "bake/cli/verbs.h"
#include "bake/cli/voxel_walk.h"
#include "bake/field/grid_laws.h"
#include "bake/report/error.h"
#include "bake/report/printable.h"

namespace photic::cli {

namespace {

// Half floats carry 11 bits: a sum of many rounds to far less, and this is what the format promises.
constexpr double kFileLedgerLimit = 1e-3;

struct GridSummary {
    std::string name, unit;
    int channels = 1;
    double min = std::numeric_limits<double>::infinity(), max = -min, sum = 0;
    std::int64_t count = 0;

    void add(double value) {
        min = std::min(min, value);
        max = std::max(max, value);
        sum += value;
        ++count;
    }
    double mean() const { return count > 0 ? sum / static_cast<double>(count) : 0; }
    Json json() const {
        Json out{{"name", name}, {"channels", channels}, {"unit", unit}};
        out["min"] = count > 0 ? Json(min) : Json(nullptr);
        out["max"] = count > 0 ? Json(max) : Json(nullptr);
        out["mean"] = count > 0 ? Json(mean()) : Json(nullptr);
        return out;
    }
};

/// A lobe's grids.
/// @param suffix  of their names
void summariseLobe(const LightVolume& volume, const LightField& field, const std::string& suffix,
                   std::vector<GridSummary>& grids) {
    const std::size_t irradiance_at = grids.size();
    if (volume.has_irradiance) grids.push_back({"irradiance" + suffix, "W/m2", field.channels().irradiance});
    const std::size_t direction_at = grids.size();
    const bool has_direction = volume.has_direction && field.channels().flux;
    if (has_direction) grids.push_back({"direction" + suffix, "length", 3});
    forEachVoxel(field.needed(), [&](const glm::ivec3& voxel) {
        const double irradiance = field.irradiance(voxel);
        if (!suffix.empty() && irradiance <= 0) return;  // not in that grid
        if (volume.has_irradiance) grids[irradiance_at].add(irradiance);
        // Where there is no light there is no direction.
        if (has_direction && irradiance > 0) grids[direction_at].add(glm::length(field.flux(voxel)) / irradiance);
    });
}

std::vector<GridSummary> summarise(const LightVolume& volume) {
    std::vector<GridSummary> grids;
    summariseLobe(volume, volume.field, "", grids);
    if (volume.second) summariseLobe(volume, *volume.second, "_2", grids);
    for (const auto& [name, scalar] : volume.scalars) {
        GridSummary grid{name, name == "arrival_time" ? "m" : "", 1};
        forEachVoxel(scalar.needed(), [&, &values = scalar](const glm::ivec3& voxel) {
            grid.add(static_cast<double>(values.value(voxel, 0)));
        });
        grids.push_back(grid);
    }
    return grids;
}

/// World box of the active voxels, corners included.
Json worldBounds(const GridFrame& frame) {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 index(corner & 1 ? frame.max.x + 0.5 : frame.min.x - 0.5,
                               corner & 2 ? frame.max.y + 0.5 : frame.min.y - 0.5,
                               corner & 4 ? frame.max.z + 0.5 : frame.min.z - 0.5);
        low = glm::min(low, frame.worldFromIndex(index));
        high = glm::max(high, frame.worldFromIndex(index));
    }
    return {{"min", toJson(low)}, {"max", toJson(high)}};
}

/// Sum of the irradiance (mean of the channels) x voxel volume in the file.
double depositedInFile(const LightVolume& volume) {
    const LightField& field = volume.field;
    double sum = 0;
    for (int c = 0; c < field.channels().irradiance; ++c)
        sum += field.sum(c) + (volume.second ? volume.second->sum(c) : 0);
    return sum / field.channels().irradiance * field.frame().voxelVolume();
}

/// Ledgers from the metadata as law checks, and the path ledger from the written voxels.
Json checkLedgers(const LightVolume& volume, std::vector<LawCheck>& laws) {
    const auto text = volume.metadata.find("ledger");
    if (text == volume.metadata.end()) return nullptr;
    PowerLedger power;
    PathLedger path;
    readLedger(text->second, power, path);
    const auto law = [&](const char* name, double value, double limit) {
        laws.push_back({name, value, limit, value <= limit});
    };
    law("power ledger closes", power.imbalance(), kFileLedgerLimit);
    law("path ledger closes", path.imbalance(), kFileLedgerLimit);
    const PathLedger in_file{depositedInFile(volume), path.expected};
    // The prefilter trades neighbours' light: its sum is that of the ledger only where nothing was clamped.
    const auto prefilter = volume.metadata.find("prefilter");
    const bool comparable = volume.has_irradiance && (prefilter == volume.metadata.end() ||
                                                      prefilter->second == "false" || prefilter->second == "none");
    if (comparable) law("path ledger closes in the file", in_file.imbalance(), kFileLedgerLimit);
    return {{"power", toJson(power)},
            {"path", toJson(path)},
            {"path_in_file", toJson(in_file)},
            {"path_in_file_checked", comparable}};
}

std::string describe(const InspectArguments& arguments, const Json& d) {
    const auto triple = [](const Json& v) {
        return fmt::format("({:.6g}, {:.6g}, {:.6g})", v[0].get<double>(), v[1].get<double>(), v[2].get<double>());
    };
    std::string text = fmt::format("{}: {:.1f} MB, {} active voxels\n", printable(arguments.volume),
                                   d["file_bytes"].get<double>() * 1e-6, d["active_voxels"].get<std::int64_t>());
    const Json& grid = d["grid"];
    text += fmt::format("  index {} to {}, world {} to {} m{}\n", triple(grid["index_min"]), triple(grid["index_max"]),
                        triple(d["bounds"]["min"]), triple(d["bounds"]["max"]),
                        grid["sheared"].get<bool>() ? ", sheared" : "");
    for (const Json& g : d["grids"]) {
        const auto number = [&](const char* key) {
            return g[key].is_null() ? std::string("none") : fmt::format("{:.5g}", g[key].get<double>());
        };
        text += fmt::format("  grid {:<13} {} channel{}, {} to {}, mean {} {}\n", g["name"].get<std::string>(),
                            g["channels"].get<int>(), g["channels"] == 1 ? "" : "s", number("min"), number("max"),
                            number("mean"), g["unit"].get<std::string>());
    }
    for (const auto& [key, value] : d["metadata"].items()) {
        if (key == "receiver_errors")
            text += fmt::format("  {}\n", printable(wordsOf(readReceiverErrors(value.get<std::string>()))));
        else if (key != "ledger" && key != "options")
            text += fmt::format("  {:<21} {}\n", key, printable(value.get<std::string>()));
    }
    for (const Json& law : d["laws"]) {
        text += fmt::format("  {} {}: {:.2e} (at most {:.2e})\n",
                            law["holds"].get<bool>() ? "holds:" : "BROKEN:", law["name"].get<std::string>(),
                            law["value"].is_null() ? NAN : law["value"].get<double>(), law["limit"].get<double>());
    }
    const Json& layers = d["layer_power"];
    if (!layers.empty()) {
        text += "  downward power by layer [W], top first:\n";
        const std::size_t step = std::max<std::size_t>(1, layers.size() / 12);
        for (std::size_t i = layers.size(); i-- > 0;) {
            if ((layers.size() - 1 - i) % step == 0)
                text += fmt::format("    z {:9.4f} m  {:.6g}\n", layers[i]["z"].get<double>(),
                                    layers[i]["power"].get<double>());
        }
    }
    return text;
}

}  // namespace

int run(const InspectArguments& arguments, Terminal& terminal) {
    terminal.progress("read", 0);
    const LightVolume volume = readVdb(arguments.volume);
    terminal.checkCancelled();
    const LightField& field = volume.field;
    const GridFrame& frame = field.frame();

    Json grids = Json::array();
    for (const GridSummary& grid : summarise(volume)) grids.push_back(grid.json());
    std::vector<LawCheck> laws = checkLaws(field);
    if (volume.second)
        for (LawCheck& law : checkLaws(*volume.second)) {
            law.name += ", second lobe";
            laws.push_back(std::move(law));
        }
    const Json ledger = checkLedgers(volume, laws);
    Json law_list = Json::array();
    bool all_hold = true;
    for (const LawCheck& law : laws) {
        all_hold = all_hold && law.holds;
        law_list.push_back({{"name", law.name}, {"value", law.value}, {"limit", law.limit}, {"holds", law.holds}});
    }
    Json layers = Json::array();
    if (field.channels().flux && volume.has_direction) {
        std::vector<double> power = layerPower(field);
        if (volume.second) {
            const std::vector<double> more = layerPower(*volume.second);
            for (std::size_t k = 0; k < power.size(); ++k) power[k] += more[k];
        }
        const glm::dvec3 middle = 0.5 * glm::dvec3(frame.min + frame.max);
        for (std::size_t k = 0; k < power.size(); ++k) {
            const double z = frame.worldFromIndex({middle.x, middle.y, frame.min.z + static_cast<double>(k)}).z;
            layers.push_back({{"z", z}, {"power", power[k]}});
        }
    }
    const Json document{{"schema", "photic-inspect-1"},
                        {"file", arguments.volume},
                        {"file_bytes", static_cast<std::int64_t>(std::filesystem::file_size(arguments.volume))},
                        {"active_voxels", field.needed().count()},
                        {"grid", toJson(frame)},
                        {"bounds", worldBounds(frame)},
                        {"reference_irradiance", volume.reference_irradiance},
                        {"grids", grids},
                        {"metadata", volume.metadata},
                        {"ledger", ledger},
                        {"laws", law_list},
                        {"holds", all_hold},
                        {"layer_power", layers}};
    if (arguments.json) {
        print(document);
    } else {
        std::fputs(describe(arguments, document).c_str(), stdout);
    }
    return arguments.strict && !all_hold ? 1 : 0;
}

}  // namespace photic::cli
