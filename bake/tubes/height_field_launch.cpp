// SPDX-License-Identifier: Apache-2.0
// The launch through a height field: a lattice of vectorised rows, block by block, of which those that need a closer
// look are refined edge by edge.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "bake/tubes/bend_rows.h"
#include "bake/tubes/lattice.h"
#include "bake/tubes/launch.h"

namespace photic {
namespace {

constexpr int kBlockCells = 8;
constexpr std::int64_t kBatchCells = 1 << 19;

RowTraceSetup rowSetup(const PathTracer& tracer) {
    const Surface& surface = tracer.surface();
    const GridFrame& frame = tracer.optics().frame();
    RowTraceSetup setup;
    const LightSample& sample = tracer.emission().sample();
    setup.light_direction = sample.direction;
    setup.sun_middle = sample.light ? sample.light->direction : sample.direction;
    setup.refract = tracer.history().front().branch == Branch::Refracted;
    setup.traces_other_branch = surface.event == SurfaceEvent::Both;
    const MediumSides& sides = tracer.optics().sides(tracer.emission().surfaceIndex());
    const auto wavelength = static_cast<std::size_t>(tracer.wavelength());
    setup.ior_from = tracer.optics().medium(sides.outside).iors[wavelength];
    setup.ior_to = tracer.optics().medium(sides.inside).iors[wavelength];
    setup.index_from_world = frame.indexFromWorld();
    setup.grid_origin = frame.origin_world;
    const LightEnd& light_end = tracer.optics().lightEnd();
    for (const Object& object : tracer.optics().scene().objects) {
        const Plane* plane = std::get_if<Plane>(&object.shape);
        if (!plane || !object.blocks()) continue;
        const int axis = mainAxis(frame.indexNormal(plane->normal));
        setup.planes.push_back({plane->normal, glm::dot(plane->normal, plane->point), axis, object.receives(),
                                light_end.behindPlane(axis), light_end.longestBehindPlane(axis)});
    }
    return setup;
}

// Blocks of a lattice come in at most four shapes.
class RegularTopologies {
public:
    explicit RegularTopologies(const Lattice& lattice) {
        for (const int c : {std::min(kBlockCells, lattice.columns), lattice.columns % kBlockCells})
            for (const int r : {std::min(kBlockCells, lattice.rows), lattice.rows % kBlockCells})
                if (c > 0 && r > 0)
                    shapes_[static_cast<std::size_t>(c)][static_cast<std::size_t>(r)] = regularTopology(c, r);
    }
    const std::shared_ptr<const BlockTopology>& of(int columns, int rows) const {
        return shapes_[static_cast<std::size_t>(columns)][static_cast<std::size_t>(rows)];
    }

private:
    std::array<std::array<std::shared_ptr<const BlockTopology>, kBlockCells + 1>, kBlockCells + 1> shapes_;
};

// Eight rows of the lattice, and the row before and after them, which tell how light bends at their own rim. Kept from
// strip to strip: fresh pages would cost more than the tracing.
struct Strip {
    int first_row = 0, rows = 0;
    std::vector<SurfaceRow> point_rows;
    std::vector<RayRow> ray_rows;
    BendRows bends;
    bool bending = false;
    double floor_w = 0;  // the grid's last face along the light

    const SurfaceRow* points() const { return point_rows.data() + 1; }
    RayRow* rays() { return ray_rows.data() + 1; }
};

// The launch of one height field, shared by all strips.
class StripLaunch {
public:
    StripLaunch(const PathTracer& tracer, const Obstacles& obstacles, const Lattice& lattice,
                const RefineOptions& refine)
        : tracer_(tracer),
          obstacles_(obstacles),
          lattice_(lattice),
          refine_(refine),
          setup_(rowSetup(tracer)),
          trace_(rowTracer(bestInstructionSet())),
          topologies_(lattice) {}

    /// Returns the rays traced.
    std::int64_t run(std::int64_t number, TubeBuilder& builder) const {
        thread_local Strip strip;
        strip.first_row = static_cast<int>(number) * kBlockCells;
        strip.rows = std::min(kBlockCells, lattice_.rows - strip.first_row);
        traceRows(strip);
        const auto cells = static_cast<std::size_t>(lattice_.columns) * static_cast<std::size_t>(strip.rows);
        builder.reserve(setup_.refract ? -1 : 1, cells + cells / 3 + 64, 2 * cells);
        std::int64_t traced = std::int64_t{lattice_.columns + 1} * (strip.rows + (strip.bending ? 3 : 1));
        for (int column = 0; column < lattice_.columns; column += kBlockCells) {
            const int columns = std::min(kBlockCells, lattice_.columns - column);
            if (isPlain(strip, column, columns))
                builder.addRegular(topologies_.of(columns, strip.rows), strip.rays(), column, columns, strip.rows);
            else
                traced += refineBlock(strip, column, columns, builder);
        }
        return traced;
    }

private:
    void traceRows(Strip& strip) const {
        const HeightField& surface = *tracer_.surface().height_field;
        strip.point_rows.resize(static_cast<std::size_t>(strip.rows + 3));
        strip.ray_rows.resize(static_cast<std::size_t>(strip.rows + 3));
        // A lamp's rays part from one another besides: the refiner looks for itself.
        strip.bending = refine_.tolerance > 0 && tracer_.emission().parallel();
        strip.floor_w = lastFace(setup_.refract);
        const int border = strip.bending || !obstacles_.none() ? 1 : 0;
        for (int j = -border; j <= strip.rows + border; ++j) {
            const auto row = static_cast<std::size_t>(j + 1);
            const EmissionParam start = lattice_.param(0, strip.first_row + j);
            surface.row({start.position.x, start.position.y}, lattice_.step.x,
                        static_cast<std::size_t>(lattice_.columns + 1), strip.point_rows[row]);
            trace_(setup_, strip.point_rows[row], strip.ray_rows[row]);
        }
        if (strip.bending) strip.bends.measure(strip.rays(), strip.rows, strip.floor_w);
    }

