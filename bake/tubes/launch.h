// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <span>

#include "bake/paths/launch_domain.h"
#include "bake/paths/path_tracer.h"
#include "bake/report/monitor.h"
#include "bake/tubes/refine.h"
#include "bake/tubes/tube_builder.h"

namespace photic {

/// How a surface is cut into tubes.
struct LaunchOptions {
    int cells = 0;       ///< a side of the launched patch; 0: by `spacing`
    double spacing = 0;  ///< [voxels] of cells; 0: adaptive, by RefineOptions::tolerance
    RefineOptions refine;
    TubeLaunch tubes;
    /// Seeds that are parts of one triangle of a mesh are divided from that triangle on: for histories so faint that
    /// the edges of what shorter ones divided do not count.
    bool from_roots = false;
    /// About so many of a mesh's triangles, or of a lattice's blocks, are launched, evenly spread, for estimates; 0:
    /// all.
    int sampled = 0;
};

/// What launching counted.
struct LaunchTotals {
    PowerLedger power;
    GivenUpPower given_up;  ///< what its `dropped` is made of
    double astride = 0;     ///< TubeBuilder::astride
    std::int64_t tubes = 0, corner_rays = 0;
    std::int64_t legs = 0;  ///< of the corner rays that were cast one by one: not of a lattice's
    /// Triangles that were looked at one by one, and searches of what stands between their corners.
    std::int64_t added = 0, searches = 0;
    /// Triangles of meshes (of few large ones: parts) and of lattices, and those of them that were launched.
    std::int64_t triangles = 0, triangles_launched = 0;
    bool launched_parts = false;
    double seconds = 0;           ///< spent launching, without the sink
    std::vector<TubeSeed> seeds;  ///< what longer histories go on with
};

/// The triangles by which a mesh or a sphere is launched: its own, or those of cells of the plane across the light.
class LaunchMesh {
public:
    /// @param off_edges  how far inside of its own edges a facet is launched [m]
    LaunchMesh(const Emission& emission, double off_edges);

    int size() const { return cells_.x > 0 ? 2 * cells_.x * cells_.y : static_cast<int>(mesh().triangles.size()); }
    /// So many of `size` parts of its triangles apart are about `count` of them, that lie everywhere.
    std::int64_t stepFor(int count, std::int64_t size) const;
    /// Geometric normal, unit; 0 of a triangle without an area.
    glm::dvec3 face(int triangle) const;
    EmissionParam corner(int triangle, int which) const;
    /// By how much what is launched of a triangle is smaller than it: the power of its light has to be multiplied by
    /// this.
    double shortOf(int triangle) const;

private:
    const TriangleMesh& mesh() const { return surface_.sphere ? ball_ : *surface_.mesh; }
    double hair(int triangle) const;

    const Surface& surface_;
    double off_edges_;
    TriangleMesh ball_;
    LightPlane plane_;
    glm::ivec2 cells_{0};
};

struct Lattice;

/// Takes tubes, a batch at a time.
using TubeSink = std::function<void(TubeSets&&)>;

/// Cuts one history of one emission into tubes. Batches follow one another over the emission's domain; inside a batch
/// parts are traced in parallel, with the same result for any number of threads.
class Launch {
public:
    /// All must outlive the launch.
    Launch(const PathTracer& tracer, const LaunchOptions& options, const TubeSink& sink, Monitor& monitor)
        : tracer_(tracer), obstacles_(tracer), options_(options), sink_(sink), monitor_(monitor) {
        options_.refine.monitor = &monitor;
    }

    /// Makes the two branches of an event share its power out exactly, part by part of the domain: the first records
    /// what it leaves, the second takes that. Both must be launched in the same parts.
    void shareWithOther(std::vector<double>& parts, bool first) { shared_ = &parts, is_first_ = first; }

    /// A height field, by a lattice over the part of it that can send light into the grid.
    /// Memory: some 150 bytes a tube of a batch of at most a million.
    void heightField(const Lattice& lattice, LaunchTotals& totals);
    /// A triangle mesh, triangle by triangle, subdivided where the map bends.
    void mesh(LaunchTotals& totals);
    /// What a shorter history has left.
    void seeds(std::span<const TubeSeed> seeds, LaunchTotals& totals);

private:
    LaunchMesh meshToLaunch() const;
    bool hidesItsBack() const;
    bool isBehind(const LaunchMesh& mesh, int triangle) const;
    bool isSmall(const LaunchMesh& mesh, int triangle) const;
    void refineSeeds(std::span<const TubeSeed> seeds, const LaunchMesh* roots, Refiner& refiner, TubeBuilder& builder,
                     std::int64_t& traced);

    using Part = std::function<std::int64_t(std::int64_t, TubeBuilder&)>;
    void inBatches(std::int64_t parts, std::int64_t parts_a_batch, LaunchTotals& totals, const Part& part);

    const PathTracer& tracer_;
    Obstacles obstacles_;
    LaunchOptions options_;
    const TubeSink& sink_;
    Monitor& monitor_;
    std::vector<double>* shared_ = nullptr;  // of each part, what is left for the second branch [W]
    bool is_first_ = true;
};

}  // namespace photic
