// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/eikonal.h"

#include <fmt/format.h>

#include <cmath>

#include "bake/field/caustic_steps.h"
#include "bake/methods/eikonal_front.h"
#include "bake/methods/method_options.h"
#include "bake/paths/height_field_hit.h"
#include "bake/report/error.h"
#include "bake/report/stopwatch.h"
#include "bake/scene/crest_warnings.h"
#include "bake/scene/index_volume.h"
#include "bake/scene/not_built.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

const std::vector<OptionBinding<EikonalOptions>>& eikonalOptions() {
    static const std::vector<OptionBinding<EikonalOptions>> bindings{
        bindOption("preset", &EikonalOptions::preset,
                   {{"exact", EikonalPreset::Exact}, {"mercier", EikonalPreset::Mercier}},
                   "exact: finite index and the smooth surface; mercier: the paper's infinite index, vertex splats, "
                   "first order, boundary "
                   "costs and dissipation"),
        bindOption("solver", &EikonalOptions::solver,
                   {{"auto", EikonalSolver::Auto},
                    {"foot_points", EikonalSolver::FootPoints},
                    {"marching", EikonalSolver::Marching}},
                   "foot points on the surface, or fast marching from seeds beside it; auto takes foot points"),
        bindOption("beyond", &EikonalOptions::beyond,
                   {{"first_arrival", EikonalBeyond::FirstArrival}, {"dark", EikonalBeyond::Dark}},
                   "irradiance past the first caustic: that of the first arrival, or none"),
        bindOption("order", &EikonalOptions::order, {1, 2}, "", "of the differences when marching"),
        bindOption("vertex_spacing", &EikonalOptions::vertex_spacing, {0.01, 8}, "voxels",
                   "of the mesh whose vertices seed the paper's preset"),
        bindOption("threshold", &EikonalOptions::threshold, {0, 1}, "",
                   "of the depth below the surface, where the paper's dissipation begins; 1: never"),
        bindOption("dissipation_speed", &EikonalOptions::dissipation_speed, {0, 0.7}, "voxels",
                   "that the paper's dissipating waves run in each layer"),
    };
    return bindings;
}

std::string eikonalRefusal(const Scene& scene) {
    if (std::string why = notBuiltYet(scene); !why.empty()) return why;
    if (scene.lights.size() != 1)
        return fmt::format("it bakes one light, and the scene has {} lights; bake one volume a light, or use beams",
                           scene.lights.size());
    if (scene.surfaces.size() != 1)
        return fmt::format("it bakes one height field, and the scene has {} surfaces; use beams",
                           scene.surfaces.size());
    const Surface& surface = scene.surfaces.front();
    if (!surface.height_field)
        return fmt::format("surface '{}' is a mesh, and fronts start on height fields; use beams", surface.name);
    if (surface.event != SurfaceEvent::Refract)
        return fmt::format("surface '{}' reflects, and fronts go on below; use event = \"refract\" or beams",
                           surface.name);
    if (surface.ior_below < surface.ior_above)
        return fmt::format("'{}' has ior_below {} under ior_above {}, where light can be reflected totally; use beams",
                           surface.name, surface.ior_below, surface.ior_above);
    if (standsBelow(scene.lights.front(), surface))
        return fmt::format("the light '{}' stands in the water, and fronts start above it; use beams",
                           scene.lights.front().name);
    if (scene.lights.front().direction.z >= 0) return "the light comes from below; use beams";
    if (scene.index && scene.index->least() < surface.ior_above)
        return fmt::format("the [[index]] goes down to {:.4g} under ior_above {}, where light can be reflected totally",
                           scene.index->least(), surface.ior_above);
    if (scene.bake.paths == Paths::All) return "paths = \"all\" is not built yet; use paths = \"caustic\"";
    return {};
}

