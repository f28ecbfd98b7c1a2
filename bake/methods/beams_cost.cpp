// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/beams_cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bake/methods/disc_samples.h"
#include "bake/methods/sun_disc.h"
#include "bake/paths/launch_domain.h"
#include "bake/paths/optical_scene.h"
#include "bake/tubes/lattice.h"
#include "bake/tubes/launch.h"

namespace photic {

namespace {

// Seconds of one thread of a 2.6 GHz server core, fitted to the examples and variants of them (docs/accuracy.md).
constexpr double kSecondsACell = 4e-7;         // of a lattice: its ray and what refinement adds
constexpr double kSecondsALeg = 1.4e-6;        // of a ray that is cast from a mesh or a sphere
constexpr double kSecondsATube = 2.4e-6;       // of those, whatever it crosses
constexpr double kSecondsALayer = 1.3e-7;      // of one of those in a layer of voxels
constexpr double kSecondsATubeLayer = 2.1e-8;  // of a tube in a layer of voxels
constexpr double kSecondsAValue = 1.1e-8;      // summed in a voxel
constexpr double kSecondsABlurredValue = 1e-8;

// Triangles of a mesh that are launched to see what all take.
constexpr int kTriedTriangles = 48;

/// What a surface is cut into for one light.
struct Cells {
    double count = 0, tubes = 0;
};

/// What a mesh or a sphere is, and what all histories take that begin there.
struct Launched {
    double tubes = 0;
    double legs = 0;    ///< of all corner rays
    double layers = 0;  ///< that all tubes cross
};

// Layers that tubes cross inside of the grid.
double layersOf(const TubeSets& sets, const GridFrame& frame) {
    double layers = 0;
    for (const TubeSet& set : sets) {
        if (set.empty()) continue;
        const double low = frame.min[set.axis] - 0.5, high = frame.max[set.axis] + 0.5;
        double crossed = 0;
        for (const CornerRay& ray : set.corners)
            crossed += std::fabs(std::clamp(ray.w_end, low, high) - std::clamp(ray.w, low, high));
        layers += crossed / static_cast<double>(set.corners.size()) * static_cast<double>(set.tubes.size());
    }
    return layers;
}

/// Launches a few triangles for all. Where the disc is sampled the faint histories are followed for one direction.
Launched launchedFrom(const CostQuestion& q, const OpticalScene& optics, int surface_index, const Light& light,
                      const BeamsOptions& options) {
    const std::vector<SpectralSample> spectrum = spectralSamples(options.wavelengths);
    const int directions = discDirections(optics, light, options);
    const std::vector<LightSample> samples = lightSamples(light, directions);
    double layers = 0;
    const TubeSink count = [&](TubeSets&& sets) { layers += layersOf(sets, q.frame); };
    LaunchOptions launch = launchOptions(q.scene, options);
    launch.tubes.channels = q.scene.coloured() ? 3 : 1;
    launch.sampled = kTriedTriangles;
    Monitor quiet;
    Launched all;
    FaintLight faint;
    for (const bool last : {false, true}) {
        const double like_it = last ? 1.0 : static_cast<double>(samples.size()) - 1;
        if (like_it == 0) continue;
        HistoryLauncher launcher(optics, spectrum, launch, followLimits(q.scene), count, quiet);
        launcher.shareFaint(samples.size() > 1 ? &faint : nullptr, last);
        LaunchTotals totals;
        layers = 0;
        launcher.launch(Emission(q.scene, surface_index, samples.front()), {}, totals);
        if (totals.triangles_launched == 0) continue;
        const double part = static_cast<double>(totals.triangles_launched) / static_cast<double>(totals.triangles);
        all.legs += like_it * static_cast<double>(totals.legs) / part;
        all.layers += like_it * layers / part;
        all.tubes += like_it * static_cast<double>(totals.tubes) / part;
    }
    return all;
}

Cells cellsOf(const CostQuestion& q, const OpticalScene& optics, int surface_index, const Light& light,
              const BeamsOptions& options) {
    const Surface& surface = q.scene.surfaces[static_cast<std::size_t>(surface_index)];
    const LaunchOptions launch = launchOptions(q.scene, options);
    const LaunchDomain domain = launchDomain(q.scene, surface, light, q.frame);
    if (domain.empty()) return {};
    const bool reflects = surface.event == SurfaceEvent::Reflect || surface.event == SurfaceEvent::Mirror;
    const Branch branch = reflects ? Branch::Reflected : Branch::Refracted;
    const Emission emission(q.scene, surface_index, lightSamples(light, 1).front());
    const PathTracer tracer(optics, emission, {{surface_index, branch}});
    const Lattice lattice = layLattice(tracer, domain, launch);
    const double cells = double(lattice.columns) * lattice.rows;
    return {cells, 2 * cells};
}

int branchesOf(const Surface& surface) { return surface.event == SurfaceEvent::Both ? 2 : 1; }

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

FollowLimits followLimits(const Scene& scene) {
    return {scene.bake.bounces.value_or(kDefaultBounces), scene.bake.threshold.value_or(kDefaultThreshold)};
}

MethodCost beamsCost(const CostQuestion& q, const BeamsOptions& options) {
    const Scene& scene = q.scene;
    const int points = std::max(1, scene.bake.quadrature);  // 0: few layers slant so much that they take more
    const double planes = q.frame.size().z * points;
    const int channels = (scene.coloured() ? 3 : 1) + (scene.bake.grids.direction ? 3 : 0);
    const double values = q.needed_voxels * channels * points;
    const OpticalScene optics(scene, q.frame, wavelengthsOf(spectralSamples(options.wavelengths)));
    int most_directions = 1;
    double light_seconds = 0, disc_seconds = 0, sampled_seconds = 0, most_tubes = 0;
    for (const Light& light : scene.lights) {
        const BeamsDisc disc = discFor(scene, light, q.frame, options);
        const int directions = discDirections(optics, light, options);
        // A lamp of some extent is cut into points besides.
        const auto samples = static_cast<double>(lightSamples(light, directions).size());
        most_directions = std::max(most_directions, directions);
        if (disc == BeamsDisc::Blur) disc_seconds += q.needed_voxels * channels * kSecondsABlurredValue;
        for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
            const Surface& surface = scene.surfaces[i];
            double seconds = 0, tubes = 0;
            if (surface.mesh) {
                const Launched all = launchedFrom(q, optics, static_cast<int>(i), light, options);
                tubes = all.tubes;
                const double needed = std::min(1.0, q.needed_voxels / static_cast<double>(q.frame.voxelCount()));
                seconds = all.legs * kSecondsALeg + all.tubes * kSecondsATube + all.layers * needed * kSecondsALayer +
                          values * kSecondsAValue;
            } else {
                const Cells cells = cellsOf(q, optics, static_cast<int>(i), light, options);
                tubes = cells.tubes;
                // Tubes also lie side by side in sheets of voxels that nobody needs, where they cost nothing.
                const double needed = std::min(1.0, q.needed_voxels / static_cast<double>(q.frame.voxelCount()));
                seconds = (cells.count * kSecondsACell + cells.tubes * planes * needed * kSecondsATubeLayer +
                           values * kSecondsAValue) *
                          branchesOf(surface) * samples;
            }
            light_seconds += seconds;
            if (disc == BeamsDisc::Sample) sampled_seconds += seconds;
            most_tubes = std::max(most_tubes, tubes);
        }
    }
    // The light of flat water, which takes next to no rays.
    if (scene.bake.grids.caustic) light_seconds += 2 * values * kSecondsAValue;
    MethodCost cost;
    cost.stages = {{"light", light_seconds}};
    if (disc_seconds > 0) cost.stages.push_back({"disc", disc_seconds});
    cost.bytes = std::min(most_tubes, 1e6) * 150;
    if (sampled_seconds > 0.5 * light_seconds && most_directions > 1) {
        cost.dearest = fmt::format(
            "most of the time goes into {} directions on the sun's disc: fewer disc_samples, or disc = \"off\" for a "
            "point sun, are quicker in proportion",
            most_directions);
    }
    return cost;
}

}  // namespace photic
