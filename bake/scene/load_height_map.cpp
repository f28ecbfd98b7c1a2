// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "bake/image/atomic_file.h"
#include "bake/image/image.h"
#include "bake/scene/load_parts.h"

namespace photic {
namespace {

constexpr int kLeastTexels = 4;
constexpr double kHighest = 1e9;  // [m]

/// The named channels of a map; of a single-channel file the only one needs no name.
std::vector<HeightMap> readMaps(const TableReader& table, const std::string& path, bool displaced) {
    const std::string extension = std::filesystem::path(path).extension().string();
    const auto is = [&](const char* lower, const char* upper) { return extension == lower || extension == upper; };
    if (is(".png", ".PNG")) {
        for (const char* key : {"channel", "displacement", "displacement_channels"})
            if (table.has(key)) table.fail(key, fmt::format("'{}' is for EXR files; a PNG holds heights alone", key));
        return {readPng16(path)};
    }
    if (is(".vdb", ".VDB"))
        table.fail(
            "file",
            fmt::format("'{}' is a volume and no height map; an index that varies in the water is given as [[index]] "
                        "with file = \"{}\", beside a surface of its own",
                        path, *table.text("file")));
    if (!is(".exr", ".EXR"))
        table.fail(
            "file",
            fmt::format(
                "'{}' is no height map that can be read; .exr and 16-bit .png can, and meshes with kind = \"mesh\"",
                path));

    std::vector<std::string> channels;
    if (const auto channel = table.text("channel")) {
        channels.push_back(*channel);
    } else if (displaced) {
        channels.emplace_back("G");
    } else {
        channels = exrChannelNames(path);
        if (channels.size() != 1)
            table.fail("file",
                       fmt::format("'{}' has the channels {}; say which holds the height, for example channel = \"{}\"",
                                   path, fmt::join(channels, ", "), channels.size() > 1 ? channels[1] : "Y"));
    }
    if (displaced) {
        const std::vector<std::string> moves =
            table.texts("displacement_channels").value_or(std::vector<std::string>{"R", "B"});
        if (moves.size() != 2)
            table.fail("displacement_channels",
                       fmt::format("'displacement_channels' has {} names; it must have 2, for x and y", moves.size()));
        channels.insert(channels.end(), moves.begin(), moves.end());
    }
    return readExrChannels(path, channels);
}

/// A map as samples in metres, row 0 at the lowest y. Refuses what is not finite, by pixel.
SampleGrid samplesOf(const HeightMap& map, const std::string& path, double scale, double level) {
    const auto width = static_cast<std::size_t>(map.width);
    std::size_t bad = 0, first = 0;
    for (std::size_t i = map.values.size(); i-- > 0;)
        if (!std::isfinite(map.values[i])) ++bad, first = i;
    if (bad > 0)
        throw Error(ErrorCode::Input,
                    fmt::format("'{}' is {} at pixel ({}, {}), counted from the top left; {} of {} pixels are not "
                                "finite: every height must be",
                                path, map.values[first], first % width, first / width, bad, map.values.size()));
    SampleGrid grid{map.width, map.height, std::vector<double>(map.values.size())};
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const float stored =
                map.values[static_cast<std::size_t>(map.height - 1 - y) * width + static_cast<std::size_t>(x)];
            grid.at(x, y) = scale * (static_cast<double>(stored) - level);
            if (!(std::fabs(grid.at(x, y)) < kHighest))
                throw Error(
                    ErrorCode::Input,
                    fmt::format("'{}' is {:.3g} at pixel ({}, {}), {:.3g} m with 'scale' and 'level'; the limit is "
                                "{:g} m",
                                path, stored, x, map.height - 1 - y, grid.at(x, y), kHighest));
        }
    return grid;
}

/// Largest step between neighbours across the edge of a periodic map over the largest one within.
double seamRatio(const SampleGrid& grid) {
    double seam = 0, inside = 0;
    for (int y = 0; y < grid.height; ++y)
        for (int x = 0; x < grid.width; ++x) {
            const double dx = std::fabs(grid.at(x, y) - grid.at((x + 1) % grid.width, y)),
                         dy = std::fabs(grid.at(x, y) - grid.at(x, (y + 1) % grid.height));
            double& to_x = x + 1 == grid.width ? seam : inside;
            to_x = std::max(to_x, dx);
            double& to_y = y + 1 == grid.height ? seam : inside;
            to_y = std::max(to_y, dy);
        }
    return inside > 0 ? seam / inside : 0;
}

}  // namespace

