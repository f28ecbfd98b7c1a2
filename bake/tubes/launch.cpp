// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/launch.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>

#include "bake/scene/mesh_file.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr std::int64_t kPartsABatch = 1024;

// Few triangles can be much work each: they are shared out finely.
std::int64_t trianglesAPart(std::int64_t triangles) { return std::clamp<std::int64_t>(triangles / 256, 1, 16); }

// One of the four triangles that halved sides make: at a corner, or the middle one.
std::array<EmissionParam, 3> quarter(const std::array<EmissionParam, 3>& corner, int which) {
    const EmissionParam ab = middle(corner[0], corner[1]), bc = middle(corner[1], corner[2]),
                        ca = middle(corner[2], corner[0]);
    switch (which) {
        case 0:
            return {corner[0], ab, ca};
        case 1:
            return {ab, corner[1], bc};
        case 2:
            return {ca, bc, corner[2]};
        default:
            return {ab, bc, ca};
    }
}

// Whether a lamp's place is enclosed by a closed mesh: the solid angles of its triangles add up to a whole sphere.
bool encloses(const TriangleMesh& mesh, const glm::dvec3& place) {
    double angle = 0;
    for (const auto& t : mesh.triangles) {
        const glm::dvec3 u = mesh.positions[t[0]] - place, v = mesh.positions[t[1]] - place,
                         w = mesh.positions[t[2]] - place;
        const double lu = glm::length(u), lv = glm::length(v), lw = glm::length(w);
        angle += 2 * std::atan2(glm::dot(u, glm::cross(v, w)),
                                lu * lv * lw + glm::dot(u, v) * lw + glm::dot(u, w) * lv + glm::dot(v, w) * lu);
    }
    return std::fabs(angle) > 2 * std::numbers::pi;
}

constexpr int kSphereRings = 16;

template <class Ledger>
void addTerms(Ledger& to, const Ledger& from) {
    for (double Ledger::*const term : Ledger::kTerms) to.*term += from.*term;
}

// Joins the builders' tubes in the order of their parts.
TubeSets joined(std::vector<TubeBuilder>& builders) {
    TubeSets batch = std::move(builders[0].sets());
    for (std::size_t s = 0; s < batch.size(); ++s) {
        std::size_t corners = batch[s].corners.size(), tubes = batch[s].tubes.size();
        for (std::size_t i = 1; i < builders.size(); ++i)
            corners += builders[i].sets()[s].corners.size(), tubes += builders[i].sets()[s].tubes.size();
        batch[s].corners.reserve(corners), batch[s].tubes.reserve(tubes);
        for (std::size_t i = 1; i < builders.size(); ++i) batch[s].append(builders[i].sets()[s]);
    }
    return batch;
}

}  // namespace

// Runs parts in parallel, batch by batch, and hands each batch's tubes to the sink in the order of the parts.
void Launch::inBatches(std::int64_t parts, std::int64_t parts_a_batch, LaunchTotals& totals, const Part& part) {
    if (shared_ && is_first_) shared_->assign(static_cast<std::size_t>(parts), 0.0);
    const bool second = shared_ && !is_first_ && shared_->size() == static_cast<std::size_t>(parts);
    for (std::int64_t first = 0; first < parts; first += parts_a_batch) {
        monitor_.checkCancelled();
        monitor_.progress("trace", static_cast<double>(first) / static_cast<double>(parts));
        const auto start = std::chrono::steady_clock::now();
        const std::int64_t count = std::min(parts_a_batch, parts - first);
        const TubeBuilder empty(tracer_.optics(), tracer_.emission(), options_.tubes);
        std::vector<TubeBuilder> builders(static_cast<std::size_t>(count), empty);
        std::vector<std::int64_t> traced(static_cast<std::size_t>(count));
        parallelFor(count, [&](std::int64_t i) {
            monitor_.checkCancelled();
            const auto index = static_cast<std::size_t>(i);
            const auto number = static_cast<std::size_t>(first + i);
            builders[index].beginHold();
            traced[index] = part(first + i, builders[index]);
            builders[index].finish();
            if (second) builders[index].endHold(TubeBuilder::Held::Leaving, (*shared_)[number]);
            if (shared_ && is_first_) (*shared_)[number] = builders[index].leftForOther();
        });
        for (std::size_t i = 0; i < builders.size(); ++i) {
            addTerms(totals.power, builders[i].power());
            addTerms(totals.given_up, builders[i].givenUp());
            totals.astride += builders[i].astride();
            totals.tubes += builders[i].tubes(), totals.added += builders[i].added();
            totals.searches += builders[i].searches();
            totals.corner_rays += traced[i];
            totals.legs += traced[i] * (static_cast<std::int64_t>(tracer_.history().size()) + 1);
            totals.seeds.insert(totals.seeds.end(), builders[i].seeds().begin(), builders[i].seeds().end());
        }
        TubeSets batch = joined(builders);
        totals.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        sink_(std::move(batch));
    }
}

