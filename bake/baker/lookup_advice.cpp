// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/lookup_advice.h"

#include <fmt/format.h>

#include <cmath>

#include "bake/baker/bake_cost.h"
#include "bake/field/scene_grid.h"
#include "bake/field/scene_needed_voxels.h"
#include "bake/report/error.h"

namespace photic {
namespace {

/// Two digits, as one says it and as an option takes it.
double twoDigits(double v) {
    const double unit = std::pow(10, std::floor(std::log10(v)) - 1);
    return std::round(v / unit) * unit;
}

}  // namespace

std::string wordsOf(const std::vector<ReceiverError>& errors) {
    std::string words;
    for (const ReceiverError& error : errors)
        words += fmt::format("{}{}: look-ups are off by {:.2g} % at {:.2g} mm{}", words.empty() ? "" : "; ", error.name,
                             100 * error.relative_l1, 1000 * error.detail,
                             error.share < 0.9 ? fmt::format(" (on {:.2g} % of it)", 100 * error.share) : "");
    return words;
}

Scene withVoxels(const Scene& scene, double voxel_size) {
    Scene other = scene;
    if (scene.domain.voxel_size > 0) other.domain.layer_height *= voxel_size / scene.domain.voxel_size;
    other.domain.voxel_size = voxel_size;
    if (!scene.medium.present() && other.bake.where == Where::Everywhere) other.bake.where = Where::Receivers;
    return other;
}

std::string adviceFor(const Scene& scene, const Method& method, const MeasuredReceivers& measured,
                      const BakeChoices& choices, Monitor& monitor) {
    constexpr double kNoNeed = 0.002;
    const double worst = measured.largest();
    if (!(worst > kNoNeed)) return {};
    const double fits = voxelSizeFor(0.5 * worst, measured, scene.domain.voxel_size);
    if (!(fits > 0) || fits >= scene.domain.voxel_size) return {};
    const double size = twoDigits(fits);
    const Scene finer = withVoxels(scene, size);
    const bool around = finer.bake.where == Where::Receivers;
    std::string advice = fmt::format("half of it with voxels of {:.2g} mm{} (--voxel-size {:g}{})", 1000 * size,
                                     around ? " around receivers" : "", size, around ? " --where receivers" : "");
    try {
        constexpr std::int64_t kMostVoxels = std::int64_t{1} << 33;  // of a table that is looked through
        const GridFrame frame = sceneFrame(finer);
        if (frame.voxelCount() > kMostVoxels) return advice;
        const NeededVoxels needed = sceneNeededVoxels(finer, frame, monitor);
        const BakeCost cost = bakeCost(finer, method, frame, &needed, choices);
        advice +=
            fmt::format(": about {:.3g} MB and {:.2g} s", static_cast<double>(cost.file_bytes) * 1e-6, cost.seconds());
    } catch (const Error& error) {
        if (error.code() == ErrorCode::Cancelled) throw;  // otherwise it is too large to be told
    }
    return advice;
}

}  // namespace photic
