// SPDX-License-Identifier: Apache-2.0
#include "runtime/viewer/show.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "bake/image/atomic_file.h"
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

/// A volume may be viewed with a scene that has changed since; what cannot be of one bake is worth a word.
void warnOfAnotherScene(const runtime::Volume& volume, const std::string& path, const Stage& stage) {
    const auto warn = [&](const std::string& why) {
        std::fprintf(stderr, "photic view: '%s' seems to be of another scene: %s\n", path.c_str(), why.c_str());
    };
    const auto light = static_cast<float>(volume.metadata().reference_irradiance);
    if (std::abs(light - stage.reference) > 1e-5f * stage.reference)
        warn(fmt::format("its light has {:.6g} W/m2, the scene's {:.6g}", light, stage.reference));
    // The box of a grid that leans with the light reaches out of the domain's at its top and bottom.
    const runtime::Vec3 first = volume.voxelCentre(0, 0, 0), above = volume.voxelCentre(0, 0, 1);
    if (first.x != above.x || first.y != above.y || volume.litVoxelCount() == 0) return;
    const runtime::VoxelBox box = volume.litVoxels();
    for (int corner = 0; corner < 8; ++corner) {
        const auto pick = [&](int axis) { return (corner >> axis & 1) != 0 ? box.max[axis] : box.min[axis]; };
        const runtime::Vec3 p = volume.voxelCentre(pick(0), pick(1), pick(2));
        // A few voxels are all that a bake goes beyond its domain.
        const glm::vec3 room = 0.1f * (stage.max - stage.min), place(p.x, p.y, p.z);
        if (glm::all(glm::greaterThan(place, stage.min - room)) && glm::all(glm::lessThan(place, stage.max + room)))
            continue;
        warn(fmt::format("it holds light at ({:.3g}, {:.3g}, {:.3g}), outside of the scene's domain", p.x, p.y, p.z));
        return;
    }
}

volatile std::sig_atomic_t signalled = 0;

}  // namespace

void watchSignals() {
    struct sigaction action {};
    action.sa_handler = [](int) { signalled = 1; };
    sigemptyset(&action.sa_mask);
    for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

bool stopWanted() { return signalled != 0; }

void throwFailure(const std::string& where, const std::string& message) {
    throw Error(ErrorCode::Failed, message, where);
}

Show::Show(const Options& options, Renderer& renderer) : options_(options), renderer_(renderer) {
    setFrame(options.first_frame);
    std::vector<runtime::IndexVolume> objects;
    for (const std::string& path : options.objects) {
        const auto loaded = runtime::loadIndexVolumes(path);
        if (!loaded) throw Error(ErrorCode::Input, loaded.error().message, path);
        objects.insert(objects.end(), loaded->begin(), loaded->end());
    }
    if (!objects.empty()) {
        require(renderer.setObjects(objects), "objects");
        renderer.setEnvironment(options.environment.empty() ? studio()
                                                            : loadEnvironment(frameOf(options.environment, frame_)));
    }
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
        const FilesRead files;
        const Scene scene = loadScene(options_.scene, frame, messages);
        files_ = files.paths();
        lights_ = scene.lights;
        stage_ = stageOf(scene);
        for (std::size_t i = 0; first && i < volumes.size(); ++i)
            warnOfAnotherScene(volumes[i], options_.volumes[i], stage_);
    } else if (first) {
        stage_ = stageOf(volumes.front());
    }
    if (first && !volumes.empty()) level_ = lightLevel(volumes.front());
    stage_.level = level_;
    require(renderer_.setStage(stage_), "stage");
    if (renderer_.hasObjects() && options_.environment.find("####") != std::string::npos)
        renderer_.setEnvironment(loadEnvironment(frameOf(options_.environment, frame)));
    frame_ = frame;
}

void Show::setSun(const glm::vec3& direction) {
    const glm::vec3 unit = glm::normalize(direction);
    std::copy_n(&unit[0], 3, stage_.light.direction);
    require(renderer_.setLight(stage_.light), "light");
}

void Show::setBaked(Rebaked baked) {
    // What was not changed by hand follows the scene.
    if (picture.scattering == stage_.scattering) picture.scattering = baked.stage.scattering;
    if (picture.anisotropy == stage_.anisotropy) picture.anisotropy = baked.stage.anisotropy;
    for (int axis = 0; axis < 3; ++axis) {
        if (picture.extinction[axis] == stage_.light.extinction[axis])
            picture.extinction[axis] = baked.stage.light.extinction[axis];
    }
    stage_ = std::move(baked.stage);
    lights_ = std::move(baked.lights), files_ = std::move(baked.files);
    level_ = stage_.level;
    require(renderer_.setStage(stage_), "stage");
    // What stood in until there was a bake gives way to it.
    if (options_.volumes.empty() && !options_.right) picture.right = Source::BakedA;
    if (options_.volumes.empty() && !options_.left) picture.left = picture.right;
}

void Show::firstPicture() {
    const Options& o = options_;
    picture.camera = {o.eye.value_or(stage_.eye), o.target.value_or(stage_.target),
                      o.field_of_view_deg.value_or(stage_.field_of_view_deg)};
    const Source unbaked = renderer_.has(Source::CausticMap) || !o.bake ? Source::CausticMap : Source::None;
    picture.right = o.right.value_or(!o.volumes.empty() ? Source::BakedA : unbaked);
    picture.left = o.left.value_or(o.volumes.size() > 1 ? Source::BakedB : picture.right);
    picture.split = o.split.value_or(o.left || o.volumes.size() > 1 ? 0.5f : 0);
    for (const Source source : {picture.left, picture.right}) {
        if (!renderer_.has(source) && !(o.bake && source == Source::BakedA)) {
            throw Error(ErrorCode::Usage, fmt::format("'{}' needs {}", kSourceNames[static_cast<int>(source)],
                                                      source == Source::BakedA || source == Source::BakedB
                                                          ? "a volume; give its file"
                                                          : "a scene (.toml) with a sun and a height field of water"));
        }
    }
    picture.exposure = o.exposure, picture.tile_size = o.tile_size;
    // What is seen through shows what is around it, which must not be dark then.
    constexpr float kAroundObjects = 0.6f;
    picture.ambient = o.ambient.value_or(o.objects.empty() ? picture.ambient : kAroundObjects);
    picture.surface = o.surface;
    picture.turn = o.turn_deg * 3.14159265f / 180;
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
