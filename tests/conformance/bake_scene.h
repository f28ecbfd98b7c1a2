// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "bake/baker/bake_scene.h"
#include "bake/methods/catalogue.h"
#include "bake/scene/scene.h"
#include "tests/support/pool3.h"
#include "tests/support/wave_light.h"

namespace photic {

/// A scene from text and what a method made of it.
struct Baked {
    Scene scene;
    BakedScene result;
    const LightField& field() const { return result.volume.field; }
    double irradiance(int i, int j, int k) const { return field().irradiance({i, j, k}); }
    glm::dvec3 flux(int i, int j, int k) const { return field().flux({i, j, k}); }
};

/// Bakes by a method; `options` win over the scene's own [bake.METHOD].
Baked bakeScene(Scene scene, const std::string& method, const GivenOptions& options = {});
Baked bakeText(const std::string& toml, const std::string& method, const GivenOptions& options = {});

/// All light of a bake in one field: which voxels have two lobes is not asked.
Baked whole(Baked baked);

/// Relative L1 of means over blocks of side^3 voxels between two fields, the first of which is moved by `shift` voxels:
/// noise of single voxels is averaged away, errors that stay in place are not.
double blockDifference(const LightField& a, const LightField& b, int side, const glm::ivec3& shift = glm::ivec3(0));

GivenOptions option(const std::string& name, OptionValue value);
GivenOptions operator|(GivenOptions a, const GivenOptions& b);

/// Names of the catalogue's rows that trace rays, for parametrised tests of laws that rays keep to rounding.
std::vector<std::string> methodNames();

/// A wave z = a cos(k x), light straight down, a slab 8 voxels thin in y; one metre holds two wave lengths and `cells`
/// voxels.
struct WaveScene {
    static constexpr double kAmplitude = 0.03, kWavelength = 0.5, kIor = 1.333;
    static constexpr double kBottom = -1.5, kTop = 0.0625;
    int cells = 64;
    int quadrature = 1;
    double extinction = 0;

    double voxel() const { return 1.0 / cells; }
    int layers() const { return static_cast<int>((kTop - kBottom) * cells + 0.5); }
    std::string toml() const;
    truth::VoxelMeans truth() const;
};

/// Errors of a bake of a WaveScene against its truth.
struct WaveErrors {
    double irradiance_smooth = 0, irradiance_all = 0;  ///< relative L1; smooth: |J| > 0.2 for all arrivals of a voxel
    double flux_smooth = 0, flux_all = 0;              ///< of the vector
    double smooth_share = 0;                           ///< of the light
};
WaveErrors waveErrors(const WaveScene& scene, const Baked& baked, const truth::VoxelMeans& means);

}  // namespace photic
