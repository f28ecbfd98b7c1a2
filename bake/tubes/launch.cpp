// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/launch.h"

#include <algorithm>
#include <chrono>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr std::int64_t kTrianglesAPart = 16, kPartsABatch = 1024;

void addPower(PowerLedger& to, const PowerLedger& from) {
    for (double PowerLedger::*const term : PowerLedger::kTerms) to.*term += from.*term;
}

// Joins the builders' tubes in the order of their parts.
std::array<TubeSet, 6> joined(std::vector<TubeBuilder>& builders) {
    std::array<TubeSet, 6> batch = std::move(builders[0].sets());
    for (std::size_t s = 0; s < 6; ++s) {
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
            addPower(totals.power, builders[i].power());
            totals.tubes += builders[i].tubes();
            totals.corner_rays += traced[i];
            totals.seeds.insert(totals.seeds.end(), builders[i].seeds().begin(), builders[i].seeds().end());
        }
        const std::array<TubeSet, 6> batch = joined(builders);
        totals.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        sink_(batch);
    }
}

void Launch::mesh(LaunchTotals& totals) {
    const TriangleMesh& mesh = *tracer_.surface().mesh;
    RefineOptions refine = options_.refine;
    if (options_.spacing > 0) refine.max_edge = options_.spacing, refine.tolerance = 0;
    const auto triangles = static_cast<std::int64_t>(mesh.triangles.size());
    const std::int64_t parts = (triangles + kTrianglesAPart - 1) / kTrianglesAPart;
    inBatches(parts, kPartsABatch, totals, [&](std::int64_t part, TubeBuilder& builder) {
        Refiner refiner(tracer_, obstacles_, builder, refine);
        std::int64_t traced = 0;
        for (std::int64_t t = part * kTrianglesAPart; t < std::min((part + 1) * kTrianglesAPart, triangles); ++t) {
            const auto& triangle = mesh.triangles[static_cast<std::size_t>(t)];
            const glm::dvec3 &p = mesh.positions[triangle[0]], &q = mesh.positions[triangle[1]],
                             &r = mesh.positions[triangle[2]];
            const glm::dvec3 cross = glm::cross(q - p, r - p);
            if (!(glm::length(cross) > 0)) continue;
            const glm::dvec3 face = glm::normalize(cross);
            // On a sharp edge light enters both of its faces: each facet keeps a hair inside of its own.
            const double hair = tracer_.surface().smooth ? 0 : 1e-7;
            const glm::dvec3 middle = (p + q + r) / 3.0;
            Path corners[3];
            for (std::size_t i = 0; i < 3; ++i)
                corners[i] = tracer_.trace(
                    {glm::mix(mesh.positions[triangle[i]], middle, hair), mesh.normals[triangle[i]]}, face);
            refiner.add(corners[0], corners[1], corners[2], face);
            traced += 3;
        }
        return traced + refiner.traced();
    });
}

void Launch::seeds(std::span<const TubeSeed> seeds, LaunchTotals& totals) {
    const auto count = static_cast<std::int64_t>(seeds.size());
    inBatches((count + kTrianglesAPart - 1) / kTrianglesAPart, kPartsABatch, totals,
              [&](std::int64_t part, TubeBuilder& builder) {
                  Refiner refiner(tracer_, obstacles_, builder, options_.refine);
                  std::int64_t traced = 0;
                  for (std::int64_t i = part * kTrianglesAPart; i < std::min((part + 1) * kTrianglesAPart, count);
                       ++i) {
                      const TubeSeed& seed = seeds[static_cast<std::size_t>(i)];
                      Path corners[3];
                      for (std::size_t k = 0; k < 3; ++k) corners[k] = tracer_.trace(seed.corner[k], seed.face);
                      // The second branch is held as a whole, to what the first has left.
                      const bool held = !shared_ || is_first_;
                      if (held) builder.beginHold();
                      refiner.add(corners[0], corners[1], corners[2], seed.face);
                      if (held) builder.endHold(TubeBuilder::Held::Arriving, seed.power);
                      traced += 3;
                  }
                  return traced + refiner.traced();
              });
}

}  // namespace photic
