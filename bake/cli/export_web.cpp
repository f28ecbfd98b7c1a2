// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/export_web.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "bake/cli/another_scene.h"
#include "bake/cli/bake_plan.h"
#include "bake/report/error.h"
#include "bake/scene/load_toml.h"

namespace photic::cli {
namespace {

constexpr const char* kPage = "index.html";
constexpr const char* kScript = "photic.js";
constexpr const char* kScene = "scene.js";

/// All browsers with WebGL 2 take textures of so many texels a side; most take 2048.
constexpr int kEveryBrowser = 256;
/// A page of more takes long to open over a network.
constexpr double kLargePage = 64e6;

}  // namespace

std::string WebExport::frameFiles(const std::string& folder) {
    return (std::filesystem::path(folder) / "frame.####.js").string();
}

std::string WebExport::pathOf(const char* name) const { return (std::filesystem::path(folder_) / name).string(); }

std::string WebExport::scriptPath() const {
    if (!shared_script_) return pathOf(kScript);
    // "pages/glass/" and "." have a folder that they are in, too.
    const std::filesystem::path folder = (std::filesystem::absolute(folder_) / "x").lexically_normal().parent_path();
    return (folder.parent_path() / kScript).string();
}

WebExport::WebExport(const ExportArguments& arguments, OutputSet& outputs)
    : folder_(arguments.web), scene_file_(arguments.scene), shared_script_(arguments.shared_script) {
    if (scene_file_.empty())
        throw Error(ErrorCode::Usage,
                    "shows receivers, water and a camera, which the volume does not hold; say the scene that it was "
                    "baked from with --scene",
                    "--web");
    for (const std::string& file : {scriptPath(), pathOf(kScene), pathOf(kPage)})
        outputs.writes("a file of the page", file);
}

void WebExport::warnOfSize(const DenseTexels& texels, Terminal& terminal) const {
    const int side = std::max({texels.size.x, texels.size.y, texels.size.z});
    if (side <= kEveryBrowser) return;
    terminal.warn(
        fmt::format("the light is {} x {} x {} texels; every browser takes {} a side, many phones no more: "
                    "export with --budget, or bake with voxels {:.2g} times as wide",
                    texels.size.x, texels.size.y, texels.size.z, kEveryBrowser, 1.01 * side / kEveryBrowser));
}

DenseWritten WebExport::writeFrame(OutputSet& outputs, const std::string& output, const Shown& shown,
                                   Terminal& terminal) {
    const LightVolume& volume = shown.volume;
    const int frame = frameOf(volume).value_or(0);
    const Scene scene = loadScene(scene_file_, frame, terminal);
    warnOfAnotherScene(scene, volume, shown.path, terminal);
    const DenseTexels texels = denseTexels(volume, shown.box);
    if (scene_script_.empty()) {
        warnOfSize(texels, terminal);
        scene_script_ = webSceneScript({scene, loadFrameRate(scene_file_), frames_}, volume, texels);
        bytes_ += scene_script_.size();
    }
    terminal.checkCancelled();
    const std::string script = webFrameScript(frame, texels, scene);
    bytes_ += script.size();
    outputs.write(output, script);
    return {{output}, texels.size, texels.clamped};
}

void WebExport::finish(OutputSet& outputs, Terminal& terminal) {
    outputs.write(scriptPath(), webPageScript());
    outputs.write(pathOf(kScene), scene_script_);
    outputs.write(pathOf(kPage), webPageHtml(shared_script_ ? "../photic.js" : "photic.js"));
    outputs.commit();
    terminal.say(fmt::format("{}: open it in a browser; the page is {:.2f} MB", pathOf(kPage),
                             static_cast<double>(bytes_) * 1e-6));
    if (static_cast<double>(bytes_) > kLargePage) {
        terminal.warn(
            fmt::format("a page of {:.0f} MB takes long to open over a network; a bake with --where receivers "
                        "is a tenth of the size, and --budget, wider voxels or fewer frames make it smaller",
                        static_cast<double>(bytes_) * 1e-6));
    }
}

}  // namespace photic::cli
