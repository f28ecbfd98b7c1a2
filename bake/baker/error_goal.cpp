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
#include "bake/methods/kept_shapes.h"
#include "bake/methods/plane_light.h"
#include "bake/report/error.h"

namespace photic {
namespace {

constexpr int kFirstCells = 64;  // of the domain's longest side
constexpr int kMostBakes = 5;
constexpr double kNarrower = 0.97, kWiden = 1.2;  // of voxels that are tried next
constexpr double kMargin = 0.85;                  // of the goal that is aimed at: a prediction is off by some per cent

/// Keeps warnings back: those of the bake that is handed on are told once it is known which that is.
class UnwarnedMonitor final : public Monitor {
public:
    explicit UnwarnedMonitor(Monitor& to) : to_(to) {}
    void progress(std::string_view stage, double fraction) override { to_.progress(stage, fraction); }
    bool cancelled() const override { return to_.cancelled(); }

private:
    Monitor& to_;
};

/// How much longer a bake took than it was expected to, its measuring apart; 1 where it did not.
double slowness(const Scene& scene, const BakedScene& baked, const BakeChoices& choices) {
    BakeChoices alone = choices;
    alone.measure = Measure::Nothing;
    const NeededVoxels& needed = baked.volume.field.needed();
    const Method& method = chooseMethod(scene.bake.method, scene);
    const double expected = bakeCost(scene, method, needed.frame(), &needed, alone).seconds();
    double took = 0;
    for (const auto& [stage, seconds] : baked.report.seconds)
        if (stage != "measure") took += seconds;
    constexpr double kTooShortToTell = 0.3;
    return took > kTooShortToTell ? std::max(1.0, took / expected) : 1.0;
}

/// What stands against a bake; empty when nothing does.
/// @param slower  than is expected
std::string obstacle(const Scene& scene, const BakeChoices& choices, double slower, Monitor& monitor) {
    // A table of more is not looked through.
    constexpr double kMostVoxels = 1e10;
    const glm::dvec3 cells = (scene.domain.max - scene.domain.min) / scene.domain.voxel_size;
    if (const double voxels = cells.x * cells.y * cells.z; !(voxels <= kMostVoxels))
        return fmt::format("a box of {:.2g} voxels", voxels);
    const Method& method = chooseMethod(scene.bake.method, scene);
    const GridFrame frame = sceneFrame(scene);
    const NeededVoxels needed = sceneNeededVoxels(scene, frame, monitor);
    const BakeCost cost = bakeCost(scene, method, frame, &needed, choices);
    const bool too_much =
        static_cast<double>(cost.file_bytes) > choices.budget_bytes || slower * cost.seconds() > choices.seconds;
    if (too_much) return wordsOf(cost, slower);
    return {};
}

/// With the domain's own voxels, as nobody asked for others.
BakedScene bakeUnmeasured(const Scene& scene, const std::string& why, Monitor& monitor, const BakeChoices& choices) {
    monitor.note(
        fmt::format("voxels of {:.3g} mm, as nothing says how wide they should be and no error of look-ups can be "
                    "measured here: {}",
                    1000 * scene.domain.voxel_size, why));
    return bakeScene(scene, monitor, choices);
}

}  // namespace

BakedScene bakeToError(const Scene& scene, Monitor& monitor, const BakeChoices& given) {
    const double goal = errorGoal(scene.bake);
    if (!(goal > 0)) return bakeScene(scene, monitor, given);
    if (!scene.bake.error && std::none_of(scene.objects.begin(), scene.objects.end(),
                                          [](const Object& object) { return object.receives(); }))
        return bakeUnmeasured(scene, "nothing receives light", monitor, given);
    BakeChoices choices = given;
    choices.kept_light = nullptr;  // no two bakes have the same voxels
    const KeptShapes shapes;
    const glm::dvec3 extent = scene.domain.max - scene.domain.min;
    double size = std::max({extent.x, extent.y, extent.z}) / kFirstCells;
    UnwarnedMonitor unwarned(monitor);
    std::string why;
    bool last = false;  // no narrower voxels are allowed
    bool wholly = given.measure == Measure::Wholly;
    for (int bakes = 1;; ++bakes) {
        const Scene tried = withVoxels(scene, size);
        choices.measure = wholly || planeLightIsQuick(tried) ? Measure::Wholly : Measure::Quickly;
        BakedScene baked = bakeScene(tried, unwarned, choices);
        if (baked.measured.errors.empty() && scene.bake.error && !wholly && baked.measured.costs_too_much) {
            // Who asks for an error waits for it to be known.
            wholly = true, choices.measure = Measure::Wholly;
            baked = bakeScene(tried, unwarned, choices);
        }
        const double reached = baked.measured.largest();
        if (baked.measured.errors.empty() && !scene.bake.error)
            return bakeUnmeasured(scene, baked.measured.not_measured, monitor, given);
        if (baked.measured.errors.empty())
            throw Error(ErrorCode::Input,
                        fmt::format("an error of {:.2g} % is asked for, and none can be measured: {}; ask for a "
                                    "voxel_size instead",
                                    100 * goal, baked.measured.not_measured),
                        scene.file);
        const double wanted = reached > goal ? voxelSizeFor(kMargin * goal, baked.measured, size) : 0;
        if (wanted > 0 && wanted < kNarrower * size && bakes < kMostBakes && !last) {
            // As narrow as is allowed, where what is wanted is not.
            double next = wanted;
            const double slower = slowness(tried, baked, choices);
            for (std::string stands = obstacle(withVoxels(scene, next), choices, slower, monitor); !stands.empty();
                 stands = obstacle(withVoxels(scene, next), choices, slower, monitor)) {
                if (why.empty())
                    why = fmt::format("voxels of {:.2g} mm would take {}; --voxel-size {:.2g} bakes them",
                                      1000 * wanted, stands, wanted);
                next *= kWiden, last = true;
                if (next >= kNarrower * size) break;
            }
            if (next < kNarrower * size) {
                size = next;
                continue;
            }
        }
        std::vector<std::string>& warnings = baked.report.warnings;
        if (reached > goal)
            warnings.push_back(fmt::format(
                "look-ups are off by {:.2g} %, and {:.2g} % {}: {}", 100 * reached, 100 * goal,
                scene.bake.error ? "was asked for" : "is aimed at where nothing says how wide voxels should be",
                why.empty() ? "narrower voxels were no better" : why));
        for (const std::string& warning : warnings) monitor.warn(warning);
        baked.volume.metadata["scene_hash"] = inputHash(scene, chooseMethod(scene.bake.method, scene), given);
        return baked;
    }
}

}  // namespace photic
