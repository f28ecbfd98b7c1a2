// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/bake_plan.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <string_view>

#include "bake/cli/version.h"
#include "bake/picture/receiver_picture.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"
#include "bake/threads/parallel_for.h"

namespace photic::cli {

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kGridNames{"irradiance", "direction", "caustic", "arrival_time", "density"};

std::vector<std::string> chosenGrids(const GridSet& grids) {
    std::vector<std::string> names;
    const bool chosen[] = {grids.irradiance, grids.direction, grids.caustic, grids.arrival_time, grids.density};
    for (std::size_t i = 0; i < kGridNames.size(); ++i) {
        if (chosen[i]) names.push_back(kGridNames[i]);
    }
    return names;
}

std::string didYouMean(const std::string& given, const std::vector<std::string>& known) {
    const std::string near = nearestName(given, known);
    return fmt::format("{}known: {}", near.empty() ? "" : "did you mean '" + near + "'? ", fmt::join(known, ", "));
}

const Method* findMethod(const std::string& name) {
    for (const Method& method : methodCatalogue()) {
        if (method.name == name) return &method;
    }
    return nullptr;
}

std::vector<std::string> methodNames() {
    std::vector<std::string> names;
    for (const Method& method : methodCatalogue()) names.push_back(method.name);
    return names;
}

template <class Number>
bool parseNumber(const std::string& text, Number& value) {
    const auto end = text.data() + text.size();
    const auto result = std::from_chars(text.data(), end, value);
    return result.ec == std::errc() && result.ptr == end;
}

OptionValue parseValue(const OptionSpec& spec, const std::string& text, const std::string& place) {
    bool flag = false;
    std::int64_t integer = 0;
    double number = 0;
    switch (spec.type) {
        case OptionType::Flag:
            flag = text == "true" || text == "on" || text == "1";
            if (flag || text == "false" || text == "off" || text == "0") return flag;
            throw Error(ErrorCode::Usage, fmt::format("'{}' is no switch; use true or false", text), place);
        case OptionType::Integer:
            if (parseNumber(text, integer)) return integer;
            throw Error(ErrorCode::Usage,
                        fmt::format("'{}' is no whole number; the range is {} to {}", text, spec.min, spec.max), place);
        case OptionType::Number:
            if (parseNumber(text, number)) return number;
            throw Error(ErrorCode::Usage,
                        fmt::format("'{}' is no number; the range is {} to {}", text, spec.min, spec.max), place);
        case OptionType::Choice:
            break;
    }
    return text;
}

/// --set METHOD.OPTION=VALUE
void applySet(const std::string& text, Scene& scene) {
    const std::string place = "--set " + text;
    const auto equals = text.find('='), dot = text.find('.');
    if (equals == std::string::npos || dot == std::string::npos || dot > equals) {
        throw Error(ErrorCode::Usage, "write METHOD.OPTION=VALUE, for instance --set beams.mesh=512", place);
    }
    const std::string method_name = text.substr(0, dot), option = text.substr(dot + 1, equals - dot - 1);
    const Method* method = findMethod(method_name);
    if (!method)
        throw Error(ErrorCode::Usage,
                    fmt::format("no method '{}'; {}", method_name, didYouMean(method_name, methodNames())), place);
    std::vector<std::string> names;
    for (const OptionSpec& spec : method->options) {
        if (spec.name == option) {
            scene.bake.method_options[method_name][option] = {parseValue(spec, text.substr(equals + 1), place),
                                                              "--set"};
            return;
        }
        names.push_back(spec.name);
    }
    throw Error(ErrorCode::Usage,
                fmt::format("method '{}' has no option '{}'; {}", method_name, option, didYouMean(option, names)),
                place);
}

void applyGrids(const std::vector<std::string>& names, GridSet& grids) {
    grids = {false, false, false, false, false};
    bool* const targets[] = {&grids.irradiance, &grids.direction, &grids.caustic, &grids.arrival_time, &grids.density};
    for (const std::string& name : names) {
        const auto found = std::find(kGridNames.begin(), kGridNames.end(), name);
        if (found == kGridNames.end())
            throw Error(ErrorCode::Usage, fmt::format("no grid '{}'; {}", name, didYouMean(name, kGridNames)),
                        "--grids");
        *targets[found - kGridNames.begin()] = true;
    }
}

void applyVoxelSize(const BakeArguments& arguments, Domain& domain) {
    double size = domain.voxel_size;
    if (arguments.voxel_size && arguments.resolution) {
        throw Error(ErrorCode::Usage, "--voxel-size and --resolution say the same thing twice; give one");
    }
    if (arguments.voxel_size) {
        size = *arguments.voxel_size;
        if (!(size > 0) || !std::isfinite(size)) {
            throw Error(ErrorCode::Usage, fmt::format("voxel size {} m; it must be above 0", size), "--voxel-size");
        }
    }
    if (arguments.resolution) {
        if (*arguments.resolution < 1) {
            throw Error(ErrorCode::Usage, fmt::format("resolution {}; it must be 1 or more", *arguments.resolution),
                        "--resolution");
        }
        const glm::dvec3 extent = domain.max - domain.min;
        size = std::max({extent.x, extent.y, extent.z}) / *arguments.resolution;
    }
    // Layers keep their proportion to the voxels.
    if (domain.voxel_size > 0) domain.layer_height *= size / domain.voxel_size;
    domain.voxel_size = size;
}

std::uint64_t fnv1a(std::string_view text, std::uint64_t hash) {
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
    return hash;
}

/// Seconds of a method on one thread, without the write, fitted to bakes of the pool at 64, 128 and 256 voxels a side
/// on a 2.6 GHz server core: within a factor of two there, perhaps three elsewhere.
double methodSeconds(const Scene& scene, const Method& method, double needed_voxels, int channels,
                     const glm::ivec3& size) {
    if (method.name == "photons") {
        double count = 0;
        for (const OptionSpec& spec : method.options) {
            if (spec.name != "count") continue;
            OptionValue value = spec.default_value;
            if (const auto given = scene.bake.method_options.find(method.name);
                given != scene.bake.method_options.end()) {
                if (const auto own = given->second.find("count"); own != given->second.end()) value = own->second.value;
            }
            if (const auto* integer = std::get_if<std::int64_t>(&value)) count = static_cast<double>(*integer);
            if (const auto* number = std::get_if<double>(&value)) count = *number;
        }
        return count * (3.5e-7 + 1e-8 * size.z);
    }
    if (method.name == "wave") {
        // Cells of the band times steps: the band is some 20 cells thick, and a step half a cell.
        double cells = 1;
        if (const auto given = scene.bake.method_options.find("wave"); given != scene.bake.method_options.end())
            if (const auto own = given->second.find("cells"); own != given->second.end())
                if (const auto* integer = std::get_if<std::int64_t>(&own->second.value))
                    cells = static_cast<double>(*integer);
        return 0.1 + needed_voxels * cells * cells * cells * 1.1e-6;
    }
    return 0.15 + needed_voxels * channels * (6e-9 + 7e-9 * std::max(1, scene.bake.quadrature));
}

// The program itself, its libraries and threads [bytes].
constexpr double kProgramBytes = 6e7;

}  // namespace

