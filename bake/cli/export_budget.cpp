// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/export_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "bake/field/coarsen.h"
#include "bake/field/resample.h"
#include "bake/field/scene_needed_voxels.h"
#include "bake/file/runtime_size.h"
#include "bake/file/voxel_box.h"
#include "bake/file/voxel_encoding.h"
#include "bake/picture/receiver_picture.h"
#include "bake/report/error.h"

namespace photic::cli {

namespace {

constexpr int kVoxels = LightField::kLeafVoxels;

/// The field's voxels that are in `kept` too.
LightField restricted(const LightField& field, const NeededVoxels& kept) {
    NeededVoxels needed = NeededVoxels::none(field.frame());
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        if (field.state(slot) == LeafState::Empty) continue;
        const glm::ivec3 origin = field.needed().leafOrigin(slot);
        const int other = kept.slotOf(origin);
        if (other < 0) continue;
        NeededVoxels::Mask mask = field.needed().mask(slot);
        for (std::size_t w = 0; w < mask.size(); ++w) mask[w] &= kept.mask(other)[w];
        needed.addLeaf(origin, mask);
    }
    needed.finish();
    LightField out(std::make_shared<const NeededVoxels>(std::move(needed)), field.channels());
    forEachLeaf(out.needed(), [&](int slot) {
        const int from = field.needed().slotOf(out.needed().leafOrigin(slot));
        if (field.state(from) == LeafState::Constant) {
            out.setConstant(slot, field.constant(from));
        } else {
            std::copy_n(field.dense(from), field.channels().count() * kVoxels, out.makeDense(slot));
        }
    });
    return out;
}

/// As textures hold it: half floats in units of the reference.
LightField roundedToHalves(const LightField& field, double reference) {
    LightField out(field.neededPtr(), field.channels());
    const auto scale = static_cast<float>(1 / reference), back = static_cast<float>(reference);
    const int values = field.channels().count() * kVoxels;
    forEachLeaf(field.needed(), [&](int slot) {
        if (field.state(slot) == LeafState::Empty) return;
        float* to = out.makeDense(slot);
        for (int i = 0; i < values; ++i) {
            const float v = field.state(slot) == LeafState::Dense
                                ? field.dense(slot)[i]
                                : field.constant(slot)[static_cast<std::size_t>(i / kVoxels)];
            to[i] = halfPrecision(v * scale) * back;
        }
    });
    return out;
}

/// Sums that give relative errors.
struct Difference {
    double absolute = 0, squared = 0, reference = 0, count = 0;
    void add(double value, double truth) {
        const double d = value - truth;
        absolute += std::fabs(d), squared += d * d, reference += std::fabs(truth), count += 1;
    }
    double relativeL1() const { return reference > 0 ? absolute / reference : 0; }
    /// Root mean square over the mean.
    double relativeRmse() const { return reference > 0 ? std::sqrt(squared / count) / (reference / count) : 0; }
};

double meanOf(const std::array<float, 8>& sample, int channels) {
    double sum = 0;
    for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) sum += double(sample[c]);
    return sum / channels;
}

/// The R3 sequence (Roberts): even spread in 0..1.
glm::dvec3 spread(std::int64_t n) {
    const auto part = [n](double step) { return std::fmod(0.5 + static_cast<double>(n) * step, 1.0); };
    return {part(0.8191725134), part(0.6710436067), part(0.5497004779)};
}

/// Whether the voxels with light that a look-up in `source` reads at a point are kept in `exported`.
bool keptAround(const LightField& source, const LightField& exported, const glm::dmat3& index_from_world,
                const glm::dvec3& point) {
    const glm::ivec3 below(glm::floor(point));
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 voxel = below + glm::ivec3(corner >> 2, corner >> 1 & 1, corner & 1);
        if (!source.needed().contains(voxel)) continue;
        const glm::dvec3 there =
            index_from_world * (source.frame().worldFromIndex(voxel) - exported.frame().origin_world);
        if (!exported.needed().contains(glm::ivec3(glm::floor(there + 0.5)))) return false;
    }
    return true;
}

