// SPDX-License-Identifier: Apache-2.0
#include "runtime/viewer/rebake.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <cerrno>
#include <chrono>
#include <cstring>

#include "bake/image/atomic_file.h"
#include "bake/report/monitor.h"
#include "bake/scene/load_toml.h"
#include "photic/runtime_vdb.h"

namespace photic::viewer {
namespace {

namespace fs = std::filesystem;

fs::path temporaryFolder() {
    std::error_code failure;
    std::string pattern = (fs::temp_directory_path(failure) / "photic_view_XXXXXX").string();
    if (failure || !mkdtemp(pattern.data()))
        throw Error(ErrorCode::Failed,
                    fmt::format("there is no place for temporary files ('{}': {}); set TMPDIR to a folder that can be "
                                "written",
                                pattern, std::strerror(errno)));
    return pattern;
}

bool isReady(const std::future<Rebaked>& load) {
    return load.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

void removeFile(const fs::path& path) {
    std::error_code ignored;
    fs::remove(path, ignored);
}

/// In a thread of its own.
Rebaked loadBaked(const fs::path& volume, const std::string& text, const std::string& scene, int frame) {
    auto loaded = runtime::loadVdb(volume.string());
    removeFile(volume);
    if (!loaded) throw Error(ErrorCode::Failed, loaded.error().message, scene);
    const FilesRead files;
    Monitor silent;  // the baker has said it all
    const Scene baked = parseScene(text, scene, fs::path(scene).parent_path().string(), frame, silent);
    Rebaked out{std::move(*loaded), stageOf(baked), baked.lights, {}, {}};
    out.stage.level = lightLevel(out.volume);
    out.files = files.paths();
    out.files.push_back(scene);  // which was read before
    return out;
}

}  // namespace

Rebake::Rebake(std::string program, std::string scene, std::vector<std::string> arguments)
    : program_(std::move(program)),
      scene_(std::move(scene)),
      arguments_(std::move(arguments)),
      folder_(temporaryFolder()) {}

Rebake::~Rebake() {
    stop();
    for (const std::future<Rebaked>& load : unwanted_) load.wait();
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
}

void Rebake::fail(const Error& error) {
    // The file that the baker speaks of has the lines of the scene's.
    const auto own = [&](std::string words) {
        const std::string other = moved_.string();
        for (std::size_t at = 0; !other.empty() && (at = words.find(other, at)) != std::string::npos;)
            words.replace(at, other.size(), scene_), at += scene_.size();
        return words;
    };
    stop();
    phase_ = Phase::Failed;
    failure_.emplace(error.code(), own(error.what()), own(error.where()));
}

void Rebake::stop() {
    process_.reset();
    if (load_.valid()) unwanted_.push_back(std::move(load_));
    removeFile(moved_);
    removeFile(baked_);
    phase_ = Phase::Idle;
}

void Rebake::start(int frame, const std::vector<MovedLight>& moved) {
    stop();
    const std::string name = fmt::format("{}_{}", fs::path(scene_).stem().string(), ++count_);
    moved_ = folder_ / (name + ".toml"), baked_ = folder_ / (name + ".vdb");
    frame_ = frame;
    std::vector<std::string> arguments{moved_.string(), "-o"};
    if (frame == 1) {
        arguments.push_back(baked_.string());
    } else {
        arguments.push_back((folder_ / (name + ".####.vdb")).string());
        arguments.insert(arguments.end(), {"--frames", fmt::format("{0}-{0}", frame)});
        baked_ = folder_ / fmt::format("{}.{:04d}.vdb", name, frame);
    }
    arguments.insert(arguments.end(), arguments_.begin(), arguments_.end());
    try {
        text_ = withMovedLights(readFileBytes(scene_), scene_, fs::path(scene_).parent_path().string(), moved);
        writeFileAtomically(moved_.string(), text_);
        process_ = std::make_unique<BakeProcess>(program_, arguments);
        phase_ = Phase::Baking;
    } catch (const Error& error) {
        fail(error);
    }
}

std::optional<Rebaked> Rebake::poll() {
    std::erase_if(unwanted_, isReady);
    try {
        if (phase_ == Phase::Baking && process_->poll()) {
            if (!process_->succeeded()) throw process_->failure();
            warnings_ = process_->warnings();
            process_.reset();
            removeFile(moved_);
            load_ = std::async(std::launch::async, loadBaked, baked_, text_, scene_, frame_);
            phase_ = Phase::Loading;
        }
        if (phase_ == Phase::Loading && isReady(load_)) {
            phase_ = Phase::Idle;
            Rebaked baked = load_.get();
            baked.warnings = warnings_;
            return baked;
        }
    } catch (const Error& error) {
        fail(error);
    }
    return std::nullopt;
}

}  // namespace photic::viewer