void applySettings(const BakeArguments& arguments, Scene& scene) {
    BakeSettings& bake = scene.bake;
    if (arguments.method) {
        if (*arguments.method != "auto" && !findMethod(*arguments.method)) {
            auto names = methodNames();
            names.insert(names.begin(), "auto");
            throw Error(ErrorCode::Usage,
                        fmt::format("no method '{}'; {}", *arguments.method, didYouMean(*arguments.method, names)),
                        "--method");
        }
        bake.method = *arguments.method;
    }
    applyVoxelSize(arguments, scene.domain);
    if (arguments.where) {
        bake.where = *arguments.where == "receivers" ? Where::Receivers
                     : *arguments.where == "media"   ? Where::Media
                                                     : Where::Everywhere;
    }
    if (arguments.paths) bake.paths = *arguments.paths == "all" ? Paths::All : Paths::Caustic;
    if (arguments.quadrature) bake.quadrature = *arguments.quadrature;
    if (arguments.tolerance) {
        if (!(*arguments.tolerance > 0) || !std::isfinite(*arguments.tolerance)) {
            throw Error(ErrorCode::Usage, fmt::format("tolerance {} voxels; it must be above 0", *arguments.tolerance),
                        "--tolerance");
        }
        bake.tolerance = *arguments.tolerance;
    }
    if (arguments.prefilter) bake.prefilter = *arguments.prefilter;
    if (!arguments.grids.empty()) {
        applyGrids(arguments.grids, bake.grids);
    } else if (scene.medium.present()) {
        bake.grids.density = true;
    }
    for (const std::string& text : arguments.set) applySet(text, scene);
    for (const auto& [name, options] : bake.method_options) {
        const Method* method = findMethod(name);
        if (!method) {
            const std::string place = options.empty() ? scene.file : options.begin()->second.where;
            throw Error(ErrorCode::Input,
                        fmt::format("[bake.{}] names no method; {}", name, didYouMean(name, methodNames())), place);
        }
        validateOptions(*method, options);
    }
}