void describe(const EikonalFields& fields, const EikonalOptions& options, const CausticMap* caustics,
              BakeResult& result) {
    auto& meta = result.metadata;
    // Power is not followed: first arrivals leave out what comes later.
    meta["ledger"] = "";
    meta["arrivals"] = "first";
    meta["solver_bytes_a_voxel"] =
        fmt::format("{:.2f}", fields.solver_bytes / double(std::max<std::int64_t>(1, result.field.needed().count())));
    meta["caustic_kind"] =
        options.preset == EikonalPreset::Mercier
            ? "curvature of the front [1/m], positive where light converges, dissipated below the threshold"
            : "curvature of the front [1/m]: negative where light converges";
    if (!caustics) return;
    meta["first_caustic_z"] = fmt::format("{:.6g}", caustics->highestFocus());
    // Marching does not ask which voxels lie past it.
    if (fields.below > 0)
        meta["single_arrival_fraction"] = fmt::format("{:.4f}", double(fields.single) / double(fields.below));
}

bool marches(const Scene& scene, const EikonalOptions& options) {
    return options.preset == EikonalPreset::Mercier || options.solver == EikonalSolver::Marching || scene.index;
}

MethodCost eikonalCost(const CostQuestion& question) {
    EikonalOptions options;
    applyOptions<EikonalOptions>("eikonal", options, eikonalOptions(), question.options);
    // Seconds of a voxel, or of a column of them, on one thread of a 2.6 GHz server core.
    constexpr double kFootPoints = 2.2e-7, kSeeds = 1e-6, kMarching = 5e-7, kDissipation = 2e-8, kIndexVaries = 3;
    const double voxels = question.needed_voxels, columns = double(question.frame.size().x) * question.frame.size().y;
    MethodCost cost;
    cost.stages = {{"surface", columns * kSeeds}};
    if (!marches(question.scene, options)) {
        cost.stages.push_back({"foot points", voxels * kFootPoints});
        return cost;
    }
    cost.stages.push_back({"seeds", columns * kSeeds});
    cost.stages.push_back({"marching", voxels * kMarching * (question.scene.index ? kIndexVaries : 1)});
    if (options.preset == EikonalPreset::Mercier)
        cost.stages.push_back({"dissipation", voxels * kDissipation});
    else if (!question.scene.index)
        cost.dearest = "most of the time goes into marching: solver = \"foot_points\" is quicker";
    return cost;
}

/// What the options cannot do in this scene.
void checkTogether(const Scene& scene, const EikonalOptions& options, bool marching, const GivenOptions& given) {
    const auto refuse = [&](const char* option, const char* why) {
        throw Error(ErrorCode::Input, why, given.at(option).where);
    };
    if (scene.index && options.preset == EikonalPreset::Mercier)
        refuse("preset",
               "preset = \"mercier\" is the paper's infinite index, and the scene has an [[index]]; use exact");
    if (scene.index && options.solver == EikonalSolver::FootPoints)
        refuse("solver",
               "foot points need a constant index, and the scene has an [[index]]; use solver = \"marching\"");
    if (marching && options.beyond == EikonalBeyond::Dark)
        refuse("beyond",
               "marching does not know which voxels lie past a caustic; use solver = \"foot_points\" with "
               "beyond = \"dark\"");
}

/// Says what a front leaves out of the scene.
void sayWhatIsLeftOut(const Scene& scene, BakeReport& report, Monitor& monitor) {
    for (const Object& object : scene.objects)
        if (object.blocks() && !std::holds_alternative<Plane>(object.shape)) {
            monitor.warn("a front goes through objects: '" + object.name + "' casts no shadow; beams know shadows");
            break;
        }
    for (const std::string& warning : crestWarnings(scene)) monitor.warn(warning);
    if (scene.lights.front().angular_diameter_deg > 0)
        report.skipped.emplace_back("the sun's disc: a front has one direction");
}

