// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/launch.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"
#include "bake/tubes/bend_rows.h"

namespace photic {
namespace {

constexpr int kBlockQuads = 8;
constexpr std::int64_t kBatchQuads = 1 << 19;

void addPower(PowerLedger& to, const PowerLedger& from) {
    to.emitted += from.emitted, to.reflected += from.reflected, to.absorbed_medium += from.absorbed_medium,
        to.scattered += from.scattered;
    to.absorbed_surface += from.absorbed_surface, to.received += from.received, to.escaped += from.escaped,
        to.dropped += from.dropped;
    to.culled += from.culled;
}

// Runs parts in parallel, batch by batch, and hands each batch's tubes to the sink in the order of the parts.
template <class Part>
void launchInBatches(std::int64_t parts, std::int64_t parts_a_batch, const GridFrame& frame, const TubeLight& light,
                     const TubeSink& sink, LaunchTotals& totals, Monitor& monitor, const Part& part) {
    for (std::int64_t first = 0; first < parts; first += parts_a_batch) {
        monitor.checkCancelled();
        monitor.progress("trace", static_cast<double>(first) / static_cast<double>(parts));
        const auto start = std::chrono::steady_clock::now();
        const std::int64_t count = std::min(parts_a_batch, parts - first);
        std::vector<TubeBuilder> builders(static_cast<std::size_t>(count), TubeBuilder(frame, light));
        std::vector<std::int64_t> traced(static_cast<std::size_t>(count));
        parallelFor(count, [&](std::int64_t i) {
            const auto index = static_cast<std::size_t>(i);
            traced[index] = part(first + i, builders[index]);
            builders[index].finish();
        });
        std::array<TubeSet, 6> batch = std::move(builders[0].finish());
        for (std::size_t s = 0; s < 6; ++s) {
            std::size_t corners = batch[s].corners.size(), tubes = batch[s].tubes.size();
            for (std::size_t i = 1; i < builders.size(); ++i)
                corners += builders[i].finish()[s].corners.size(), tubes += builders[i].finish()[s].tubes.size();
            batch[s].corners.reserve(corners), batch[s].tubes.reserve(tubes);
        }
        for (std::size_t i = 0; i < builders.size(); ++i) {
            if (i > 0)
                for (std::size_t s = 0; s < 6; ++s) batch[s].append(builders[i].finish()[s]);
            addPower(totals.power, builders[i].power());
            totals.tubes += builders[i].tubes();
            totals.corner_rays += traced[i];
        }
        totals.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        sink(batch);
    }
}

// A regular mesh over the launched patch.
struct Lattice {
    glm::dvec2 origin{0}, step{0};
    int columns = 1, rows = 1;  // quads
    SurfaceParam param(int i, int j) const {
        return {{origin.x + step.x * i, origin.y + step.y * j, 0}, glm::dvec3(0)};
    }
};

// Cells [voxels] that nearly all of the surface can be laid on without refinement: from the bend of the light at some
// scattered points.
double adaptiveSpacing(const CornerTracer& tracer, const LaunchDomain& domain, const TubeLight& light,
                       const GridFrame& frame, double voxel, const RefineOptions& options) {
    constexpr int kProbes = 256;
    constexpr double kLeast = 1, kMost = 32;
    TubeBuilder unused(frame, light);
    const Refiner refiner(tracer, unused, options);
    std::vector<double> bends;
    for (int i = 0; i < kProbes; ++i) {
        // Roberts' R2 sequence.
        const glm::dvec2 x(std::fmod(0.5 + 0.7548776662466927 * i, 1.0), std::fmod(0.5 + 0.5698402909980532 * i, 1.0));
        const glm::dvec2 uv = domain.min + x * (domain.max - domain.min);
        const auto corner = [&](double du, double dv) {
            return tracer.trace({{uv.x + du, uv.y + dv, 0}, glm::dvec3(0)}, {0, 0, 1});
        };
        const Corner middle = corner(0, 0);
        double most = 0;
        for (const glm::dvec2 step : {glm::dvec2(voxel, 0), glm::dvec2(0, voxel), glm::dvec2(voxel, voxel)}) {
            const Corner a = corner(-step.x, -step.y), b = corner(step.x, step.y);
            if (refiner.alike(a, b) && refiner.alike(a, middle) && a.fate == CornerFate::Lit)
                most = std::max(most, refiner.bend(a, middle, b));
        }
        bends.push_back(most);
    }
    std::sort(bends.begin(), bends.end());
    // The strongest bend of all probes, so that hardly a block is left to refine, but never cells of less than half of
    // what most of the surface can do with: one sharp ripple must not make calm water dear.
    const double bend = std::min(bends.back(), 4 * bends[kProbes * 3 / 5]);
    return bend > 0 ? std::clamp(std::sqrt(options.tolerance / bend), kLeast, kMost) : kMost;
}

Lattice layLattice(const CornerTracer& tracer, const LaunchDomain& domain, const TubeLight& light,
                   const GridFrame& frame, const LaunchOptions& options) {
    const HeightField& surface = *tracer.surface().height_field;
    Lattice lattice;
    const glm::dvec2 extent = domain.max - domain.min;
    lattice.origin = domain.min;
    const double voxel = std::min(glm::length(frame.world_from_index[0]), glm::length(frame.world_from_index[1]));
    glm::dvec2 cells(1);
    if (options.mesh > 0)
        cells = glm::dvec2(options.mesh);
    else if (options.spacing > 0)
        cells = extent / (options.spacing * voxel);
    else if (std::isfinite(surface.featureSize()))
        cells = extent / std::min(adaptiveSpacing(tracer, domain, light, frame, voxel, options.refine) * voxel,
                                  surface.featureSize());
    // Far beyond any useful mesh: a surface that towers over the domain, or a spacing of nothing.
    constexpr double kMostCells = 1e10;
    if (!(cells.x * cells.y <= kMostCells))
        throw Error(
            ErrorCode::Input,
            fmt::format(
                "surface '{}' would be cut into {:.3g} x {:.3g} cells, {:.3g} m x {:.3g} m of it can light the domain; "
                "more than {:.0e} in all are refused: use a lower surface (amplitude, height, scale), a larger spacing "
                "or "
                "larger voxels",
                tracer.surface().name, cells.x, cells.y, extent.x, extent.y, kMostCells));
    lattice.columns = static_cast<int>(std::clamp(std::ceil(cells.x - 1e-9), 1.0, 1e6));
    lattice.rows = static_cast<int>(std::clamp(std::ceil(cells.y - 1e-9), 1.0, 1e6));
    lattice.step = extent / glm::dvec2(lattice.columns, lattice.rows);
    return lattice;
}

RowTraceSetup rowSetup(const CornerTracer& tracer, const GridFrame& frame) {
    const Surface& surface = tracer.surface();
    RowTraceSetup setup;
    setup.light_direction = tracer.lightDirection();
    setup.refract = tracer.branch() == Branch::Refracted;
    setup.ior_from = surface.ior_above, setup.ior_to = surface.ior_below;
    setup.index_from_world = glm::inverse(frame.world_from_index);
    setup.grid_origin = frame.origin_world;
    setup.overshoot_layers = kOvershootVoxels, setup.longest_overshoot = kMaxOvershootVoxels;
    if (!tracer.planes()) return setup;
    for (const Plane& plane : *tracer.planes()) {
        const glm::dvec3 n = glm::abs(glm::transpose(frame.world_from_index) * plane.normal);
        const int axis = n.z >= n.x && n.z >= n.y ? 2 : n.y >= n.x ? 1 : 0;
        setup.planes.push_back({plane.normal, glm::dot(plane.normal, plane.point), axis});
    }
    return setup;
}

// Blocks of a lattice come in at most four shapes.
class RegularTopologies {
public:
    RegularTopologies(int columns, int last_columns, int rows, int last_rows) {
        for (const int c : {columns, last_columns})
            for (const int r : {rows, last_rows})
                if (c > 0 && r > 0)
                    shapes_[static_cast<std::size_t>(c)][static_cast<std::size_t>(r)] = regularTopology(c, r);
    }
    const std::shared_ptr<const BlockTopology>& of(int columns, int rows) const {
        return shapes_[static_cast<std::size_t>(columns)][static_cast<std::size_t>(rows)];
    }

private:
    std::array<std::array<std::shared_ptr<const BlockTopology>, kBlockQuads + 1>, kBlockQuads + 1> shapes_;
};

bool regular(const RayRow* rays, int rows, int first, int columns) {
    for (int j = 0; j <= rows; ++j)
        for (int i = first; i <= first + columns; ++i)
            if (rays[j].per_layer[static_cast<std::size_t>(i)] <= 0) return false;
    return true;
}

// A block that needs a closer look: shadows, silhouettes, steep water, strong bends. Returns the rays traced.
std::int64_t refineBlock(const CornerTracer& tracer, const Lattice& lattice, const SurfaceRow* points, int first_row,
                         int rows, int column, int columns, const RefineOptions& options, const BendRows* bends,
                         TubeBuilder& builder) {
    Refiner refiner(tracer, builder, options);
    const int stride = columns + 1;
    std::vector<Corner> corners;
    for (int j = 0; j <= rows; ++j)
        for (int i = column; i <= column + columns; ++i) {
            const SurfaceRow& p = points[j];
            const auto k = static_cast<std::size_t>(i);
            const glm::dvec3 normal = glm::normalize(glm::dvec3(p.nx[k], p.ny[k], p.nz[k]));
            corners.push_back(
                tracer.traceAt(lattice.param(i, first_row + j), {p.px[k], p.py[k], p.pz[k]}, normal, normal));
        }
    const glm::dvec3 up(0, 0, 1);
    const auto corner = [&](int i, int j) -> const Corner& {
        return corners[static_cast<std::size_t>(j * stride + i)];
    };
    // Neighbouring blocks must agree on the edges that they share: the lattice decides them for both.
    const auto decide = [&](int i, int j, int di, int dj) {
        const Corner &a = corner(i, j), &b = corner(i + di, j + dj);
        if (a.fate != CornerFate::Lit || b.fate != CornerFate::Lit || !refiner.alike(a, b)) return;
        refiner.decide(a, b, up, bends->ofEdge(column + i, j, di, dj) > options.tolerance);
    };
    for (int j = 0; j <= rows && bends; ++j)
        for (int i = 0; i <= columns; ++i) {
            if (i < columns) decide(i, j, 1, 0);
            if (j < rows) decide(i, j, 0, 1);
            if (i < columns && j < rows) decide(i, j, 1, 1);
        }
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            refiner.add(corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), up);
            refiner.add(corner(i, j), corner(i + 1, j + 1), corner(i, j + 1), up);
        }
    builder.finish();
    return refiner.traced();
}

}  // namespace

