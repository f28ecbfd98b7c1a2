// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/game_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <span>

#include "bake/field/coarsen.h"
#include "bake/field/lobes.h"
#include "bake/field/resample.h"
#include "bake/field/scene_needed_voxels.h"
#include "bake/field/two_levels.h"
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

/// Both lobes at other indices.
LobeFields moved(const LobeFields& lobes, const glm::ivec3& shift) {
    LobeFields out{reindexed(lobes.first, shift), std::nullopt};
    if (lobes.second) out.second = reindexed(*lobes.second, shift);
    return out;
}

/// How far (0..15 along each axis) to move a volume's indices so that the fewest voxels with light lie where a block of
/// 16^3 or a page of 8^3 begins or ends: light there takes a brick of the neighbour too, and the wide voxels of a block
/// reach one voxel further than its light.
glm::ivec3 fewestBordersShift(const LightVolume& volume) {
    constexpr int kSide = CoarseBlocks::kSide;
    std::array<std::array<std::int64_t, kSide>, 3> lit{};  // by axis and place in a block
    const LightField& field = volume.field;
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        if (field.state(slot) == LeafState::Empty) continue;
        const glm::ivec3 origin = field.needed().leafOrigin(slot);
        for (int i = 0; i < kVoxels; ++i) {
            if (!NeededVoxels::maskBit(field.needed().mask(slot), i)) continue;
            const glm::ivec3 at = (origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7)) & (kSide - 1);
            for (int a = 0; a < 3; ++a) ++lit[static_cast<std::size_t>(a)][static_cast<std::size_t>(at[a])];
        }
    }
    glm::ivec3 shift(0);
    for (int a = 0; a < 3; ++a) {
        std::int64_t fewest = std::numeric_limits<std::int64_t>::max();
        for (int s = 0; s < kSide; ++s) {
            std::int64_t borders = 0;
            for (int v = 0; v < kSide; ++v) {
                const int there = (v + s) & (kSide - 1);
                const int cost = (there <= 1 || there == kSide - 1) + (there % 8 == 0);
                borders += cost * lit[static_cast<std::size_t>(a)][static_cast<std::size_t>(v)];
            }
            if (borders < fewest) fewest = borders, shift[a] = s;
        }
    }
    return shift;
}

/// The first voxel of a period, and the period; how that is cut must be known along all axes where light repeats.
RepeatingVoxels repeatingVoxels(const LightVolume& volume) {
    RepeatingVoxels out{glm::ivec3(0), periodVoxels(volume)};
    if (out.period != glm::ivec3(0))
        out.first = brickPages(volume, activeLeaves(volume, ActiveBy::Light), CoarseBlocks()).low;
    return out;
}

glm::ivec3 shiftOf(const LightVolume& volume, const ExportPlan& plan) {
    if (plan.two_levels_in == 0) return fewestBricksShift(volume);
    glm::ivec3 shift = fewestBordersShift(volume);
    // A period begins with a block.
    const RepeatingVoxels repeats = repeatingVoxels(volume);
    for (int a = 0; a < 3; ++a)
        if (repeats.period[a] != 0) shift[a] = -repeats.first[a] & (CoarseBlocks::kSide - 1);
    return shift;
}

/// Whether wide voxels repeat as the light does. As BC6H light that repeats is one box, which has one level.
bool canHaveTwoLevels(const RepeatingVoxels& repeats, GameTexels texels) {
    if (repeats.period == glm::ivec3(0)) return true;
    for (int a = 0; a < 3; ++a)
        if (repeats.period[a] % 2 != 0 || (repeats.period[a] != 0 && repeats.first[a] % CoarseBlocks::kSide != 0))
            return false;
    return texels == GameTexels::Halves;
}

