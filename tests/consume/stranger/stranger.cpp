// SPDX-License-Identifier: Apache-2.0
// Bakes still water under a sun at the zenith, whose irradiance below is known: E0 (1 - ((n - 1)/(n + 1))^2).
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "bake/baker/bake_scene.h"
#include "bake/file/vdb.h"
#include "bake/scene/load_toml.h"

static const char* const kScene = R"(
photic = 1
[domain]
min = [-0.5, -0.5, -1.0]
max = [ 0.5,  0.5,  0.1]
voxel_size = 0.0625
[[light]]
type = "sun"
direction = [0, 0, -1]
irradiance = 1000.0
[[surface]]
name = "water"
kind = "height_field"
waves = [{ amplitude = 0.0, wavelength = 1.0 }]
size = [2.0, 2.0]
)";

int main() try {
    photic::Monitor monitor;
    const photic::Scene scene = photic::parseScene(kScene, "stranger", ".", 1, monitor);
    const photic::LightVolume volume = photic::bakeScene(scene, monitor).volume;

    const double irradiance = volume.field.irradiance({0, 0, -8});
    const double expected = 1000.0 * (1 - std::pow((1.333 - 1) / (1.333 + 1), 2));
    std::printf("%s: %.4f W/m2, expected %.4f\n", volume.metadata.at("method").c_str(), irradiance, expected);
    if (!(std::fabs(irradiance / expected - 1) < 1e-4)) return 1;

    // And through a file.
    const auto path = std::filesystem::current_path() / "stranger.vdb";
    photic::writeVdb(path.string(), volume, {});
    const double read_back = photic::readVdb(path.string()).field.irradiance({0, 0, -8});
    std::printf("read back: %.4f W/m2\n", read_back);
    return std::fabs(read_back / expected - 1) < 1e-3 ? 0 : 1;
} catch (const photic::Error& error) {
    std::fprintf(stderr, "%s: %s\n", error.where().c_str(), error.what());
    return 1;
}
