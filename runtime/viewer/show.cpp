// SPDX-License-Identifier: Apache-2.0
#include "runtime/viewer/show.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <glm/geometric.hpp>

#include "bake/report/error.h"
#include "bake/report/monitor.h"
#include "bake/scene/load_toml.h"
#include "photic/runtime_vdb.h"

namespace photic::viewer {
namespace {

/// Warnings of loading go to stderr.
class Messages final : public Monitor {
public:
    void warn(const std::string& message) override { std::fprintf(stderr, "photic view: %s\n", message.c_str()); }
};

std::string frameOf(std::string path, int frame) {
    const std::size_t at = path.find("####");
    return at == std::string::npos ? path : path.replace(at, 4, fmt::format("{:04d}", frame));
}

runtime::Volume loadOne(const std::string& path) {
    const auto loaded =
        std::filesystem::path(path).extension() == ".vdb" ? runtime::loadVdb(path) : runtime::loadVolume(path);
    if (!loaded) throw Error(ErrorCode::Input, loaded.error().message, path);
    return *loaded;
}

void require(const runtime::Status& status, const char* what) {
    if (!status) throwFailure(what, status.error().message);
}

}  // namespace

void throwFailure(const std::string& where, const std::string& message) {
    throw Error(ErrorCode::Failed, message, where);
}

Show::Show(const Options& options, Renderer& renderer) : options_(options), renderer_(renderer) {
    setFrame(options.first_frame);
    firstPicture();
}

void Show::setFrame(int frame) {
    if (frame == frame_) return;
    const bool first = frame_ < 0;
    std::vector<runtime::Volume> volumes;
    for (std::size_t i = 0; i < options_.volumes.size(); ++i) {
        const std::string& path = options_.volumes[i];
        if (!first && path.find("####") == std::string::npos) continue;
        volumes.push_back(loadOne(frameOf(path, frame)));
        require(renderer_.setVolume(static_cast<int>(i), volumes.back()), "volume");
    }
    if (!options_.scene.empty()) {
        Messages messages;
        stage_ = stageOf(loadScene(options_.scene, frame, messages));
    } else if (first) {
        stage_ = stageOf(volumes.front());
    }
    require(renderer_.setStage(stage_), "stage");
    frame_ = frame;
}

void Show::firstPicture() {
    const Options& o = options_;
    picture.camera = {o.eye.value_or(stage_.eye), o.target.value_or(stage_.target),
                      o.field_of_view_deg.value_or(stage_.field_of_view_deg)};
    picture.right = o.right.value_or(!o.volumes.empty() ? Source::BakedA : Source::CausticMap);
    picture.left = o.left.value_or(o.volumes.size() > 1 ? Source::BakedB : picture.right);
    picture.split = o.split.value_or(o.left || o.volumes.size() > 1 ? 0.5f : 0);
    for (const Source source : {picture.left, picture.right}) {
        if (!renderer_.has(source)) {
            throw Error(ErrorCode::Usage, fmt::format("'{}' needs {}", kSourceNames[static_cast<int>(source)],
                                                      source == Source::BakedA || source == Source::BakedB
                                                          ? "a volume; give its file"
                                                          : "a scene (.toml) with a sun and a height field of water"));
        }
    }
    picture.exposure = o.exposure, picture.ambient = o.ambient, picture.tile_size = o.tile_size;
    picture.surface = o.surface;
    picture.scattering = o.scattering ? glm::vec3(*o.scattering) : stage_.scattering;
    picture.anisotropy = o.anisotropy.value_or(stage_.anisotropy);
    for (int axis = 0; axis < 3; ++axis) picture.extinction[axis] = stage_.light.extinction[axis];
    if (o.ball) {
        picture.ball_centre = glm::vec3(*o.ball), picture.ball_radius = o.ball->w;
    } else {
        picture.ball_centre = glm::vec3(0.5f * (stage_.min + stage_.max));
    }
}

}  // namespace photic::viewer