void launchHeightField(const CornerTracer& tracer, const LaunchDomain& domain, const TubeLight& light,
                       const GridFrame& frame, const LaunchOptions& options, const TubeSink& sink, LaunchTotals& totals,
                       Monitor& monitor) {
    if (domain.empty()) return;
    const HeightField& surface = *tracer.surface().height_field;
    const Lattice lattice = layLattice(tracer, domain, light, frame, options);
    RefineOptions refine = options.refine;
    const bool uniform = options.mesh > 0 || options.spacing > 0;
    if (uniform || !std::isfinite(surface.featureSize())) refine.tolerance = 0;

    const auto batch = std::max<std::int64_t>(1, kBatchQuads / (std::int64_t{kBlockQuads} * lattice.columns));
    const int strips = (lattice.rows + kBlockQuads - 1) / kBlockQuads;
    const RowTraceSetup setup = rowSetup(tracer, frame);
    const RowTracer trace = rowTracer(bestInstructionSet());
    // Rows can be traced without casting rays where only planes stand in the way, and without looking at each edge.
    const bool quick = refine.max_edge <= 0 && tracer.planes() != nullptr;
    const RegularTopologies topologies(std::min(kBlockQuads, lattice.columns), lattice.columns % kBlockQuads,
                                       std::min(kBlockQuads, lattice.rows), lattice.rows % kBlockQuads);
    launchInBatches(strips, batch, frame, light, sink, totals, monitor, [&](std::int64_t strip, TubeBuilder& builder) {
        const int first_row = static_cast<int>(strip) * kBlockQuads,
                  rows = std::min(kBlockQuads, lattice.rows - first_row);
        const int stride = lattice.columns + 1;
        // Kept from strip to strip: fresh pages would cost more than the tracing. A row of rays on either side tells
        // how the light bends at the strip's own rim.
        thread_local std::vector<SurfaceRow> points;
        thread_local std::vector<RayRow> rays;
        thread_local BendRows bends;
        points.resize(static_cast<std::size_t>(rows + 3)), rays.resize(static_cast<std::size_t>(rows + 3));
        const auto quads = static_cast<std::size_t>(lattice.columns) * static_cast<std::size_t>(rows);
        if (quick) builder.reserve(setup.refract ? -1 : 1, quads + quads / 3 + 64, 2 * quads);
        const bool bending = refine.tolerance > 0;
        const int border = quick && (bending || light.density == TubeDensity::Linear) ? 1 : 0;
        for (int j = -border; j <= rows + border; ++j) {
            const auto row = static_cast<std::size_t>(j + 1);
            const SurfaceParam start = lattice.param(0, first_row + j);
            surface.row({start.position.x, start.position.y}, lattice.step.x, static_cast<std::size_t>(stride),
                        points[row]);
            if (quick) trace(setup, points[row], rays[row]);
        }
        const double floor_w = setup.refract ? frame.min.z - 0.5 : frame.max.z + 0.5;
        if (border && bending) bends.measure(rays.data() + 1, rows, floor_w);
        std::int64_t traced = std::int64_t{stride} * (rows + 1 + 2 * border);
        for (int column = 0; column < lattice.columns; column += kBlockQuads) {
            const int columns = std::min(kBlockQuads, lattice.columns - column);
            const bool straight = !border || !bending || bends.most(column, columns) <= refine.tolerance;
            if (quick && straight && regular(rays.data() + 1, rows, column, columns))
                builder.addRegular(topologies.of(columns, rows), rays.data() + 1, column, columns, rows);
            else
                traced += refineBlock(tracer, lattice, points.data() + 1, first_row, rows, column, columns, refine,
                                      border && bending ? &bends : nullptr, builder);
        }
        return traced;
    });
}

