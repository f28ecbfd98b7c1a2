// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/game_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>

#include "bake/field/coarsen.h"
#include "bake/field/lobes.h"
#include "bake/field/scene_needed_voxels.h"
#include "bake/file/runtime_size.h"
#include "bake/file/voxel_box.h"
#include "bake/report/error.h"

namespace photic {

namespace {

constexpr int kVoxels = LightField::kLeafVoxels;

/// The voxels of a field that are in `kept` too, where any of the fields has light: both lobes lie on the same.
std::shared_ptr<const NeededVoxels> voxelsKept(std::span<const LightField* const> fields, const NeededVoxels& kept) {
    const LightField& field = *fields.front();
    NeededVoxels needed = NeededVoxels::none(field.frame());
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        const bool dark = std::all_of(fields.begin(), fields.end(),
                                      [&](const LightField* f) { return f->state(slot) == LeafState::Empty; });
        if (dark) continue;
        const glm::ivec3 origin = field.needed().leafOrigin(slot);
        const int other = kept.slotOf(origin);
        if (other < 0) continue;
        NeededVoxels::Mask mask = field.needed().mask(slot);
        for (std::size_t w = 0; w < mask.size(); ++w) mask[w] &= kept.mask(other)[w];
        needed.addLeaf(origin, mask);
    }
    needed.finish();
    return std::make_shared<const NeededVoxels>(std::move(needed));
}

LightField restricted(const LightField& field, const std::shared_ptr<const NeededVoxels>& needed) {
    LightField out(needed, field.channels());
    forEachLeaf(out.needed(), [&](int slot) {
        const int from = field.needed().slotOf(out.needed().leafOrigin(slot));
        if (field.state(from) == LeafState::Empty) return;
        if (field.state(from) == LeafState::Constant) {
            out.setConstant(slot, field.constant(from));
        } else {
            std::copy_n(field.dense(from), field.channels().count() * kVoxels, out.makeDense(slot));
        }
    });
    return out;
}

/// Both lobes, on the voxels that are in `kept` too.
LobeFields restricted(const LightField& first, const LightField* second, const NeededVoxels& kept) {
    const std::array<const LightField*, 2> fields{&first, second};
    const auto needed = voxelsKept({fields.data(), second != nullptr ? 2u : 1u}, kept);
    LobeFields out{restricted(first, needed), std::nullopt};
    if (second != nullptr) out.second = restricted(*second, needed);
    return out;
}

}  // namespace

std::vector<ExportPlan> exportPlans(const Scene* scene) {
    std::vector<ExportPlan> plans;
    for (const int factor : {1, 2, 4, 8, 16}) {
        plans.push_back({factor, {}});
        // A flat receiver's look-ups need a voxel on each side; more is for what moves near it.
        for (const int band : {8, 4, 2, 1}) {
            if (scene != nullptr) plans.push_back({factor, band});
        }
    }
    return plans;
}

std::int64_t gameBytes(const LightVolume& volume, MemoryModel model) {
    if (model == MemoryModel::Runtime) return runtimeSize(volume).bytes;
    const glm::ivec3 size = StraightField(volume).box({}).size();
    return denseTextureBytes(std::int64_t{size.x} * size.y * size.z, volume.field.channels()) * (volume.second ? 2 : 1);
}

LightVolume planned(const LightVolume& volume, const ExportPlan& plan, const Scene* scene, Monitor& monitor) {
    const LightField* second = volume.second ? &*volume.second : nullptr;
    LobeFields lobes = plan.factor > 1 ? LobeFields{coarsened(volume.field, plan.factor, monitor), std::nullopt}
                                       : restricted(volume.field, second, volume.field.needed());
    if (plan.factor > 1 && second != nullptr) lobes.second = coarsened(*second, plan.factor, monitor);
    if (plan.band && scene != nullptr) {
        Scene narrowed = *scene;
        narrowed.bake.where = Where::Receivers;
        narrowed.bake.band = *plan.band;
        lobes = restricted(lobes.first, lobes.second ? &*lobes.second : nullptr,
                           sceneNeededVoxels(narrowed, lobes.first.frame(), monitor));
    }
    return {std::move(lobes.first), volume.reference_irradiance, volume.has_irradiance, volume.has_direction, {},
            volume.metadata,        std::move(lobes.second)};
}

ExportPlan sharedPlan(const LightVolume& volume, ExportPlan plan, const Scene* scene, Monitor& monitor) {
    if (!plan.band) return plan;
    plan.shift = glm::ivec3(0);
    plan.shift = fewestBricksShift(planned(volume, plan, scene, monitor));
    return plan;
}

std::size_t fittingPlan(const LightVolume& volume, const std::vector<ExportPlan>& plans, std::size_t first,
                        std::int64_t budget_bytes, MemoryModel model, const Scene* scene, Monitor& monitor) {
    const auto everything = static_cast<double>(gameBytes(volume, model));
    std::int64_t bytes = 0;
    std::optional<LightVolume> level;  // at the resolution of plans[i], everything kept
    int level_factor = 0;
    for (std::size_t i = first; i < plans.size(); ++i) {
        monitor.checkCancelled();
        // Coarser voxels save their number at most: what cannot fit is not tried.
        const bool hopeless =
            !plans[i].band && everything / std::pow(plans[i].factor, 3) > static_cast<double>(budget_bytes);
        if (hopeless && i + 1 < plans.size()) continue;
        monitor.progress("fit", static_cast<double>(i) / static_cast<double>(plans.size()));
        if (plans[i].factor != level_factor) level.emplace(planned(volume, {plans[i].factor, {}}, scene, monitor));
        level_factor = plans[i].factor;
        bytes = plans[i].band ? gameBytes(planned(*level, {1, plans[i].band}, scene, monitor), model)
                              : gameBytes(*level, model);
        if (bytes <= budget_bytes) return i;
    }
    throw Error(
        ErrorCode::Input,
        fmt::format("does not fit: with voxels {} times as wide it still takes {:.2f} MiB, the budget is {:.2f} MiB; "
                    "raise --budget or bake a smaller domain",
                    plans.back().factor, static_cast<double>(bytes) / (1 << 20),
                    static_cast<double>(budget_bytes) / (1 << 20)),
        "--budget");
}

}  // namespace photic
