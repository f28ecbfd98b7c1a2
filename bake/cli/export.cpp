// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <set>

#include "bake/cli/bake_plan.h"
#include "bake/cli/verbs.h"
#include "bake/file/slice_atlas.h"
#include "bake/report/error.h"

namespace photic::cli {
namespace {

/// Far below half a voxel, over any index that a grid holds.
constexpr double kSamePlace = 1e-9;

bool sameGrid(const GridFrame& a, const GridFrame& b) {
    double apart = 0;
    const double size = std::cbrt(a.voxelVolume());
    for (int i = 0; i < 3; ++i) {
        apart = std::max(apart, std::fabs(a.origin_world[i] - b.origin_world[i]));
        for (int j = 0; j < 3; ++j)
            apart = std::max(apart, std::fabs(a.world_from_index[i][j] - b.world_from_index[i][j]));
    }
    return apart <= kSamePlace * size;
}

int frameOf(const LightVolume& volume, const std::string& path) {
    const auto found = volume.metadata.find("frame");
    if (found == volume.metadata.end()) {
        throw Error(ErrorCode::Input, "has no photic:frame; a sequence is made of what photic bake --frames wrote",
                    path);
    }
    return std::stoi(found->second);
}

/// The box that holds the light of all volumes. One volume needs none: its atlas finds it.
std::optional<AtlasBox> boxOfAll(const std::vector<std::string>& volumes, Terminal& terminal) {
    std::optional<AtlasBox> box;
    std::optional<GridFrame> grid;
    for (std::size_t i = 0; volumes.size() > 1 && i < volumes.size(); ++i) {
        terminal.progress("read", static_cast<double>(i) / static_cast<double>(volumes.size()));
        const LightVolume volume = readVdb(volumes[i]);
        terminal.checkCancelled();
        if (grid && !sameGrid(*grid, volume.field.frame())) {
            throw Error(ErrorCode::Input,
                        fmt::format("its voxels are not those of '{}'; frames of one sequence share a grid: bake them "
                                    "with one [domain]",
                                    volumes[0]),
                        volumes[i]);
        }
        grid = volume.field.frame();
        box = together(box, litBox(volume));
    }
    return box;
}

}  // namespace

int run(const ExportArguments& arguments, Terminal& terminal) {
    if (std::filesystem::path(arguments.output).extension() != ".exr") {
        throw Error(ErrorCode::Usage,
                    "output '" + arguments.output + "' does not end in .exr, the one format that is built", "-o");
    }
    checkWritable(arguments.output);
    const bool sequence = arguments.volumes.size() > 1 ||
                          std::filesystem::path(arguments.output).filename().string().find('#') != std::string::npos;
    const std::optional<AtlasBox> box = boxOfAll(arguments.volumes, terminal);
    std::set<std::string> written;
    for (const std::string& path : arguments.volumes) {
        terminal.progress("write", static_cast<double>(written.size()) / static_cast<double>(arguments.volumes.size()));
        const LightVolume volume = readVdb(path);
        terminal.checkCancelled();
        const std::string output = sequence ? withFrame(arguments.output, frameOf(volume, path)) : arguments.output;
        if (!written.insert(output).second) {
            throw Error(ErrorCode::Input, "holds the same frame as a volume before it; both would be " + output, path);
        }
        writeSliceAtlas(output, volume, box);
        terminal.say(output + ": atlas and its .json written");
    }
    terminal.progress("write", 1);
    return 0;
}

}  // namespace photic::cli
