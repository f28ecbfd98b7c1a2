// SPDX-License-Identifier: Apache-2.0
#include "tests/runtime/baked_scene.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "bake/baker/bake_scene.h"
#include "bake/scene/load_toml.h"
#include "photic/runtime_vdb.h"

namespace photic::test {
namespace {

/// A temporary file's name, and no file of that name afterwards.
class TemporaryFile {
public:
    explicit TemporaryFile(const std::string& ending)
        : path_((std::filesystem::temp_directory_path() / ("photic_runtime_" + std::to_string(::getpid()) + ending))
                    .string()) {}
    ~TemporaryFile() { std::filesystem::remove(path_); }
    const std::string& path() const { return path_; }

private:
    std::string path_;
};

runtime::Volume loaded(const runtime::Result<runtime::Volume>& volume) {
    if (!volume) throw std::runtime_error(volume.error().message);
    return *volume;
}

}  // namespace

std::string poolText(const std::string& sun, const std::string& medium, double voxel) {
    return R"(photic = 1
[domain]
min = [-0.5, -0.5, -1.1]
max = [0.55, 0.5, 0.1]
voxel_size = )" +
           std::to_string(voxel) + R"(
[[light]]
type = "sun"
direction = [0.433, 0.25, -0.866]
angular_diameter = 0.53
irradiance = )" +
           sun +
           R"(
[[surface]]
name = "water"
kind = "height_field"
size = [3.0, 3.0]
waves = [{ amplitude = 0.02, wavelength = 0.6, direction = 20.0, phase = 0.4 },
         { amplitude = 0.012, wavelength = 0.4, direction = 100.0, phase = 1.7 }]
[[object]]
name = "floor"
plane = { point = [0, 0, -1.0], normal = [0, 0, 1] }
[[object]]
name = "east"
plane = { point = [0.48, 0, 0], normal = [-1, 0, 0] }
)" + medium;
}

BakedScene bake(const std::string& text) {
    const auto path =
        std::filesystem::temp_directory_path() / ("photic_runtime_" + std::to_string(::getpid()) + ".toml");
    std::ofstream(path) << text;
    Monitor monitor;
    Scene scene = loadScene(path.string(), 1, monitor);
    std::filesystem::remove(path);
    LightVolume volume = photic::bakeScene(scene, monitor).volume;
    return {std::move(scene), std::move(volume)};
}

runtime::Volume asGameVolume(const LightVolume& volume, NvdbPrecision precision) {
    const TemporaryFile file(".nvdb");
    NvdbOptions options;
    options.precision = precision;
    writeNvdb(file.path(), volume, options);
    return loaded(runtime::loadVolume(file.path()));
}

runtime::Volume opposedSuns() {
    const BakedScene baked = bake(poolText("600.0", R"([[light]]
type = "sun"
direction = [0.25, -0.77, -0.58]
irradiance = 500.0
angular_diameter = 0
)"));
    return asGameVolume(baked.volume, NvdbPrecision::Half);
}

runtime::Volume throughVdb(const LightVolume& volume) {
    const TemporaryFile file(".vdb");
    writeVdb(file.path(), volume, {});
    return loaded(runtime::loadVdb(file.path()));
}

}  // namespace photic::test
