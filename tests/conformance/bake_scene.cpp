// SPDX-License-Identifier: Apache-2.0
#include "tests/conformance/bake_scene.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include "bake/scene/load_toml.h"

namespace photic {

Baked bakeScene(Scene scene, const std::string& method, const GivenOptions& options) {
    Monitor monitor;
    scene.bake.method = method;
    GivenOptions& given = scene.bake.method_options[chooseMethod(method, scene).name];
    given = given | options;
    BakedScene result = bakeScene(scene, monitor);
    return {std::move(scene), std::move(result)};
}

Baked bakeText(const std::string& toml, const std::string& method, const GivenOptions& options) {
    Monitor monitor;
    return bakeScene(parseScene(toml, "test.toml", ".", 0, monitor), method, options);
}

GivenOptions option(const std::string& name, OptionValue value) { return {{name, {std::move(value), "test"}}}; }

GivenOptions operator|(GivenOptions a, const GivenOptions& b) {
    for (const auto& [name, value] : b) a[name] = value;
    return a;
}

Baked whole(Baked baked) {
    baked.result.volume = withoutLobes(std::move(baked.result.volume));
    return baked;
}

double blockDifference(const LightField& a, const LightField& b, int side, const glm::ivec3& shift) {
    std::map<std::tuple<int, int, int>, std::pair<double, double>> blocks;
    const GridFrame& f = b.frame();
    for (int k = f.min.z; k <= f.max.z; ++k)
        for (int j = f.min.y; j <= f.max.y; ++j)
            for (int i = f.min.x; i <= f.max.x; ++i) {
                const glm::ivec3 v(i, j, k), block = (v - f.min) / side;
                auto& [x, y] = blocks[{block.x, block.y, block.z}];
                x += a.irradiance(v + shift), y += b.irradiance(v);
            }
    double off = 0, sum = 0;
    for (const auto& [place, means] : blocks) off += std::fabs(means.first - means.second), sum += means.second;
    return sum > 0 ? off / sum : off;
}

std::vector<std::string> methodNames() {
    std::vector<std::string> names;
    // Waves diffract and run on a grid of their own: what they keep of these laws is in tests/methods/wave_test.cpp.
    // Media whose index varies have no surface of water; wavefronts keep these laws in a scene of their own.
    for (const Method& m : methodCatalogue())
        if (m.name != "wave" && m.name != "wavefront") names.push_back(m.name);
    return names;
}

std::string WaveScene::toml() const {
    // cos(k x) is a sine a quarter ahead.
    return fmt::format(
        R"(photic = 1
[domain]
min = [-0.5, 0.0, {bottom}]
max = [0.5, {thickness}, {top}]
voxel_size = {voxel}
[[light]]
type = "sun"
direction = [0, 0, -1]
irradiance = 1.0
angular_diameter = 0
[[surface]]
name = "water"
kind = "height_field"
size = [2.0, 0.5]
outside = "periodic"
event = "refract"
ior_below = {ior}
waves = [{{ amplitude = {amplitude}, wavelength = {wavelength}, direction = 0, phase = {phase:.17g} }}]
{medium}[bake]
quadrature = {quadrature}
)",
        fmt::arg("bottom", kBottom), fmt::arg("thickness", 8 * voxel()), fmt::arg("top", kTop),
        fmt::arg("voxel", voxel()), fmt::arg("ior", kIor), fmt::arg("amplitude", kAmplitude),
        fmt::arg("wavelength", kWavelength), fmt::arg("phase", std::numbers::pi / 2),
        fmt::arg("medium", extinction > 0 ? fmt::format("[medium]\nabsorption = {}\n", extinction) : std::string()),
        fmt::arg("quadrature", quadrature));
}

truth::VoxelMeans WaveScene::truth() const {
    const double k = 2 * std::numbers::pi / kWavelength;
    const truth::WaveLight light(truth::cosineProfile(kAmplitude, k), kIor, -1, 1, 1024, extinction);
    return light.voxelMeans(-0.5, voxel(), cells, kBottom, voxel(), layers());
}

WaveErrors waveErrors(const WaveScene& scene, const Baked& baked, const truth::VoxelMeans& means) {
    const GridFrame& frame = baked.field().frame();
    WaveErrors errors;
    double smooth = 0, all = 0, smooth_flux = 0, all_flux = 0;
    const int rows = frame.size().y;
    for (int k = 0; k < scene.layers(); ++k) {
        for (int j = 0; j < rows; ++j) {
            for (int i = 0; i < scene.cells; ++i) {
                const auto v = means.index(i, k);
                const glm::ivec3 voxel = frame.min + glm::ivec3(i, j, k);
                const double e = std::fabs(baked.field().irradiance(voxel) - means.fluence[v]);
                const glm::dvec3 flux(means.across[v], 0, -means.down[v]);
                const double f = glm::length(baked.field().flux(voxel) - flux);
                all += means.fluence[v], all_flux += glm::length(flux);
                errors.irradiance_all += e, errors.flux_all += f;
                if (means.jacobian[v] > 0.2) {
                    smooth += means.fluence[v], smooth_flux += glm::length(flux);
                    errors.irradiance_smooth += e, errors.flux_smooth += f;
                }
            }
        }
    }
    errors.irradiance_smooth /= smooth, errors.flux_smooth /= smooth_flux;
    errors.irradiance_all /= all, errors.flux_all /= all_flux;
    errors.smooth_share = smooth / all;
    return errors;
}

}  // namespace photic
