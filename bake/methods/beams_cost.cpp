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
constexpr double kSecondsATriangle = 6e-6;     // of a mesh surface, whose rays are cast
constexpr double kSecondsATubeLayer = 2.1e-8;  // of a tube in a layer of voxels
constexpr double kSecondsAValue = 1.1e-8;      // summed in a voxel
constexpr double kSecondsABlurredValue = 1e-8;

/// What a surface is cut into for one light.
struct Cells {
    double count = 0, tubes = 0;
};

Cells cellsOf(const CostQuestion& q, const OpticalScene& optics, int surface_index, const Light& light,
              const BeamsOptions& options) {
    const Surface& surface = q.scene.surfaces[static_cast<std::size_t>(surface_index)];
    if (surface.mesh) {
        const auto triangles = static_cast<double>(surface.mesh->triangles.size());
        return {triangles, triangles};
    }
    LaunchOptions launch;
    launch.cells = options.mesh, launch.spacing = options.spacing;
    launch.refine.tolerance = q.scene.bake.tolerance;
    const LaunchDomain domain = launchDomain(q.scene, surface, light, q.frame);
    if (domain.empty()) return {};
    const Branch branch = surface.event == SurfaceEvent::Reflect ? Branch::Reflected : Branch::Refracted;
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

MethodCost beamsCost(const CostQuestion& q, const BeamsOptions& options) {
    const Scene& scene = q.scene;
    const int points = std::max(1, scene.bake.quadrature);  // 0: few layers slant so much that they take more
    const double planes = q.frame.size().z * points;
    const int channels = (scene.coloured() ? 3 : 1) + (scene.bake.grids.direction ? 3 : 0);
    const double values = q.needed_voxels * channels * points;
    const OpticalScene optics(scene, q.frame);
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
            const Cells cells = cellsOf(q, optics, static_cast<int>(i), light, options);
            // Tubes also lie side by side in sheets of voxels that nobody needs, where they cost nothing.
            const double needed = std::min(1.0, q.needed_voxels / static_cast<double>(q.frame.voxelCount()));
            const double launch = cells.count * (surface.mesh ? kSecondsATriangle : kSecondsACell) +
                                  cells.tubes * planes * needed * kSecondsATubeLayer + values * kSecondsAValue;
            const double seconds = launch * branchesOf(surface) * samples;
            light_seconds += seconds;
            if (disc == BeamsDisc::Sample) sampled_seconds += seconds;
            most_tubes = std::max(most_tubes, cells.tubes);
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
