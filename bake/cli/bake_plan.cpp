// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/bake_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <vector>

#include "bake/methods/catalogue.h"
#include "bake/report/error.h"
#include "bake/report/printable.h"
#include "bake/scene/load_toml.h"
#include "bake/scene/setting_names.h"

namespace photic::cli {

namespace {

namespace fs = std::filesystem;

std::string didYouMean(const std::string& given, const std::vector<std::string>& known) {
    const std::string near = nearestName(given, known);
    return fmt::format("{}known: {}", near.empty() ? "" : "did you mean '" + near + "'? ", fmt::join(known, ", "));
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
        throw Error(ErrorCode::Usage, "write METHOD.OPTION=VALUE; photic methods lists them", place);
    }
    const std::string method_name = text.substr(0, dot), option = text.substr(dot + 1, equals - dot - 1);
    const Method* method = findMethod(method_name);
    if (!method)
        throw Error(ErrorCode::Usage,
                    fmt::format("no method '{}'; {}", method_name, didYouMean(method_name, catalogueNames())), place);
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
    grids = kNoGrids;
    for (const std::string& name : names) {
        if (!wantGrid(grids, name))
            throw Error(ErrorCode::Usage, fmt::format("no grid '{}'; {}", name, didYouMean(name, gridNames())),
                        "--grids");
    }
}

/// The place among `names` of a word that the command line has checked.
std::size_t placeOf(const std::string& word, const std::vector<std::string>& names) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), word) - names.begin());
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

/// "2%" or "0.02".
double parseShare(const std::string& text, const char* option) {
    double value = 0;
    int used = 0;
    const bool read = std::sscanf(text.c_str(), "%lf%n", &value, &used) == 1;
    const std::string unit = read ? text.substr(static_cast<std::size_t>(used)) : "?";
    if (unit == "%") value /= 100;
    if (!read || !(unit.empty() || unit == "%") || !(value > 0 && value <= 1))
        throw Error(ErrorCode::Usage, fmt::format("'{}' is no share; write 2% or 0.02", printable(text)), option);
    return value;
}

}  // namespace

void applySettings(const BakeArguments& arguments, Scene& scene) {
    BakeSettings& bake = scene.bake;
    if (arguments.method) {
        if (*arguments.method != "auto" && !findMethod(*arguments.method)) {
            auto names = catalogueNames();
            names.insert(names.begin(), "auto");
            throw Error(ErrorCode::Usage,
                        fmt::format("no method '{}'; {}", *arguments.method, didYouMean(*arguments.method, names)),
                        "--method");
        }
        bake.method = *arguments.method;
    }
    if (!arguments.error.empty()) bake.error = parseShare(arguments.error, "--error");
    if (arguments.voxel_size || arguments.resolution) {
        if (!arguments.error.empty())
            throw Error(ErrorCode::Usage, "--error chooses the voxels; give it or a voxel size", "--error");
        bake.error.reset();
    }
    // Frames of a sequence share their voxels, and so do tiles.
    if (bake.error || arguments.voxel_size || arguments.resolution || arguments.frames || arguments.tile ||
        arguments.measure == "no")
        bake.sizes_itself = false;
    if (bake.error && arguments.tile)
        throw Error(ErrorCode::Usage,
                    "an error chooses the voxels by the whole volume, and tiles share theirs; bake the volume so once, "
                    "and its tiles with the --voxel-size that it comes to",
                    arguments.error.empty() ? "error" : "--error");
    if (bake.error && arguments.frames)
        throw Error(ErrorCode::Usage,
                    "an error chooses the voxels of each frame for itself, and frames of a sequence share theirs; bake "
                    "one frame so, and the sequence with the --voxel-size that it comes to",
                    arguments.error.empty() ? "error" : "--error");
    applyVoxelSize(arguments, scene.domain);
    if (arguments.where) bake.where = static_cast<Where>(placeOf(*arguments.where, kWhereNames));
    if (arguments.paths) bake.paths = static_cast<Paths>(placeOf(*arguments.paths, kPathsNames));
    if (arguments.quadrature) bake.quadrature = *arguments.quadrature;
    if (arguments.lobes) bake.lobes = *arguments.lobes;
    if (arguments.tolerance) {
        if (!(*arguments.tolerance > 0) || !std::isfinite(*arguments.tolerance)) {
            throw Error(ErrorCode::Usage, fmt::format("tolerance {} voxels; it must be above 0", *arguments.tolerance),
                        "--tolerance");
        }
        bake.tolerance = *arguments.tolerance;
    }
    if (arguments.prefilter) bake.prefilter = *arguments.prefilter;
    if (!arguments.grids.empty()) applyGrids(arguments.grids, bake.grids);
    for (const std::string& text : arguments.set) applySet(text, scene);
    checkMethodTables(scene);
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
    const std::string of_frame = arguments.frames ? withFrame(path.string(), frame) : path.string();
    return arguments.tile ? withTile(of_frame, *arguments.tile) : of_frame;
}

std::string withTile(const std::string& given, const Tile& tile) {
    const fs::path path(given);
    const std::size_t digits = std::to_string(tile.count).size();
    const std::string name = fmt::format("{}.tile{:0{}}of{}{}", path.stem().string(), tile.index, digits, tile.count,
                                         path.extension().string());
    return (path.parent_path() / name).string();
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

std::optional<int> frameOf(const LightVolume& volume) {
    const auto found = volume.metadata.find("frame");
    if (found == volume.metadata.end()) return {};
    int frame = 0;
    if (!parseNumber(found->second, frame)) return {};
    return frame;
}

}  // namespace photic::cli
