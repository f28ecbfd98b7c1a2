// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/bake_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <memory>
#include <mutex>
#include <utility>

#include "bake/baker/bake_cost.h"
#include "bake/baker/dark_bake.h"
#include "bake/baker/lookup_advice.h"
#include "bake/baker/lookup_error.h"
#include "bake/baker/machine_speed.h"
#include "bake/baker/post_steps.h"
#include "bake/baker/report_json.h"
#include "bake/baker/version.h"
#include "bake/field/density.h"
#include "bake/field/grid_laws.h"
#include "bake/field/lobes.h"
#include "bake/field/prefilter.h"
#include "bake/field/scene_grid.h"
#include "bake/field/scene_needed_voxels.h"
#include "bake/methods/kept_shapes.h"
#include "bake/methods/lobe_axis.h"
#include "bake/report/stopwatch.h"
#include "bake/scene/plausibility.h"
#include "bake/scene/setting_names.h"
#include "bake/simd/instruction_set.h"
#include "bake/threads/parallel_for.h"

namespace photic {

namespace {

/// Hands everything on, and remembers the warnings, each once.
class RememberingMonitor final : public Monitor {
public:
    explicit RememberingMonitor(Monitor& to) : to_(to) {}
    void progress(std::string_view stage, double fraction) override { to_.progress(stage, fraction); }
    bool cancelled() const override { return to_.cancelled(); }
    void warn(const std::string& message) override {
        {
            const std::lock_guard lock(mutex_);
            if (std::find(warnings_.begin(), warnings_.end(), message) != warnings_.end()) return;
            warnings_.push_back(message);
        }
        to_.warn(message);
    }
    std::vector<std::string> takeWarnings() { return std::move(warnings_); }

private:
    Monitor& to_;
    std::mutex mutex_;
    std::vector<std::string> warnings_;
};

/// After how much [m] along x and y the light repeats, or 0: the water does, nothing that blocks breaks it, and a whole
/// period is in the box.
glm::dvec2 periodOfLight(const Scene& scene) {
    if (scene.surfaces.empty()) return glm::dvec2(0);
    const glm::dvec2 period = scene.surfaces.front().size;
    for (const Surface& surface : scene.surfaces) {
        if (!surface.height_field || surface.outside != Outside::Periodic || surface.size != period)
            return glm::dvec2(0);
    }
    for (const Object& object : scene.objects) {
        const Plane* plane = std::get_if<Plane>(&object.shape);
        if (object.blocks() && (!plane || plane->normal.x != 0 || plane->normal.y != 0)) return glm::dvec2(0);
    }
    const glm::dvec2 size(scene.domain.max - scene.domain.min);
    const double half_voxel = 0.5 * scene.domain.voxel_size;
    return size.x + half_voxel >= period.x && size.y + half_voxel >= period.y ? period : glm::dvec2(0);
}

/// Of the medium that receivers stand in: below the first open surface that lets light in. A closed body is something
/// in that medium; with such bodies alone, receivers stand outside of them.
double iorOfMedium(const Scene& scene) {
    const auto isBody = [](const Surface& s) { return s.closed || s.sphere.has_value() || s.thin; };
    for (const Surface& surface : scene.surfaces) {
        const bool lets_in = surface.event == SurfaceEvent::Refract || surface.event == SurfaceEvent::Both;
        if (lets_in && !isBody(surface)) return sideOf(scene, surface, Side::Below).ior.mean();
    }
    for (const Surface& surface : scene.surfaces)
        if (isBody(surface)) return sideOf(scene, surface, Side::Above).ior.mean();
    return 1.0;
}

/// A number, or the three of its channels where they differ.
std::string perChannel(const glm::dvec3& v) {
    return v.x == v.y && v.y == v.z ? fmt::format("{}", v.x) : fmt::format("[{},{},{}]", v.x, v.y, v.z);
}

/// What a reader of the volume needs to know of its scene and its bake.
std::map<std::string, std::string> metadataOf(const Scene& scene, const Method& method, const BakeChoices& choices,
                                              const BakeResult& result) {
    std::map<std::string, std::string> metadata{
        {"version", "1"},
        {"program", programName()},
        {"method", method.name},
        {"options", settingsText(scene, method, choices)},
        {"paths", nameOf(scene.bake.paths)},
        {"quadrature", fmt::format("{}", scene.bake.quadrature)},
        {"prefilter", scene.bake.prefilter ? "true" : "false"},
        {"reference_irradiance", fmt::format("{}", scene.referenceIrradiance())},
        {"ior", fmt::format("{}", iorOfMedium(scene))},
        {"up_axis", "Z"},
        {"frame", fmt::format("{}", scene.frame)},
        {"ledger", ledgerText(result.report)},
        {"scene_hash", inputHash(scene, method, choices)}};
    if (choices.tile) metadata["tile"] = tileText(result.field.needed(), *choices.tile);
    if (scene.medium.present()) {
        metadata["scattering"] = perChannel(scene.medium.scattering);
        metadata["absorption"] = perChannel(scene.medium.absorption);
        metadata["anisotropy"] = fmt::format("{}", scene.medium.anisotropy);
    }
    if (const glm::dvec2 period = periodOfLight(scene); period != glm::dvec2(0))
        metadata["period"] = fmt::format("[{},{},0]", period.x, period.y);
    for (const auto& [name, text] : result.metadata) {
        if (text.empty()) {
            metadata.erase(name);
        } else {
            metadata[name] = text;
        }
    }
    return metadata;
}

/// A volume from a result whose field and grids are moved out.
LightVolume makeVolume(const Scene& scene, std::map<std::string, std::string> metadata, BakeResult& result) {
    const GridSet& grids = scene.bake.grids;
    LightVolume volume{std::move(result.field), scene.referenceIrradiance(), grids.irradiance, grids.direction, {},
                       std::move(metadata)};
    volume.second = std::move(result.second);
    if (grids.caustic && result.caustic) volume.scalars.emplace("caustic", std::move(*result.caustic));
    if (grids.arrival_time && result.arrival_time)
        volume.scalars.emplace("arrival_time", std::move(*result.arrival_time));
    if (grids.density) volume.scalars.emplace("density", mediumDensity(scene, volume.field.neededPtr()));
    return volume;
}

std::optional<LightVolume> makeStandardError(const Scene& scene, const Method& method, const BakeChoices& choices,
                                             BakeResult& result) {
    if (!result.standard_error) return std::nullopt;
    LightVolume volume{std::move(*result.standard_error), scene.referenceIrradiance(), true, false, {}, {}};
    volume.metadata = {{"version", "1"},
                       {"method", method.name},
                       {"quantity", "standard error of the mean irradiance"},
                       {"frame", fmt::format("{}", scene.frame)},
                       {"scene_hash", inputHash(scene, method, choices)}};
    if (choices.tile) volume.metadata["tile"] = tileText(volume.field.needed(), *choices.tile);
    if (result.path_count) volume.scalars.emplace("path_count", std::move(*result.path_count));
    return volume;
}

/// Warns of planar receivers so close to the grid's edge that trilinear look-ups on them lose light: they need a voxel
/// behind.
void warnOfReceiversAtTheEdge(const Scene& scene, const GridFrame& frame, Monitor& monitor) {
    std::vector<std::string> names;
    const glm::dvec3 middle = frame.worldFromIndex(0.5 * glm::dvec3(frame.min + frame.max));
    for (const Object& object : scene.objects) {
        const Plane* plane = std::get_if<Plane>(&object.shape);
        if (!object.receives() || !plane) continue;
        // Along the axis that the receiver faces, both neighbours of a look-up must be voxels of the grid. It is met on
        // the line through the box's middle.
        const glm::dvec3 facing = frame.indexNormal(plane->normal), size = glm::abs(facing);
        const int axis = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
        const double index =
            0.5 * (frame.min[axis] + frame.max[axis]) + glm::dot(plane->point - middle, plane->normal) / facing[axis];
        const bool in_box = index >= frame.min[axis] - 0.5 && index <= frame.max[axis] + 0.5;
        if (in_box && (index < frame.min[axis] || index > frame.max[axis])) names.push_back(object.name);
    }
    if (names.empty()) return;
    monitor.warn(
        fmt::format("{} lie{} at the edge of the domain: look-ups there find up to half of the light; extend "
                    "[domain] by two voxels behind",
                    fmt::join(names, ", "), names.size() == 1 ? "s" : ""));
}

/// Says what of the light that is about to be handed on cannot be: the checks of `photic inspect`.
void warnOfBrokenLaws(const LightVolume& volume, Monitor& monitor) {
    std::vector<LawCheck> broken = brokenLaws(volume.field);
    if (volume.second)
        for (LawCheck& law : brokenLaws(*volume.second)) broken.push_back(std::move(law));
    for (const LawCheck& law : broken) {
        monitor.warn(
            fmt::format("the light breaks the law '{}': {:.3g}, and at most {:.3g} is allowed; please report "
                        "this scene as a bug",
                        law.name, law.value, law.limit));
    }
}

/// Says what is lost where several beams meet in one voxel, which keeps one direction.
void warnOfOpposedLight(const Scene& scene, const LightVolume& volume, Monitor& monitor) {
    // One sun through one surface keeps its direction but for the slopes of the water.
    if (!volume.has_direction || !lightCanOppose(scene)) return;
    constexpr double kWorthSaying = 0.05;
    const OpposedLight opposed = opposedLight(volume.field, volume.second ? &*volume.second : nullptr);
    if (opposed.share < kWorthSaying) return;
    monitor.warn(fmt::format(
        "{:.2g} % of the light lies where rays cross from directions far apart, and a voxel keeps {}: walls "
        "along {} are handed too little, by up to {:.2g} % of the light that passes. For the walls, {}",
        100 * opposed.share, volume.second ? "two" : "one, their mean", volume.second ? "them" : "it",
        100 * opposed.lost,
        scene.bake.lobes < 2      ? "bake with lobes = 2"
        : scene.lights.size() > 1 ? "bake each light into a volume of its own"
                                  : "there is no cure yet"));
}

/// Says what of the light was not followed to its end, where that is more than a rim or an edge.
void warnOfLightGivenUp(const Scene& scene, const PowerLedger& power, Monitor& monitor) {
    if (!(power.emitted > 0)) return;
    constexpr double kReflected = 0.1, kDropped = 0.1;  // of the light
    std::vector<std::string> only_refract;
    for (const Surface& surface : scene.surfaces)
        if (surface.event == SurfaceEvent::Refract) only_refract.push_back("'" + surface.name + "'");
    // What a single water turns back is known from every lake.
    if (scene.surfaces.size() > 1 && !only_refract.empty() && power.reflected > kReflected * power.emitted)
        monitor.warn(fmt::format(
            "{:.3g} W, {:.2g} % of the light, is reflected at surfaces that only refract ({}), and is not in the "
            "volume; event = \"both\" follows it",
            power.reflected, 100 * power.reflected / power.emitted, fmt::join(only_refract, ", ")));
    if (power.dropped > kDropped * power.emitted)
        monitor.warn(
            fmt::format("{:.3g} W, {:.2g} % of the light, is not followed to its end: it meets too many "
                        "surfaces, or is too faint; more 'bounces' and a smaller 'threshold' follow it farther",
                        power.dropped, 100 * power.dropped / power.emitted));
}

bool isDark(const BakeResult& result) {
    const LightField& field = result.field;
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        if (field.state(slot) == LeafState::Empty) continue;
        const bool dense = field.state(slot) == LeafState::Dense;
        const float* values = dense ? field.dense(slot) : field.constant(slot).data();
        const int count = field.channels().irradiance * (dense ? LightField::kLeafVoxels : 1);
        if (std::any_of(values, values + count, [](float light) { return light > 0; })) return false;
    }
    return !result.second;
}

/// What every method leaves out for the same reasons.
std::vector<std::string> skippedByAsking(const Scene& scene, const NeededVoxels& needed) {
    std::vector<std::string> skipped;
    if (!scene.bake.grids.direction) skipped.emplace_back("direction: not asked for");
    if (!scene.coloured()) skipped.emplace_back("colour: light and medium are white");
    if (!needed.whole().isEverything())
        skipped.push_back(
            fmt::format("{} voxels that nobody needs", needed.frame().voxelCount() - needed.whole().count()));
    return skipped;
}

/// The scene with an axis that parts its light, where there is light to part and no axis is given.
Scene withLobeAxis(const Scene& scene, const GridFrame& frame) {
    Scene parted = scene;
    BakeSettings& bake = parted.bake;
    if (bake.lobes < 2 || !bake.grids.direction) {
        bake.lobe_axis.reset();
    } else if (!bake.lobe_axis) {
        bake.lobe_axis = lobeAxis(scene, frame);
    }
    return parted;
}

/// Runs the method; what needs no lobe of its own joins the first.
BakeResult bakeLobes(const Scene& parted, const Method& method, const std::shared_ptr<const NeededVoxels>& needed,
                     const GivenOptions& options, Monitor& monitor) {
    constexpr double kFaint = 1e-4;  // of the reference: not looked at
    BakeResult result = method.bake(parted, needed, options, monitor);
    if (!result.second) return result;
    LobeFields lobes{std::move(result.field), std::move(result.second)};
    keepOpposedLight(lobes, kFaint * parted.referenceIrradiance());
    result.field = std::move(lobes.first), result.second = std::move(lobes.second);
    if (result.second) {
        const glm::dvec3& axis = *parted.bake.lobe_axis;
        result.metadata["lobe_axis"] = fmt::format("[{},{},{}]", axis.x + 0.0, axis.y + 0.0, axis.z + 0.0);
    }
    return result;
}

/// Measures look-ups on receivers, for the report and for whoever reads the volume.
MeasuredReceivers measure(const Scene& scene, const Method& method, const BakeCost& cost, const BakeChoices& choices,
                          BakedScene& baked, Monitor& monitor) {
    MeasuredReceivers measured =
        measureReceivers(scene, baked.volume, choices.detail, cost.bake_seconds, choices.measure, monitor);
    BakeReport& report = baked.report;
    report.receivers = measured.errors;
    report.advice = adviceFor(scene, method, measured, choices, monitor);
    if (!measured.not_measured.empty()) report.skipped.push_back("look-ups are not measured: " + measured.not_measured);
    if (!report.receivers.empty()) baked.volume.metadata["receiver_errors"] = receiverErrorsText(report.receivers);
    return measured;
}

/// The voxels of the scene's frame that are needed, once the machine is known to hold them.
std::shared_ptr<const NeededVoxels> findNeeded(const Scene& scene, const Method& method, const BakeChoices& choices,
                                               Monitor& monitor) {
    // The box alone may be more than the machine can hold: find out before a table of it is made.
    constexpr std::int64_t kManyVoxels = 100000000;
    const GridFrame frame = sceneFrame(scene);
    if (scene.bake.where == Where::Everywhere && frame.voxelCount() > kManyVoxels && !choices.tile)
        checkMemory(bakeCost(scene, method, frame, nullptr, choices), choices);
    for (const std::string& warning : sceneWarnings(scene)) monitor.warn(warning);
    warnOfReceiversAtTheEdge(scene, frame, monitor);
    monitor.progress("needed", 0);
    return std::make_shared<const NeededVoxels>(sceneNeededVoxels(scene, frame, monitor));
}

/// What every method's report has.
void fillReport(const Scene& scene, const NeededVoxels& needed, double needed_seconds, BakeReport& report) {
    report.reference_irradiance = scene.referenceIrradiance();
    report.needed_voxels = needed.tileCount();
    report.threads = threadCount();
    report.instruction_set = name(bestInstructionSet());
    report.seconds.insert(report.seconds.begin(), {"needed", needed_seconds});
    const std::vector<std::string> skipped = skippedByAsking(scene, needed);
    report.skipped.insert(report.skipped.begin(), skipped.begin(), skipped.end());
}

/// Inverts the blur of trilinear look-ups.
void prefilter(BakeResult& result, Monitor& monitor) {
    const Stopwatch watch;
    monitor.progress("prefilter", 0);
    prefilterForTrilinear(result.field);
    if (result.second) prefilterForTrilinear(*result.second);
    result.report.seconds.emplace_back("prefilter", watch.seconds());
    monitor.progress("prefilter", 1);
}

}  // namespace