Json volumeError(const LightField& source, const LightField& exported) {
    constexpr std::int64_t kMostSamples = 1000000;
    const std::int64_t stride = source.needed().count() / kMostSamples + 1;
    const GridFrame &from = source.frame(), &to = exported.frame();
    const glm::dmat3& index_from_world = to.indexFromWorld();
    Difference difference;
    double kept = 0, all = 0;
    std::int64_t n = 0;
    for (int slot = 0; slot < source.leafCount(); ++slot) {
        if (source.state(slot) == LeafState::Empty) continue;
        const auto& mask = source.needed().mask(slot);
        const glm::ivec3 origin = source.needed().leafOrigin(slot);
        for (int i = 0; i < kVoxels; ++i) {
            if (!NeededVoxels::maskBit(mask, i) || n++ % stride != 0) continue;
            const glm::ivec3 voxel = origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            const double light = source.irradiance(voxel);
            all += light;
            const glm::dvec3 here = index_from_world * (from.worldFromIndex(voxel) - to.origin_world);
            if (!exported.needed().contains(glm::ivec3(glm::floor(here + 0.5)))) continue;
            kept += light;
            const glm::dvec3 point = glm::dvec3(voxel) + spread(n) - 0.5;
            if (!keptAround(source, exported, index_from_world, point)) continue;
            const double truth = meanOf(sampleTrilinear(source, point), source.channels().irradiance);
            const auto sample =
                sampleTrilinear(exported, index_from_world * (from.worldFromIndex(point) - to.origin_world));
            difference.add(meanOf(sample, exported.channels().irradiance), truth);
        }
    }
    return {{"relative_l1", difference.relativeL1()},
            {"relative_rmse", difference.relativeRmse()},
            {"samples", static_cast<std::int64_t>(difference.count)},
            {"light_kept", all > 0 ? kept / all : 1.0}};
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
    return denseTextureBytes(std::int64_t{size.x} * size.y * size.z, volume.field.channels());
}

LightVolume planned(const LightVolume& volume, const ExportPlan& plan, const Scene* scene, Terminal& terminal) {
    LightField field = plan.factor > 1 ? coarsened(volume.field, plan.factor, terminal)
                                       : restricted(volume.field, volume.field.needed());
    if (plan.band && scene != nullptr) {
        Scene narrowed = *scene;
        narrowed.bake.where = Where::Receivers;
        narrowed.bake.band = *plan.band;
        field = restricted(field, sceneNeededVoxels(narrowed, field.frame(), terminal));
    }
    return {std::move(field), volume.reference_irradiance, volume.has_irradiance, volume.has_direction, {},
            volume.metadata};
}

ExportPlan sharedPlan(const LightVolume& volume, ExportPlan plan, const Scene* scene, Terminal& terminal) {
    if (!plan.band) return plan;
    plan.shift = glm::ivec3(0);
    plan.shift = fewestBricksShift(planned(volume, plan, scene, terminal));
    return plan;
}

std::size_t fittingPlan(const LightVolume& volume, const std::vector<ExportPlan>& plans, std::size_t first,
                        std::int64_t budget_bytes, MemoryModel model, const Scene* scene, Terminal& terminal) {
    const auto everything = static_cast<double>(gameBytes(volume, model));
    std::int64_t bytes = 0;
    std::optional<LightVolume> level;  // at the resolution of plans[i], everything kept
    int level_factor = 0;
    for (std::size_t i = first; i < plans.size(); ++i) {
        terminal.checkCancelled();
        // Coarser voxels save their number at most: what cannot fit is not tried.
        const bool hopeless =
            !plans[i].band && everything / std::pow(plans[i].factor, 3) > static_cast<double>(budget_bytes);
        if (hopeless && i + 1 < plans.size()) continue;
        terminal.progress("fit", static_cast<double>(i) / static_cast<double>(plans.size()));
        if (plans[i].factor != level_factor) level.emplace(planned(volume, {plans[i].factor, {}}, scene, terminal));
        level_factor = plans[i].factor;
        bytes = plans[i].band ? gameBytes(planned(*level, {1, plans[i].band}, scene, terminal), model)
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

Json exportError(const LightVolume& source, const LightVolume& exported, const Scene* scene) {
    LightVolume rounded{roundedToHalves(exported.field, exported.reference_irradiance),
                        exported.reference_irradiance,
                        true,
                        exported.has_direction,
                        {},
                        {}};
    Json receivers = Json::array();
    constexpr int kTexels = 512;
    for (const std::string& name : scene != nullptr ? planarReceivers(*scene) : std::vector<std::string>{}) {
        const PictureFrame frame = receiverFrame(*scene, name, kTexels);
        const Image truth = receiverPicture(source, frame), picture = receiverPicture(rounded, frame);
        Difference difference;
        for (std::size_t i = 0; i < truth.pixels.size(); ++i)
            difference.add(double(picture.pixels[i]), double(truth.pixels[i]));
        receivers.push_back(
            {{"name", name}, {"relative_l1", difference.relativeL1()}, {"relative_rmse", difference.relativeRmse()}});
    }
    return {{"volume", volumeError(source.field, rounded.field)}, {"receivers", receivers}};
}

std::string errorText(const Json& error) {
    const auto percent = [](const Json& of) {
        return fmt::format("{:.3g} % (L1), {:.3g} % (RMSE)", 100 * of["relative_l1"].get<double>(),
                           100 * of["relative_rmse"].get<double>());
    };
    std::string text = fmt::format("error of irradiance {} in the voxels kept, which hold {:.1f} % of the light",
                                   percent(error["volume"]), 100 * error["volume"]["light_kept"].get<double>());
    for (const Json& receiver : error["receivers"])
        text += fmt::format("; on {} {}", receiver["name"].get<std::string>(), percent(receiver));
    return text;
}

}  // namespace photic::cli