LaunchMesh::LaunchMesh(const Emission& emission, double off_edges)
    : surface_(emission.surface()), off_edges_(off_edges) {
    if (emission.plane()) plane_ = *emission.plane(), cells_ = plane_.cells;
    // A sphere is divided as its light asks for: few triangles to begin with.
    const Surface& surface = surface_;
    if (surface.sphere) ball_ = sphereMesh(surface.sphere->center, surface.sphere->radius, kSphereRings);
}

std::int64_t LaunchMesh::stepFor(int count, std::int64_t size) const {
    if (count <= 0) return 1;
    // No multiple of a row's length, or all would lie in few columns.
    const std::int64_t row = cells_.x > 0 ? 2 * cells_.x : 4 * kSphereRings;
    std::int64_t step = std::max<std::int64_t>(1, size / count);
    while (std::gcd(step, row) > 1) ++step;
    return step;
}

glm::dvec3 LaunchMesh::face(int triangle) const {
    if (cells_.x > 0) return {0, 0, 1};
    const auto& t = mesh().triangles[static_cast<std::size_t>(triangle)];
    const glm::dvec3& p = mesh().positions[t[0]];
    const glm::dvec3 cross = glm::cross(mesh().positions[t[1]] - p, mesh().positions[t[2]] - p);
    return glm::length(cross) > 0 ? glm::normalize(cross) : glm::dvec3(0);
}

// On a sharp edge light enters both of its faces: each facet keeps a hair inside of its own, as a share of the way to
// its middle. Enough for what enters there to meet the face beyond the edge: nearer to it, rays take it for the one
// that they start on, and leave the body through it unseen.
double LaunchMesh::hair(int triangle) const {
    if (cells_.x > 0 || surface_.smooth || surface_.sphere) return 0;
    constexpr double kLeast = 1e-7, kMost = 1e-2;
    const auto& t = mesh().triangles[static_cast<std::size_t>(triangle)];
    const glm::dvec3 &a = mesh().positions[t[0]], &b = mesh().positions[t[1]], &c = mesh().positions[t[2]];
    const double longest = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
    // From the middle to the nearest edge: a third of the height over the longest.
    const double inside = longest > 0 ? glm::length(glm::cross(b - a, c - a)) / (3 * longest) : 0;
    return inside > 0 ? std::clamp(off_edges_ / inside, kLeast, kMost) : kLeast;
}

double LaunchMesh::shortOf(int triangle) const {
    const double left = 1 - hair(triangle);
    return 1 / (left * left);
}

EmissionParam LaunchMesh::corner(int triangle, int which) const {
    if (cells_.x > 0) {
        constexpr int kCorner[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};
        const int cell = triangle / 2, i = cell % cells_.x + kCorner[triangle % 2][which][0],
                  j = cell / cells_.x + kCorner[triangle % 2][which][1];
        const glm::dvec2 place = plane_.min + (plane_.max - plane_.min) * glm::dvec2(i, j) / glm::dvec2(cells_);
        return {{place.x, place.y, 0}, glm::dvec3(0)};
    }
    const auto& t = mesh().triangles[static_cast<std::size_t>(triangle)];
    const auto vertex = t[static_cast<std::size_t>(which)];
    const glm::dvec3 middle = (mesh().positions[t[0]] + mesh().positions[t[1]] + mesh().positions[t[2]]) / 3.0;
    return {glm::mix(mesh().positions[vertex], middle, hair(triangle)), mesh().normals[vertex]};
}

LaunchMesh Launch::meshToLaunch() const {
    // Some twice as far as RayCaster::firstHit overlooks. Farther in, more of the light beside edges is given up.
    constexpr double kOffEdges = 8e-6;
    return {tracer_.emission(), kOffEdges * tracer_.optics().caster().reachFrom(tracer_.emission().surface().center)};
}

// Facets of a closed body that turn away from the light are behind its others. Their corners lie so close to those on a
// sharp edge that rays cannot tell, and would count light again that the facet before them has.
bool Launch::hidesItsBack() const {
    const Emission& emission = tracer_.emission();
    const Surface& surface = emission.surface();
    if (emission.plane() || surface.sphere || !surface.closed || surface.smooth) return false;
    return emission.parallel() || !encloses(*surface.mesh, *emission.sample().source);
}

bool Launch::isBehind(const LaunchMesh& mesh, int triangle) const {
    const Emission& emission = tracer_.emission();
    glm::dvec3 middle(0);
    for (int k = 0; k < 3; ++k) {
        const glm::dvec3 corner = mesh.corner(triangle, k).position;
        if (glm::dot(emission.directionAt(corner), mesh.face(triangle)) <= 0) return false;
        middle += corner / 3.0;
    }
    // One that is wound the wrong way round is lit all the same.
    return tracer_.optics().arrival(middle, emission.directionAt(middle), emission.sample().source) ==
           PathOutcome::Hidden;
}