/// What two levels make of a volume that they make fit, with as few coarse blocks as that takes; with all of them where
/// it never fits. The bytes fall with the number of blocks but for a brick here and there at their borders.
LightVolume inTwoLevels(LightVolume volume, std::int64_t budget_bytes, GameTexels texels, Monitor& monitor) {
    const TwoLevels levels(volume.field, volume.second ? &*volume.second : nullptr, monitor, repeatingVoxels(volume));
    const auto with = [&](int count) {
        TwoLevels::Made made = levels.with(count);
        LightVolume out{
            std::move(made.field), volume.reference_irradiance, volume.has_irradiance, volume.has_direction, {},
            volume.metadata};
        out.second = std::move(made.second);
        if (!made.blocks.empty()) out.metadata["coarse_blocks"] = made.blocks.text();
        return out;
    };
    int too_few = -1, enough = levels.blockCount();
    LightVolume best = with(enough);
    while (enough - too_few > 1 + levels.blockCount() / 200) {
        monitor.checkCancelled();
        const int middle = too_few + (enough - too_few) / 2;
        LightVolume tried = with(middle);
        if (runtimeSize(tried, texels).bytes <= budget_bytes) {
            enough = middle, best = std::move(tried);
        } else {
            too_few = middle;
        }
    }
    return best;
}

}  // namespace

std::vector<ExportPlan> exportPlans(const Scene* scene, ExportLevels levels, std::int64_t budget_bytes,
                                    GameTexels texels) {
    std::vector<ExportPlan> plans;
    for (const int factor : {1, 2, 4, 8, 16}) {
        plans.push_back({factor, {}});
        // A flat receiver's look-ups need a voxel on each side; more is for what moves near it.
        for (const int band : {8, 4, 2, 1}) {
            if (scene != nullptr) plans.push_back({factor, band});
        }
        if (levels == ExportLevels::Two) {
            ExportPlan two = plans.back();
            two.two_levels_in = budget_bytes;
            plans.push_back(two);
        }
    }
    for (ExportPlan& plan : plans) plan.texels = texels;
    return plans;
}

std::int64_t gameBytes(const LightVolume& volume, MemoryModel model) {
    if (model != MemoryModel::Dense)
        return runtimeSize(volume, model == MemoryModel::Runtime ? GameTexels::Halves : GameTexels::Bc6h).bytes;
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
    LightVolume out{
        std::move(lobes.first), volume.reference_irradiance, volume.has_irradiance, volume.has_direction, {},
        volume.metadata,        std::move(lobes.second)};
    if ((plan.band && scene != nullptr) || plan.two_levels_in > 0) {
        const glm::ivec3 shift = plan.shift ? *plan.shift : shiftOf(out, plan);
        if (shift != glm::ivec3(0)) {
            LobeFields there = moved({std::move(out.field), std::move(out.second)}, shift);
            out.field = std::move(there.first), out.second = std::move(there.second);
        }
    }
    if (plan.two_levels_in == 0 || !canHaveTwoLevels(repeatingVoxels(out), plan.texels)) return out;
    return inTwoLevels(std::move(out), plan.two_levels_in, plan.texels, monitor);
}

ExportPlan sharedPlan(const LightVolume& volume, ExportPlan plan, const Scene* scene, Monitor& monitor) {
    if (!plan.band && plan.two_levels_in == 0) return plan;
    ExportPlan unmoved = plan;
    unmoved.shift = glm::ivec3(0), unmoved.two_levels_in = 0;
    plan.shift = shiftOf(planned(volume, unmoved, scene, monitor), plan);
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
        const double widths = plans[i].factor * (plans[i].two_levels_in > 0 ? 2.0 : 1.0);
        const bool hopeless = !plans[i].band && everything / std::pow(widths, 3) > static_cast<double>(budget_bytes);
        if (hopeless && i + 1 < plans.size()) continue;
        monitor.progress("fit", static_cast<double>(i) / static_cast<double>(plans.size()));
        if (plans[i].factor != level_factor)
            level.emplace(planned(volume, ExportPlan{plans[i].factor, {}}, scene, monitor));
        level_factor = plans[i].factor;
        ExportPlan rest = plans[i];
        rest.factor = 1;
        bytes = rest.band || rest.two_levels_in > 0 ? gameBytes(planned(*level, rest, scene, monitor), model)
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