Interpolation loadInterpolation(const TableReader& table) {
    return table.choice("interpolation", {"bicubic", "bilinear"}).value_or(0) == 1 ? Interpolation::Bilinear
                                                                                   : Interpolation::Bicubic;
}

void warnOfFolds(const TableReader& table, const std::string& key, const HeightField& field,
                 const SplineFieldShape& shape, int width, int height, Monitor& monitor) {
    const double least = leastNormalZ(field, shape, width, height);
    if (least <= 0)
        monitor.warn(
            fmt::format("{}: the horizontal displacement folds the surface over itself (least cell area {:.3g} of the "
                        "undisplaced one); light through folds is "
                        "wrong: reduce the displacement",
                        table.where(key), least));
}

std::shared_ptr<const HeightField> loadHeightMap(const TableReader& table, const HeightFieldPlace& place,
                                                 LoadContext& context) {
    const bool displaced = table.flag("displacement").value_or(table.has("displacement_channels"));
    if (!displaced && table.has("displacement_channels")) table.exclusive({"displacement", "displacement_channels"});
    const double scale = table.number("scale", anyNumber("m")).value_or(1),
                 level = table.number("level", {}).value_or(0);
    const auto site = static_cast<SampleSite>(table.choice("texels", {"centers", "corners"}).value_or(0));
    if (site == SampleSite::Corners && place.outside == Outside::Periodic)
        table.fail("texels",
                   "texels at the corners hold both edges of the patch, which are one where it is periodic; "
                   "leave the last row and column out, and use texels = \"centers\"");
    const std::string path = context.path(*table.text("file"));

    return placed(table, "file", [&]() -> std::shared_ptr<const HeightField> {
        const std::vector<HeightMap> maps = readMaps(table, path, displaced);
        context.hashBytes(readFileBytes(path));
        const HeightMap& heights = maps.front();
        if (heights.width < kLeastTexels || heights.height < kLeastTexels)
            throw Error(ErrorCode::Input, fmt::format("'{}' is {} x {} pixels; a height map needs {} a side", path,
                                                      heights.width, heights.height, kLeastTexels));
        if (std::any_of(maps.begin(), maps.end(), [](const HeightMap& map) { return map.half; }))
            context.monitor.warn(
                fmt::format("{}: '{}' is stored as half floats: slopes lose about 0.3 %, curvature 3 % and, with an "
                            "offset, far more; save 32-bit floats",
                            table.where("file"), path));

        std::set<std::string> flaws;
        for (const HeightMap& map : maps) flaws.insert(map.flaws.begin(), map.flaws.end());
        for (const std::string& flaw : flaws)
            context.monitor.warn(fmt::format("{}: '{}' {}", table.where("file"), path, flaw));

        SplineFieldShape shape;
        shape.size = place.size, shape.center = place.center, shape.interpolation = loadInterpolation(table);
        shape.site = site;
        shape.bounded = place.outside != Outside::Periodic;
        shape.boundary = shape.bounded ? GridBoundary::Free : GridBoundary::Periodic;
        const SampleGrid grid = samplesOf(heights, path, scale, level);
        if (!shape.bounded && seamRatio(grid) > 4)
            context.monitor.warn(
                fmt::format("{}: '{}' does not join at its edges (steps {:.1f} times those inside); outside = "
                            "\"periodic\" wants a map that repeats",
                            table.where("outside"), path, seamRatio(grid)));
        if (!displaced) return makeSplineField(shape, grid);
        // A displacement is a length as it is: `level` is of heights alone.
        auto field = makeSplineField(
            shape, grid, std::array{samplesOf(maps[1], path, scale, 0), samplesOf(maps[2], path, scale, 0)});
        warnOfFolds(table, "file", *field, shape, grid.width, grid.height, context.monitor);
        return field;
    });
}

}  // namespace photic