void Launch::mesh(LaunchTotals& totals) {
    const LaunchMesh mesh = meshToLaunch();
    RefineOptions refine = options_.refine;
    if (options_.spacing > 0) refine.max_edge = options_.spacing, refine.tolerance = 0;
    // Of few large triangles parts are launched where a sample will do.
    int halvings = 0;
    while (options_.sampled > 0 && (std::int64_t{mesh.size()} << 2 * halvings) < 4 * options_.sampled) ++halvings;
    const std::int64_t size = std::int64_t{mesh.size()} << 2 * halvings;
    const std::int64_t step = mesh.stepFor(options_.sampled, size), a_part = trianglesAPart(size);
    const bool hides_its_back = hidesItsBack();
    totals.launched_parts = totals.launched_parts || halvings > 0;
    totals.triangles += size, totals.triangles_launched += (size + step - 1) / step;
    inBatches((size + a_part - 1) / a_part, kPartsABatch, totals, [&](std::int64_t part, TubeBuilder& builder) {
        Refiner refiner(tracer_, obstacles_, builder, refine);
        std::int64_t traced = 0;
        for (std::int64_t i = part * a_part; i < std::min((part + 1) * a_part, size); ++i) {
            if (i % step != 0) continue;
            const int t = static_cast<int>(i >> 2 * halvings);
            const glm::dvec3 face = mesh.face(t);
            if (face == glm::dvec3(0) || (hides_its_back && isBehind(mesh, t))) continue;
            std::array<EmissionParam, 3> corner{mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
            for (int h = 0; h < halvings; ++h) corner = quarter(corner, static_cast<int>(i >> 2 * h & 3));
            Path corners[3];
            for (std::size_t k = 0; k < 3; ++k) corners[k] = tracer_.trace(corner[k], face);
            builder.setRoot(t, mesh.shortOf(t));
            refiner.add(corners[0], corners[1], corners[2], face);
            traced += 3;
        }
        return traced + refiner.traced();
    });
}

// Of a large one, as of a cube's face, faint light would be looked for by a few rays: what they happen to find would
// get the power of all of it.
bool Launch::isSmall(const LaunchMesh& mesh, int triangle) const {
    constexpr double kSmall = 4;  // [voxels]
    const double voxel = std::cbrt(tracer_.optics().frame().voxelVolume());
    for (int k = 0; k < 3; ++k) {
        const EmissionParam a = mesh.corner(triangle, k), b = mesh.corner(triangle, (k + 1) % 3);
        if (glm::length(a.position - b.position) > kSmall * voxel) return false;
    }
    return true;
}

// Divides seeds that belong together, each by itself or their root instead of them.
void Launch::refineSeeds(std::span<const TubeSeed> seeds, const LaunchMesh* roots, Refiner& refiner,
                         TubeBuilder& builder, std::int64_t& traced) {
    // The second branch is held as a whole, to what the first has left.
    const bool held = !shared_ || is_first_;
    const int root = seeds.front().root;
    builder.setRoot(root);
    if (roots && seeds.size() > 1 && isSmall(*roots, root)) {
        Path corners[3];
        for (int k = 0; k < 3; ++k) corners[k] = tracer_.trace(roots->corner(root, k), roots->face(root));
        traced += 3;
        // A root none of whose corners is of this history would show none of its light.
        if (std::any_of(corners, corners + 3, [](const Path& path) { return path.outcome == PathOutcome::Lit; })) {
            double power = 0;
            for (const TubeSeed& seed : seeds) power += seed.power;
            if (held) builder.beginHold();
            refiner.add(corners[0], corners[1], corners[2], roots->face(root));
            if (held) builder.endHold(TubeBuilder::Held::Arriving, power);
            return;
        }
    }
    for (const TubeSeed& seed : seeds) {
        Path corners[3];
        for (std::size_t k = 0; k < 3; ++k) corners[k] = tracer_.trace(seed.corner[k], seed.face);
        traced += 3;
        if (held) builder.beginHold();
        refiner.add(corners[0], corners[1], corners[2], seed.face);
        if (held) builder.endHold(TubeBuilder::Held::Arriving, seed.power);
    }
}

void Launch::seeds(std::span<const TubeSeed> seeds, LaunchTotals& totals) {
    std::optional<LaunchMesh> roots;
    if (options_.from_roots && tracer_.surface().mesh) roots.emplace(meshToLaunch());
    // Where the groups begin that are divided together.
    std::vector<std::size_t> begins;
    for (std::size_t i = 0; i < seeds.size(); ++i)
        if (i == 0 || !roots || seeds[i].root != seeds[i - 1].root) begins.push_back(i);
    const auto groups = static_cast<std::int64_t>(begins.size());
    begins.push_back(seeds.size());
    const std::int64_t a_part = trianglesAPart(groups);
    inBatches((groups + a_part - 1) / a_part, kPartsABatch, totals, [&](std::int64_t part, TubeBuilder& builder) {
        Refiner refiner(tracer_, obstacles_, builder, options_.refine);
        std::int64_t traced = 0;
        for (std::int64_t g = part * a_part; g < std::min((part + 1) * a_part, groups); ++g) {
            const std::size_t begin = begins[static_cast<std::size_t>(g)],
                              end = begins[static_cast<std::size_t>(g) + 1];
            refineSeeds(seeds.subspan(begin, end - begin), roots ? &*roots : nullptr, refiner, builder, traced);
        }
        return traced + refiner.traced();
    });
}

}  // namespace photic
