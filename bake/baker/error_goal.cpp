// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/error_goal.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/common.hpp>
#include <utility>

#include "bake/baker/bake_cost.h"
#include "bake/baker/lookup_advice.h"
#include "bake/field/scene_grid.h"
#include "bake/field/scene_needed_voxels.h"
#include "bake/report/error.h"

namespace photic {
namespace {

constexpr int kFirstCells = 64;  // of the domain's longest side
constexpr int kMostBakes = 5;
constexpr double kMostBytes = 256e6, kMostSeconds = 10;
constexpr double kMargin = 0.85;  // of the goal that is aimed at: a prediction is off by some per cent

/// Its warnings are those of a bake that is not handed on.
class UnwarnedMonitor final : public Monitor {
public:
    explicit UnwarnedMonitor(Monitor& to) : to_(to) {}
    void progress(std::string_view stage, double fraction) override { to_.progress(stage, fraction); }
    bool cancelled() const override { return to_.cancelled(); }

private:
    Monitor& to_;
};

/// What stands against a bake; empty when nothing does.
std::string obstacle(const Scene& scene, const BakeChoices& choices, Monitor& monitor) {
    // A table of more is not looked through.
    constexpr double kMostVoxels = 1e10;
    const glm::dvec3 cells = (scene.domain.max - scene.domain.min) / scene.domain.voxel_size;
    if (const double voxels = cells.x * cells.y * cells.z; !(voxels <= kMostVoxels))
        return fmt::format("a box of {:.2g} voxels", voxels);
    const Method& method = chooseMethod(scene.bake.method, scene);
    const GridFrame frame = sceneFrame(scene);
    const NeededVoxels needed = sceneNeededVoxels(scene, frame, monitor);
    const BakeCost cost = bakeCost(scene, method, frame, &needed, choices);
    if (static_cast<double>(cost.file_bytes) > kMostBytes || cost.seconds() > kMostSeconds)
        return fmt::format("about {:.2g} MB and {:.2g} s", static_cast<double>(cost.file_bytes) * 1e-6, cost.seconds());
    return {};
}

}  // namespace

BakedScene bakeToError(const Scene& scene, Monitor& monitor, const BakeChoices& given) {
    const double goal = scene.bake.error.value_or(0);
    if (!(goal > 0)) return bakeScene(scene, monitor, given);
    BakeChoices choices = given;
    choices.measure = Measure::Wholly;
    const glm::dvec3 extent = scene.domain.max - scene.domain.min;
    double size = std::max({extent.x, extent.y, extent.z}) / kFirstCells;
    UnwarnedMonitor unwarned(monitor);
    std::string why;
    for (int bakes = 1;; ++bakes) {
        // A coarse first look is told nobody; the one that is handed on says its warnings.
        BakedScene baked =
            bakeScene(withVoxels(scene, size), bakes == 1 ? static_cast<Monitor&>(unwarned) : monitor, choices);
        const double reached = baked.measured.largest();
        if (baked.measured.errors.empty())
            throw Error(ErrorCode::Input,
                        fmt::format("an error of {:.2g} % is asked for, and none can be measured: {}; ask for a "
                                    "voxel_size instead",
                                    100 * goal, baked.measured.not_measured),
                        scene.file);
        const double next = reached > goal ? voxelSizeFor(kMargin * goal, baked.measured, size) : 0;
        const bool narrower = next > 0 && next < 0.97 * size;
        if (narrower && bakes < kMostBakes) {
            why = obstacle(withVoxels(scene, next), choices, monitor);
            if (why.empty()) {
                size = next;
                continue;
            }
        }
        if (reached > goal)
            monitor.warn(fmt::format(
                "look-ups are off by {:.2g} %, and {:.2g} % was asked for{}", 100 * reached, 100 * goal,
                why.empty() ? std::string(": narrower voxels were no better")
                            : fmt::format(": voxels of {:.2g} mm would take {}; --voxel-size {:.2g} bakes them",
                                          1000 * next, why, next)));
        baked.volume.metadata["scene_hash"] = inputHash(scene, chooseMethod(scene.bake.method, scene), given);
        return baked;
    }
}

}  // namespace photic