BakedScene bakeScene(const Scene& scene, Monitor& caller, const BakeChoices& choices) {
    checkPostSteps(choices.post);
    machineSlowness();  // before this scene's shapes are kept
    RememberingMonitor monitor(caller);
    const KeptShapes shapes;
    Stopwatch watch;
    const Method& method = chooseMethod(scene.bake.method, scene);
    const GivenOptions& options = givenOptions(scene, method);
    checkMethodTables(scene);

    auto needed = findNeeded(scene, method, choices, monitor);
    if (choices.tile) needed = cutTile(scene, method, std::move(needed), *choices.tile, choices.post);
    const BakeCost cost = bakeCost(scene, method, needed->frame(), needed.get(), choices);
    checkMemory(cost, choices);
    if (choices.expect) choices.expect(cost.stages);
    monitor.progress("needed", 1);
    const double needed_seconds = watch.lap();

    const Scene parted = withLobeAxis(scene, needed->frame());
    BakeResult result = [&] {
        const int channels = (scene.coloured() ? 3 : 1) + (scene.bake.grids.direction ? 3 : 0);
        const KeptLight::Lent lent(choices.kept_light, *needed, channels, memoryLimit(choices) - cost.memory_bytes);
        return bakeLobes(parted, method, needed, options, monitor);
    }();
    monitor.checkCancelled();
    BakeReport& report = result.report;
    warnOfLightGivenUp(scene, report.power, monitor);
    if (scene.bake.grids.irradiance && !choices.tile && isDark(result)) monitor.warn(darkBakeWarning(report.power));
    fillReport(scene, *needed, needed_seconds, report);
    if (scene.bake.prefilter) prefilter(result, monitor);
    report.field_bytes = result.field.bytes() + (result.second ? result.second->bytes() : 0);

    std::optional<LightVolume> standard_error = makeStandardError(scene, method, choices, result);
    watch.lap();
    if (scene.bake.grids.density) monitor.progress("density", 0);
    LightVolume volume = makeVolume(scene, metadataOf(scene, method, choices, result), result);
    if (scene.bake.grids.density) report.seconds.emplace_back("density", watch.lap());
    applyPostSteps(choices.post, volume);
    warnOfBrokenLaws(volume, monitor);
    warnOfOpposedLight(scene, volume, monitor);
    BakedScene baked{std::move(volume), std::move(report), std::move(standard_error), {}};
    if (choices.measure != Measure::Nothing) {
        watch.lap();
        monitor.progress("measure", 0);
        baked.measured = measure(scene, method, cost, choices, baked, monitor);
        baked.report.seconds.emplace_back("measure", watch.lap());
        monitor.progress("measure", 1);
    }
    baked.report.warnings = monitor.takeWarnings();
    monitor.checkCancelled();
    return baked;
}

}  // namespace photic