Json settingsJson(const Scene& scene, const Method& method, const VdbOptions& file) {
    const BakeSettings& bake = scene.bake;
    Json options = Json::object();
    const auto given = bake.method_options.find(method.name);
    for (const OptionSpec& spec : method.options) {
        const GivenOption* own = nullptr;
        if (given != bake.method_options.end()) {
            const auto found = given->second.find(spec.name);
            if (found != given->second.end()) own = &found->second;
        }
        options[spec.name] = toJson(own ? own->value : spec.default_value);
    }
    constexpr const char* kWhere[] = {"everywhere", "receivers", "media"};
    constexpr const char* kCompression[] = {"none", "mask", "blosc", "zip"};
    return {{"method", method.name},
            {"voxel_size", scene.domain.voxel_size},
            {"layer_height", scene.domain.layer_height > 0 ? scene.domain.layer_height : scene.domain.voxel_size},
            {"grids", chosenGrids(bake.grids)},
            {"where", kWhere[static_cast<int>(bake.where)]},
            {"band", bake.band},
            {"paths", bake.paths == Paths::All ? "all" : "caustic"},
            {"quadrature", bake.quadrature},
            {"tolerance", bake.tolerance},
            {"prefilter", bake.prefilter},
            {"half", file.half},
            {"compression", kCompression[static_cast<int>(file.compression)]},
            {"options", options}};
}

std::string inputHash(const Scene& scene, const Json& settings) {
    std::uint64_t hash = fnv1a(dump(settings), 0xcbf29ce484222325ULL);
    hash = fnv1a(kVersion, hash);
    hash = fnv1a(fmt::format("{:016x} {}", scene.hash, scene.frame), hash);
    return fmt::format("{:016x}", hash);
}

std::string outputPath(const BakeArguments& arguments, int frame) {
    fs::path path =
        arguments.output.empty() ? fs::path(arguments.scene).stem().concat(".vdb") : fs::path(arguments.output);
    if (path.extension() != ".vdb") {
        throw Error(
            ErrorCode::Usage,
            fmt::format("output '{}' does not end in .vdb; other formats are written by photic export", path.string()),
            "-o");
    }
    return arguments.frames ? withFrame(path.string(), frame) : path.string();
}

std::string withFrame(const std::string& given, int frame) {
    const fs::path path(given);
    std::string name = path.filename().string();
    const auto begin = name.find('#');
    if (begin != std::string::npos) {
        const auto end = std::min(name.find_first_not_of('#', begin), name.size());
        name.replace(begin, end - begin, fmt::format("{:0{}d}", frame, end - begin));
    } else {
        name = fmt::format("{}.{:04d}{}", path.stem().string(), frame, path.extension().string());
    }
    return (path.parent_path() / name).string();
}