/// Where several arrivals meet, if irradiance is asked for and rays are straight.
std::optional<CausticMap> causticsOf(const Scene& scene, const EikonalFront& front, const EikonalOptions& options,
                                     double voxel, BakeReport& report) {
    std::optional<CausticMap> caustics;
    if (scene.bake.grids.irradiance && options.preset != EikonalPreset::Mercier && !scene.index)
        caustics.emplace(front, voxel);
    else
        report.skipped.emplace_back(scene.index ? "where several arrivals meet: rays bend on their way"
                                                : "where several arrivals meet: irradiance is not asked for");
    return caustics;
}

EikonalFields emptyFields(const Scene& scene, const std::shared_ptr<const NeededVoxels>& needed) {
    EikonalFields fields{LightField(needed, {scene.coloured() ? 3 : 1, true}), std::nullopt, std::nullopt};
    if (scene.bake.grids.caustic) fields.caustic.emplace(needed, FieldChannels{1, false});
    if (scene.bake.grids.arrival_time) fields.arrival.emplace(needed, FieldChannels{1, false});
    return fields;
}

/// The preset's: the caustic grid ends at a depth.
void dissipate(const EikonalFront& front, const EikonalOptions& options, LightField& caustic) {
    const GridFrame& frame = caustic.frame();
    const double level = front.surface().center.z, bottom = frame.worldFromIndex(glm::dvec3(frame.min)).z;
    dissipateCaustic(caustic, level + options.threshold * (bottom - level), options.dissipation_speed);
}

BakeResult bakeEikonal(const Scene& scene, std::shared_ptr<const NeededVoxels> needed, const GivenOptions& given,
                       Monitor& monitor) {
    EikonalOptions options;
    applyOptions<EikonalOptions>("eikonal", options, eikonalOptions(), given);
    const bool mercier = options.preset == EikonalPreset::Mercier;
    const bool marching = marches(scene, options);
    checkTogether(scene, options, marching, given);
    const GridFrame& frame = needed->frame();
    Stopwatch watch;

    BakeReport report;
    sayWhatIsLeftOut(scene, report, monitor);
    const EikonalFront front(scene, options, frame);
    const std::optional<CausticMap> caustics = causticsOf(scene, front, options, frame.worldFromIndex()[0].x, report);
    if (scene.index)
        monitor.warn(
            "irradiance is that of the first arrival; where rays that the index bends have crossed, others are "
            "missing");
    report.seconds.emplace_back("surface", watch.lap());

    EikonalFields fields = emptyFields(scene, needed);
    if (marching) {
        bakeByMarching({scene, front, options, monitor}, fields, report);
        report.seconds.emplace_back("marching", watch.lap());
        if (mercier && fields.caustic && options.threshold < 1) {
            dissipate(front, options, *fields.caustic);
            report.seconds.emplace_back("dissipation", watch.lap());
        }
    } else {
        bakeByFootPoints({scene, front, options, monitor}, caustics ? &*caustics : nullptr, fields);
        report.seconds.emplace_back("foot points", watch.lap());
    }
    if (scene.bake.grids.irradiance && fields.single < fields.below && options.beyond == EikonalBeyond::FirstArrival) {
        monitor.warn(fmt::format(
            "irradiance is that of the first arrival, and {:.1f} % of the water has several; beams sum them all",
            100 * (1 - double(fields.single) / double(fields.below))));
    }
    BakeResult result{std::move(fields.light), std::move(report)};
    describe(fields, options, caustics ? &*caustics : nullptr, result);
    result.caustic = std::move(fields.caustic), result.arrival_time = std::move(fields.arrival);
    return result;
}

}  // namespace

Method eikonalMethod() {
    return {
        "eikonal",
        "Fast marching and foot points: curvature, direction, first arrival and its irradiance below one height field",
        {"irradiance", "direction", "caustic", "arrival_time"},
        optionSpecs<EikonalOptions>(eikonalOptions()),
        eikonalRefusal,
        eikonalCost,
        bakeEikonal};
}

}  // namespace photic