void launchMesh(const CornerTracer& tracer, const TubeLight& light, const GridFrame& frame,
                const LaunchOptions& options, const TubeSink& sink, LaunchTotals& totals, Monitor& monitor) {
    const TriangleMesh& mesh = *tracer.surface().mesh;
    constexpr std::size_t kTrianglesAPart = 16;
    RefineOptions refine = options.refine;
    if (options.spacing > 0) refine.max_edge = options.spacing, refine.tolerance = 0;
    const auto parts = static_cast<std::int64_t>((mesh.triangles.size() + kTrianglesAPart - 1) / kTrianglesAPart);
    launchInBatches(parts, 1024, frame, light, sink, totals, monitor, [&](std::int64_t part, TubeBuilder& builder) {
        Refiner refiner(tracer, builder, refine);
        std::int64_t traced = 0;
        const std::size_t first = static_cast<std::size_t>(part) * kTrianglesAPart;
        for (std::size_t t = first; t < std::min(first + kTrianglesAPart, mesh.triangles.size()); ++t) {
            const auto& triangle = mesh.triangles[t];
            const glm::dvec3 *p[3], *n[3];
            for (std::size_t i = 0; i < 3; ++i) p[i] = &mesh.positions[triangle[i]], n[i] = &mesh.normals[triangle[i]];
            const glm::dvec3 cross = glm::cross(*p[1] - *p[0], *p[2] - *p[0]);
            const double size = glm::length(cross);
            if (size <= 0) continue;
            const glm::dvec3 face = cross / size;
            Corner corners[3];
            for (int i = 0; i < 3; ++i) corners[i] = tracer.trace({*p[i], *n[i]}, face);
            refiner.add(corners[0], corners[1], corners[2], face);
            traced += 3;
        }
        return traced + refiner.traced();
    });
}

}  // namespace photic