BakeEstimate estimateBake(const Scene& scene, const Method& method, const GridFrame& frame, const NeededVoxels* needed,
                          const VdbOptions& file) {
    BakeEstimate estimate;
    estimate.frame = frame;
    const glm::dvec3 box_leaves = (glm::dvec3(frame.size()) + 7.0) / 8.0 + 1.0;
    const double table = box_leaves.x * box_leaves.y * box_leaves.z;
    estimate.needed_voxels = needed ? needed->count() : frame.voxelCount();
    const double leaves = needed ? needed->leafCount() : table;
    const GridSet& grids = scene.bake.grids;
    const int colours = scene.coloured() ? 3 : 1;
    const int channels = colours + (grids.direction ? 3 : 0);
    const int scalars = int(grids.caustic) + int(grids.density) + int(grids.arrival_time);
    const double values = static_cast<double>(estimate.needed_voxels) * (channels + scalars);
    // Field and grids both exist while the file is written; a leaf's place in the tables takes about 100 bytes.
    const double field = leaves * 512 * 4 * (channels + scalars);
    estimate.file_bytes = static_cast<std::int64_t>(std::min(values * (file.half ? 2 : 4), 4e18));
    estimate.memory_bytes = static_cast<std::int64_t>(std::min(
        kProgramBytes + 2 * field + table * 4 + leaves * 100 + static_cast<double>(estimate.file_bytes), 8e18));
    estimate.leaves = static_cast<std::int64_t>(std::min(leaves, 8e18));
    estimate.seconds =
        methodSeconds(scene, method, static_cast<double>(estimate.needed_voxels), channels, frame.size());
    // The write is on one thread: about 60 million values a second with the default compression.
    estimate.seconds = estimate.seconds / threadCount() + values / 6e7;
    return estimate;
}

std::int64_t machineMemory() {
    std::int64_t bytes = static_cast<std::int64_t>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGE_SIZE);
    std::int64_t limit = 0;
    std::ifstream container("/sys/fs/cgroup/memory.max");  // "max" when there is no limit
    if (container >> limit && limit > 0) bytes = std::min(bytes, limit);
    return bytes;
}

std::vector<std::string> receiversAtTheEdge(const Scene& scene, const GridFrame& frame) {
    std::vector<std::string> names;
    for (const std::string& name : planarReceivers(scene)) {
        PictureFrame receiver;
        try {
            receiver = receiverFrame(scene, name, 1);
        } catch (const Error&) {
            continue;  // outside of the domain altogether
        }
        const glm::dvec3 index = frame.indexFromWorld(receiver.origin + 0.5 * (receiver.across + receiver.up));
        // Along the axis that the receiver faces, both neighbours of a look-up must be voxels of the grid.
        const glm::dvec3 facing = glm::abs(frame.indexNormal(receiver.normal));
        const int axis = facing.x > facing.y && facing.x > facing.z ? 0 : facing.y > facing.z ? 1 : 2;
        if (index[axis] < frame.min[axis] || index[axis] > frame.max[axis]) names.push_back(name);
    }
    return names;
}

void checkMemory(const BakeEstimate& estimate, std::int64_t max_memory_bytes) {
    const std::int64_t limit = max_memory_bytes > 0 ? max_memory_bytes : machineMemory();
    if (estimate.memory_bytes <= limit) return;
    throw Error(
        ErrorCode::Failed,
        fmt::format(
            "the bake would take about {:.3g} GB for {:.4g} voxels, more than the {} of {:.3g} GB; use a larger "
            "voxel_size, where = \"receivers\" or fewer grids",
            static_cast<double>(estimate.memory_bytes) * 1e-9, static_cast<double>(estimate.needed_voxels),
            max_memory_bytes > 0 ? "--max-memory" : "machine's memory", static_cast<double>(limit) * 1e-9));
}

}  // namespace photic::cli
