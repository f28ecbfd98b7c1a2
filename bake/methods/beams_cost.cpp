// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/beams_cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bake/deposit/deposit_work.h"
#include "bake/methods/disc_samples.h"
#include "bake/methods/sun_disc.h"
#include "bake/paths/launch_domain.h"
#include "bake/paths/optical_scene.h"
#include "bake/tubes/histories.h"

namespace photic {

namespace {

// Seconds of one thread of a 2.6 GHz server core, fitted to the examples and variants of them (docs/accuracy.md).
constexpr double kSecondsACell = 2.9e-7;       // of a lattice: its rays, by the row, and its tubes
constexpr double kSecondsATriangle = 1.1e-6;   // that is looked at one by one
constexpr double kSecondsASearch = 2.9e-6;     // of what stands between its corners
constexpr double kSecondsALeg = 1e-6;          // of a ray that is cast from a mesh or a sphere
constexpr double kSecondsATube = 3.4e-7;       // in a slab, at a point of its layers
constexpr double kSecondsAnEdgeCell = 6.3e-9;  // of four channels
constexpr double kSecondsAValue = 7e-9;        // summed in a voxel
constexpr double kSecondsABlurredValue = 7e-9;

// Triangles of a mesh, and blocks of a height field, that are launched to see what all take.
constexpr int kTriedTriangles = 48, kTriedBlocks = 192;

/// What all histories take that begin at one surface in one light.
struct Launched {
    double cells = 0, tubes = 0;
    double legs = 0, triangles = 0, searches = 0;  ///< cast, and looked at, one by one
    DepositWork deposit;
    double passes = 0;  ///< share of its light that passes the grid
};

/// Launches a few triangles or blocks for all. Where the disc is sampled the faint histories are followed for one
/// direction.
Launched launchedFrom(const CostQuestion& q, const OpticalScene& optics, int surface_index, const Light& light,
                      const BeamsOptions& options) {
    const Surface& surface = q.scene.surfaces[static_cast<std::size_t>(surface_index)];
    const std::vector<SpectralSample> spectrum = spectralSamples(options.wavelengths);
    const int directions = discDirections(optics, light, options);
    const std::vector<LightSample> samples = lightSamples(light, directions);
    const LaunchDomain domain = surface.height_field ? launchDomain(q.scene, surface, light, q.frame) : LaunchDomain{};
    DepositWork deposit;
    const VoxeliseOptions voxelise = voxeliseOptions(q.scene, options);
    const HistoryLauncher* launching = nullptr;
    const TubeSink count = [&](TubeSets&& sets) {
        for (const TubeSet& set : sets) deposit += depositWork(set, q.frame, voxelise) * launching->standsFor();
    };
    LaunchOptions launch = launchOptions(q.scene, options);
    launch.tubes.channels = q.scene.coloured() ? 3 : 1;
    launch.sampled = surface.height_field ? kTriedBlocks : kTriedTriangles;
    Monitor quiet;
    Launched all;
    FaintLight faint;
    for (const bool last : {false, true}) {
        const double like_it = last ? 1.0 : static_cast<double>(samples.size()) - 1;
        if (like_it == 0) continue;
        HistoryLauncher launcher(optics, spectrum, launch, followLimits(q.scene), count, quiet);
        launching = &launcher;
        launcher.shareFaint(samples.size() > 1 ? &faint : nullptr, last);
        LaunchTotals totals;
        deposit = {};
        launcher.launch(Emission(q.scene, surface_index, samples.front()), domain, totals);
        if (totals.triangles_launched == 0) continue;
        const double times =
            like_it * static_cast<double>(totals.triangles) / static_cast<double>(totals.triangles_launched);
        all.cells += surface.height_field ? 0.5 * like_it * static_cast<double>(totals.triangles) : 0;
        all.legs += times * static_cast<double>(totals.legs), all.tubes += times * static_cast<double>(totals.tubes);
        all.triangles += times * static_cast<double>(totals.added);
        all.searches += times * static_cast<double>(totals.searches);
        all.deposit += deposit * times;
        if (totals.power.emitted > 0) all.passes = totals.power.culled / totals.power.emitted;
    }
    return all;
}

/// @param needed    share of the frame's voxels that somebody needs: tubes cost nothing in sheets that nobody does
/// @param channels  that are summed
double secondsOf(const Launched& all, double needed, int channels) {
    return all.cells * kSecondsACell + all.legs * kSecondsALeg + all.triangles * kSecondsATriangle +
           all.searches * kSecondsASearch +
           needed * (all.deposit.tubes * kSecondsATube + all.deposit.cells * kSecondsAnEdgeCell * (channels / 4.0));
}

// Whether bodies bend light, or stand in it, so that it has outlines.
bool hasEdges(const Scene& scene) {
    return std::any_of(scene.surfaces.begin(), scene.surfaces.end(),
                       [](const Surface& surface) { return surface.height_field == nullptr; }) ||
           std::any_of(scene.objects.begin(), scene.objects.end(), [](const Object& object) {
               return object.blocks() && !std::holds_alternative<Plane>(object.shape);
           });
}

}  // namespace

BeamsDisc discFor(const Scene& scene, const Light& light, const GridFrame& frame, const BeamsOptions& options) {
    if (options.disc == BeamsDisc::Off || light.angular_diameter_deg <= 0) return BeamsDisc::Off;
    if (options.disc != BeamsDisc::Auto) return options.disc;
    return blurServes(scene, light, frame) ? BeamsDisc::Blur : BeamsDisc::Sample;
}

int discDirections(const OpticalScene& optics, const Light& light, const BeamsOptions& options) {
    if (discFor(optics.scene(), light, optics.frame(), options) != BeamsDisc::Sample) return 1;
    // As many as were asked for, or as the disc's width needs.
    return options.disc == BeamsDisc::Sample ? options.disc_samples : discSamples(optics, light, options.disc_samples);
}

LaunchOptions launchOptions(const Scene& scene, const BeamsOptions& options) {
    LaunchOptions launch;
    launch.cells = options.mesh, launch.spacing = options.spacing;
    launch.tubes.lobe_axis = scene.bake.lobe_axis.value_or(glm::dvec3(0));
    launch.refine.tolerance = scene.bake.tolerance, launch.refine.silhouette = options.silhouette;
    return launch;
}

VoxeliseOptions voxeliseOptions(const Scene& scene, const BeamsOptions& options) {
    VoxeliseOptions voxelise;
    voxelise.kernel = options.kernel == BeamsKernel::Scalar ? DepositKernel::Scalar : DepositKernel::Edges;
    voxelise.quadrature = scene.bake.quadrature, voxelise.has_edges = hasEdges(scene);
    return voxelise;
}

FollowLimits followLimits(const Scene& scene) {
    return {scene.bake.bounces.value_or(kDefaultBounces), scene.bake.threshold.value_or(kDefaultThreshold)};
}

MethodCost beamsCost(const CostQuestion& q, const BeamsOptions& options) {
    const Scene& scene = q.scene;
    constexpr double kMostTubes = 1e6, kBytesATube = 150;
    MethodCost cost;
    cost.bytes = kMostTubes * kBytesATube;
    if (q.asked == CostAsked::MostBytes) return cost;
    const int channels = (scene.coloured() ? 3 : 1) + (scene.bake.grids.direction ? 3 : 0);
    const double values = q.needed_voxels * channels;
    const double needed = std::min(1.0, q.needed_voxels / static_cast<double>(q.frame.voxelCount()));
    const OpticalScene optics(scene, q.frame, wavelengthsOf(spectralSamples(options.wavelengths)));
    int most_directions = 1;
    double passing_seconds = 0;  // the most of one mesh whose light all but misses the grid
    std::string passing;
    double light_seconds = 0, disc_seconds = 0, sampled_seconds = 0, most_tubes = 0;
    for (const Light& light : scene.lights) {
        const BeamsDisc disc = discFor(scene, light, q.frame, options);
        const int directions = discDirections(optics, light, options);
        most_directions = std::max(most_directions, directions);
        if (disc == BeamsDisc::Blur) disc_seconds += q.needed_voxels * channels * kSecondsABlurredValue;
        for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
            const Launched all = launchedFrom(q, optics, static_cast<int>(i), light, options);
            const double seconds = secondsOf(all, needed, channels) + values * kSecondsAValue;
            light_seconds += seconds;
            constexpr double kNearlyAll = 0.8;
            if (scene.surfaces[i].mesh && all.passes > kNearlyAll && seconds > passing_seconds) {
                passing_seconds = seconds;
                passing = fmt::format(
                    "most of the time goes into '{}', and {:.3g} % of its light passes the domain: a mesh that ends "
                    "nearer to it is quicker",
                    scene.surfaces[i].name, 100 * all.passes);
            }
            if (disc == BeamsDisc::Sample) sampled_seconds += seconds;
            most_tubes = std::max(most_tubes, all.tubes);
        }
    }
    // The light of flat water, which takes next to no rays.
    if (scene.bake.grids.caustic) light_seconds += 2 * values * kSecondsAValue;
    cost.stages = {{"light", light_seconds}};
    if (disc_seconds > 0) cost.stages.push_back({"disc", disc_seconds});
    cost.bytes = std::min(most_tubes, kMostTubes) * kBytesATube;
    if (passing_seconds > 0.5 * light_seconds) cost.dearest = passing;
    if (sampled_seconds > 0.5 * light_seconds && most_directions > 1) {
        cost.dearest = fmt::format(
            "most of the time goes into {} directions on the sun's disc: fewer disc_samples, or disc = \"off\" for a "
            "point sun, are quicker in proportion",
            most_directions);
    }
    return cost;
}

}  // namespace photic
