// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "bake/cli/verbs.h"
#include "bake/file/output_set.h"
#include "bake/file/sample_volume.h"
#include "bake/report/error.h"
#include "bake/scene/solids.h"

namespace photic::cli {
namespace {

glm::dvec3 absorptionOf(const std::vector<double>& given) {
    if (given.empty()) return glm::dvec3(0);
    if (given.size() == 1) return glm::dvec3(given[0]);
    if (given.size() == 3) return {given[0], given[1], given[2]};
    throw Error(ErrorCode::Usage, fmt::format("{} values are given; write one [1/m], or red,green,blue", given.size()),
                "--absorption");
}

}  // namespace

int run(const VoxeliseArguments& arguments, Terminal& terminal) {
    OutputSet outputs;
    outputs.reads("the bodies", arguments.input);
    outputs.writes("the samples", arguments.output);
    const SolidsFile file =
        loadSolids(arguments.input, arguments.ior.value_or(1.5), absorptionOf(arguments.absorption), terminal);
    outputs.reads("a body", file.files);
    if (file.solids.size() > 1 && (arguments.ior || !arguments.absorption.empty()))
        throw Error(ErrorCode::Usage, fmt::format("'{}' says what its bodies are made of; leave out --ior and "
                                                  "--absorption",
                                                  arguments.input));
    const double voxel_size = arguments.voxel_size.value_or(file.voxel_size),
                 sigma = arguments.smooth.value_or(file.smooth);
    if (!(voxel_size > 0))
        throw Error(ErrorCode::Usage, "no size of voxels is given; add --voxel-size, for instance 0.001 [m]");
    const int margin = 2 + static_cast<int>(std::ceil(4 * sigma));
    SolidVolume volume = voxelise(file.solids, voxel_size, margin, terminal);
    const SmoothingEffect effect = smooth(volume, sigma);

    SampleVolume samples;
    samples.voxel_size = voxel_size, samples.min = volume.min, samples.size = volume.size;
    samples.grids.push_back({"n", 1, &volume.index});
    if (!volume.absorption.empty()) samples.grids.push_back({"absorption", 3, &volume.absorption});
    if (!volume.albedo.empty()) samples.grids.push_back({"albedo", 3, &volume.albedo});
    constexpr float kAir = 1e-6f;  // less of n is none
    samples.active = [&](std::size_t voxel) {
        return volume.inside[voxel] != 0 || std::fabs(volume.index[voxel] - 1.0f) > kAir;
    };
    const std::int64_t active = writeSamples(outputs, arguments.output, samples);
    if (active == 0)
        throw Error(ErrorCode::Input,
                    fmt::format("no voxel of {} m holds anything of the bodies; use smaller ones", voxel_size),
                    arguments.input);
    outputs.commit();
    terminal.say(fmt::format("{}: {} of {} x {} x {} voxels of {:.6g} m{}", arguments.output, active, volume.size.x,
                             volume.size.y, volume.size.z, voxel_size,
                             volume.albedo.empty()       ? (volume.absorption.empty() ? "" : ", n and absorption")
                             : volume.absorption.empty() ? ", n and albedo"
                                                         : ", n, absorption and albedo"));
    if (sigma > 0)
        terminal.say(
            fmt::format("  smoothed over {} voxels: n changes by {:.3g} at most and by {:.3g} on average where "
                        "it does; a face goes from 10 to 90 % in {:.2f} voxels, {:.3g} m",
                        sigma, effect.largest, effect.mean, effect.face_voxels, effect.face_voxels * voxel_size));
    return 0;
}

}  // namespace photic::cli
