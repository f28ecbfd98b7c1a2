// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/export_usd.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "bake/cli/bake_plan.h"
#include "bake/cli/json.h"
#include "bake/file/output_set.h"
#include "bake/file/usda.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"

namespace photic::cli {

namespace fs = std::filesystem;

int exportUsd(const ExportArguments& arguments, Terminal& terminal) {
    OutputSet outputs;
    outputs.reads("the volume", arguments.volumes);
    if (!arguments.scene.empty()) outputs.reads("the scene", arguments.scene);
    outputs.writes("the output", arguments.output);
    constexpr double kUsual = 24;
    const double rate = arguments.scene.empty() ? kUsual : loadFrameRate(arguments.scene);
    const fs::path folder = fs::absolute(arguments.output).parent_path();
    std::vector<UsdFrame> frames;
    std::optional<LightVolume> first;
    for (const std::string& path : arguments.volumes) {
        LightVolume volume = readVdb(path);
        terminal.checkCancelled();
        const std::optional<int> frame = frameOf(volume);
        if (arguments.volumes.size() > 1 && !frame)
            throw Error(ErrorCode::Input, "has no photic:frame; a sequence is made of what photic bake --frames wrote",
                        path);
        // USD takes a path that begins with ./ as seen from the layer.
        const std::string relative =
            fs::absolute(path).lexically_normal().lexically_relative(folder.lexically_normal());
        frames.push_back({frame.value_or(0), relative.starts_with("..") ? relative : "./" + relative});
        if (!first) first.emplace(std::move(volume));
    }
    std::sort(frames.begin(), frames.end(), [](const UsdFrame& a, const UsdFrame& b) { return a.frame < b.frame; });
    for (std::size_t i = 1; i < frames.size(); ++i) {
        if (frames[i].frame == frames[i - 1].frame)
            throw Error(ErrorCode::Input,
                        fmt::format("holds the same frame as '{}', {}", frames[i - 1].file, frames[i].frame),
                        frames[i].file);
    }
    const std::string text = usdaLayer(fs::path(arguments.output).stem().string(), *first, frames, rate);
    outputs.write(arguments.output, text);
    outputs.commit();
    terminal.say(fmt::format("{}: refers to {} volumes, which stay where they are", arguments.output, frames.size()));
    if (arguments.json) {
        Json list = Json::array();
        list.push_back({{"volume", arguments.volumes.front()},
                        {"files", Json::array({{{"path", arguments.output}, {"bytes", text.size()}}})},
                        {"bytes", text.size()},
                        {"voxels", 0},
                        {"size", toJson(first->field.frame().size())},
                        {"cut_values", 0},
                        {"budget", nullptr}});
        print({{"schema", "photic-export-1"}, {"format", "usda"}, {"precision", "half"}, {"frames", list}});
    }
    return 0;
}

}  // namespace photic::cli