    double lastFace(bool down) const {
        const GridFrame& frame = tracer_.optics().frame();
        return down ? frame.min.z - 0.5 : frame.max.z + 0.5;
    }

    // A second height field, which the rows do not know.
    bool surfacesElsewhere() const {
        const auto& surfaces = tracer_.optics().scene().surfaces;
        return std::count_if(surfaces.begin(), surfaces.end(),
                             [](const Surface& s) { return s.height_field != nullptr; }) > 1;
    }

    // Whether a block's tubes can be laid as they are: all rays go on through z layers, straight enough, to ends that
    // their corners tell.
    bool isPlain(Strip& strip, int column, int columns) const {
        RayRow* rays = strip.rays();
        if (refine_.max_edge > 0 || !tracer_.emission().parallel() || surfacesElsewhere()) return false;
        for (int j = 0; j <= strip.rows; ++j)
            for (int i = column; i <= column + columns; ++i)
                if (rays[j].per_layer[static_cast<std::size_t>(i)] <= 0) return false;
        if (strip.bending && strip.bends.most(column, columns) > refine_.tolerance) return false;
        if (isInOwnShadow(strip, column, columns)) return false;
        if (obstacles_.ofBlock(rays, column, columns, strip.rows) == Obstacles::Way::Unclear) return false;
        return !BendRows::endsApart(rays, strip.rows, column, columns, strip.floor_w);
    }

    // Whether the water's waves stand between a corner of a block and the sun.
    bool isInOwnShadow(const Strip& strip, int column, int columns) const {
        const OwnShadow* shadow = tracer_.optics().ownShadow(tracer_.emission().surfaceIndex());
        if (!shadow) return false;
        for (int j = 0; j <= strip.rows; ++j)
            for (int i = column; i <= column + columns; ++i) {
                const SurfaceRow& p = strip.points()[j];
                const auto k = static_cast<std::size_t>(i);
                if (shadow->covers({p.px[k], p.py[k], p.pz[k]}, setup_.light_direction)) return true;
            }
        return false;
    }

    // A block that needs a closer look: shadows, silhouettes, steep water, strong bends.
    std::int64_t refineBlock(Strip& strip, int column, int columns, TubeBuilder& builder) const {
        Refiner refiner(tracer_, obstacles_, builder, refine_);
        std::vector<Path> paths;
        for (int j = 0; j <= strip.rows; ++j)
            for (int i = column; i <= column + columns; ++i) {
                const SurfaceRow& p = strip.points()[j];
                const auto k = static_cast<std::size_t>(i);
                const glm::dvec3 normal = glm::normalize(glm::dvec3(p.nx[k], p.ny[k], p.nz[k]));
                const glm::dvec3 position(p.px[k], p.py[k], p.pz[k]);
                paths.push_back(tracer_.follow(lattice_.param(i, strip.first_row + j),
                                               {position, tracer_.emission().directionAt(position), normal, normal}));
            }
        const auto path = [&](int i, int j) -> const Path& {
            return paths[static_cast<std::size_t>(j * (columns + 1) + i)];
        };
        const glm::dvec3 up(0, 0, 1);
        if (strip.bending) tellBends(strip, column, columns, path, refiner);
        for (int j = 0; j < strip.rows; ++j)
            for (int i = 0; i < columns; ++i) {
                refiner.add(path(i, j), path(i + 1, j), path(i + 1, j + 1), up);
                refiner.add(path(i, j), path(i + 1, j + 1), path(i, j + 1), up);
            }
        builder.finish();
        return refiner.traced();
    }

    // Neighbouring blocks must agree on the edges that they share: the lattice decides them for both.
    template <class PathAt>
    void tellBends(const Strip& strip, int column, int columns, const PathAt& path, Refiner& refiner) const {
        const PathComparison compare(tracer_);
        const auto tell = [&](int i, int j, int di, int dj) {
            const Path &a = path(i, j), &b = path(i + di, j + dj);
            if (a.outcome == PathOutcome::Lit && compare.canShareTube(a, b))
                refiner.knowBend(a, b, {0, 0, 1}, strip.bends.ofEdge(column + i, j, di, dj));
        };
        for (int j = 0; j <= strip.rows; ++j)
            for (int i = 0; i <= columns; ++i) {
                if (i < columns) tell(i, j, 1, 0);
                if (j < strip.rows) tell(i, j, 0, 1);
                if (i < columns && j < strip.rows) tell(i, j, 1, 1);
            }
    }

    const PathTracer& tracer_;
    const Obstacles& obstacles_;
    const Lattice& lattice_;
    const RefineOptions& refine_;
    RowTraceSetup setup_;
    RowTracer trace_;
    RegularTopologies topologies_;
};

}  // namespace

void Launch::heightField(const Lattice& lattice, LaunchTotals& totals) {
    RefineOptions refine = options_.refine;
    const bool uniform = options_.cells > 0 || options_.spacing > 0;
    if (uniform || bendsNowhere(tracer_)) refine.tolerance = 0;
    const auto batch = std::max<std::int64_t>(1, kBatchCells / (std::int64_t{kBlockCells} * lattice.columns));
    const StripLaunch strips(tracer_, obstacles_, lattice, refine);
    inBatches((lattice.rows + kBlockCells - 1) / kBlockCells, batch, totals,
              [&](std::int64_t strip, TubeBuilder& builder) { return strips.run(strip, builder); });
}

}  // namespace photic
