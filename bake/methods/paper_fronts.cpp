// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/paper_fronts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "bake/methods/graded_space.h"
#include "bake/paths/optical_scene.h"
#include "bake/report/error.h"
#include "bake/report/stopwatch.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

std::size_t flatOf(const glm::ivec3& count, int x, int y, int z) {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(count.y) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(count.x) +
           static_cast<std::size_t>(x);
}

/// Blurs along one axis; beyond the rim nodes are as at it.
void blur(std::vector<float>& values, const glm::ivec3& count, int axis, double sigma) {
    const int reach = static_cast<int>(std::ceil(3 * sigma));
    std::vector<double> weights;
    double sum = 0;
    for (int i = -reach; i <= reach; ++i)
        weights.push_back(std::exp(-0.5 * i * i / (sigma * sigma))), sum += weights.back();
    const std::vector<float> from = values;
    parallelFor(count.z, [&](std::int64_t layer) {
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x) {
                double mean = 0;
                for (int i = -reach; i <= reach; ++i) {
                    glm::ivec3 at(x, y, static_cast<int>(layer));
                    at[axis] = std::clamp(at[axis] + i, 0, count[axis] - 1);
                    mean +=
                        weights[static_cast<std::size_t>(i + reach)] * double(from[flatOf(count, at.x, at.y, at.z)]);
                }
                values[flatOf(count, x, y, static_cast<int>(layer))] = static_cast<float>(mean / sum);
            }
    });
}

}  // namespace

PaperIndex::PaperIndex(const SplineIndex& samples, double sigma) : nodes_(samples.nodes()) {
    const glm::ivec3 count = nodes_.count;
    const std::size_t all = flatOf(count, 0, 0, count.z);
    std::vector<float> n(all);
    for (std::size_t i = 0; i < all; ++i) n[i] = std::sqrt(2 * samples.coefficients()[i]);
    for (int axis = 0; axis < 3 && sigma > 0; ++axis) blur(n, count, axis, sigma);
    values_.resize(all);
    parallelFor(count.z, [&](std::int64_t layer) {
        const int z = static_cast<int>(layer);
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x) {
                glm::dvec3 slope;
                for (int a = 0; a < 3; ++a) {
                    glm::ivec3 low(x, y, z), high(x, y, z);
                    low[a] = std::max(low[a] - 1, 0), high[a] = std::min(high[a] + 1, count[a] - 1);
                    slope[a] = (double(n[flatOf(count, high.x, high.y, high.z)]) -
                                double(n[flatOf(count, low.x, low.y, low.z)])) /
                               ((high[a] - low[a]) * nodes_.spacing[a]);
                }
                values_[flatOf(count, x, y, z)] = {n[flatOf(count, x, y, z)], static_cast<float>(slope.x),
                                                   static_cast<float>(slope.y), static_cast<float>(slope.z)};
            }
    });
}

PaperIndex::Look PaperIndex::at(const glm::dvec3& world) const {
    const glm::dvec3 p =
        glm::clamp((world - nodes_.first_world) / nodes_.spacing, glm::dvec3(0), glm::dvec3(nodes_.count - 1) - 1e-9);
    const glm::ivec3 cell(p);
    const glm::dvec3 t = p - glm::dvec3(cell);
    Look out{0, glm::dvec3(0)};
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 step(corner & 1, corner >> 1 & 1, corner >> 2);
        const double weight = (step.x ? t.x : 1 - t.x) * (step.y ? t.y : 1 - t.y) * (step.z ? t.z : 1 - t.z);
        const Node& node = values_[flatOf(nodes_.count, cell.x + step.x, cell.y + step.y, cell.z + step.z)];
        out.n += weight * double(node.n);
        out.slope += weight * glm::dvec3(node.x, node.y, node.z);
    }
    return out;
}

glm::dmat3 PaperIndex::bendAt(const glm::dvec3& world) const {
    const glm::dvec3 p =
        glm::clamp((world - nodes_.first_world) / nodes_.spacing, glm::dvec3(0), glm::dvec3(nodes_.count - 1) - 1e-9);
    const glm::ivec3 cell(p);
    const glm::dvec3 t = p - glm::dvec3(cell);
    glm::dmat3 bend(0);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 step(corner & 1, corner >> 1 & 1, corner >> 2);
        const Node& node = values_[flatOf(nodes_.count, cell.x + step.x, cell.y + step.y, cell.z + step.z)];
        for (int a = 0; a < 3; ++a) {
            double weight = (step[a] ? 1 : -1) / nodes_.spacing[a];
            for (int b = 0; b < 3; ++b)
                if (b != a) weight *= step[b] ? t[b] : 1 - t[b];
            bend[a] += weight * glm::dvec3(node.x, node.y, node.z);
        }
    }
    return bend;
}

struct PaperFronts::Patch {
    glm::dvec3 corner[4], momentum[4];  ///< around it; as long as n
    glm::dvec3 power{0};                ///< per channel [W]
    double faint = 0;                   ///< power below which it is given up
    double turned = 1;                  ///< sign of its area along the light, where it started
    bool lit = false;
    /// How place and momentum of its middle ray change across it: its sides, to first order.
    glm::dvec3 across[2], turn[2];

    void beginNeighbours() {
        for (const auto& [of, change] : {std::pair{corner, across}, {momentum, turn}})
            change[0] = 0.5 * (of[1] - of[0] + of[2] - of[3]), change[1] = 0.5 * (of[3] - of[0] + of[2] - of[1]);
    }
    glm::dvec3 middle() const { return 0.25 * (corner[0] + corner[1] + corner[2] + corner[3]); }
    glm::dvec3 direction() const { return glm::normalize(momentum[0] + momentum[1] + momentum[2] + momentum[3]); }
    /// Vector across it, as long as its area.
    glm::dvec3 area() const { return 0.5 * glm::cross(corner[2] - corner[0], corner[3] - corner[1]); }
};

/// What a step did to a patch.
struct PaperFronts::Step {
    enum class End { GoesOn, Quartered, Left, Discarded } end = End::GoesOn;
    glm::dvec3 absorbed{0}, scattered{0};  ///< [W]
    glm::ivec3 voxel{0};
    glm::dvec3 irradiance{0};  ///< [W/m2]
    double path = 0;           ///< power times way in needed voxels [W m]
};

PaperFronts::PaperFronts(const FrontSpace& space, const GridFrame& frame, double sigma, PatchArea area)
    : space_(space),
      frame_(frame),
      index_(*space.index, sigma),
      low_(frame.worldFromIndex(glm::dvec3(space.low) - 0.5)),
      high_(frame.worldFromIndex(glm::dvec3(space.high) + 0.5)),
      area_(area) {
    for (int a = 0; a < 3; ++a) voxel_[a] = frame.worldFromIndex()[a][a];
    time_ = 0.5 * std::min({voxel_.x, voxel_.y, voxel_.z});
}

bool PaperFronts::inside(const glm::dvec3& p) const {
    return p.x >= low_.x && p.y >= low_.y && p.z >= low_.z && p.x <= high_.x && p.y <= high_.y && p.z <= high_.z;
}

/// The derivatives of a step, eqs. 14 and 15, at the middle ray.
void PaperFronts::moveNeighbours(Patch& patch) const {
    const glm::dvec3 place = patch.middle(),
                     momentum = 0.25 * (patch.momentum[0] + patch.momentum[1] + patch.momentum[2] + patch.momentum[3]);
    const PaperIndex::Look here = index_.at(place);
    const glm::dmat3 bend = index_.bendAt(place);
    const double square = here.n * here.n;
    for (int i = 0; i < 2; ++i) {
        const double change = glm::dot(here.slope, patch.across[i]);  // of n
        const glm::dvec3 moved = patch.turn[i] / square - (2 * change / (square * here.n)) * momentum,
                         turned = bend * patch.across[i] / here.n - (change / square) * here.slope;
        patch.across[i] += time_ * moved, patch.turn[i] += time_ * turned;
    }
}

PaperFronts::Step PaperFronts::move(Patch& patch, const LightField& field) const {
    const glm::dvec3 before = patch.middle();
    if (area_ == PatchArea::Jacobian) moveNeighbours(patch);
    for (int i = 0; i < 4; ++i) {
        const PaperIndex::Look here = index_.at(patch.corner[i]);
        patch.corner[i] += time_ / (here.n * here.n) * patch.momentum[i];  // [eq. 14]
        patch.momentum[i] += time_ / here.n * here.slope;                  // [eq. 15]
    }
    Step step;
    const glm::dvec3 after = patch.middle(), place = frame_.indexFromWorld(after);
    const double way = glm::distance(before, after), n = index_.at(after).n;
    step.voxel = glm::ivec3(glm::round(place));
    if (std::fabs(0.5 * n * n - 0.5) > double(space_.least_lit)) patch.lit = true;
    if (patch.lit && field.needed().contains(step.voxel)) step.path = channelMean(patch.power) * way;
    if (!space_.media.empty()) {
        const glm::ivec3 count = space_.index->nodes().count,
                         node = glm::clamp(step.voxel - space_.first_node, glm::ivec3(0), count - 1);
        const std::size_t medium = space_.media[flatOf(count, node.x, node.y, node.z)];
        for (int k = 0; k < 3 && medium > 0; ++k) {
            const double extinction = double(space_.table.extinction[medium][k]);
            if (!(extinction > 0)) continue;
            const double lost = -patch.power[k] * std::expm1(-extinction * way),
                         absorbed = std::min(1.0, space_.absorption[medium][k] / extinction);
            step.absorbed[k] = lost * absorbed, step.scattered[k] = lost * (1 - absorbed), patch.power[k] -= lost;
        }
    }
    const glm::dvec3 area = area_ == PatchArea::Jacobian ? glm::cross(patch.across[0], patch.across[1]) : patch.area();
    const double along = patch.turned * glm::dot(area, patch.direction());
    glm::dvec3 low = patch.corner[0], high = low;
    for (const glm::dvec3& corner : patch.corner) low = glm::min(low, corner), high = glm::max(high, corner);
    constexpr double kHair = 1e-6;
    const glm::dvec3 size = (high - low) / voxel_;
    if (!inside(after)) {
        // A slanting front starts beside the space.
        step.end =
            std::isfinite(distanceInto({low_, high_}, after, patch.direction())) ? Step::End::GoesOn : Step::End::Left;
    } else if (!(along > 0) || channelMean(patch.power) < patch.faint) {
        step.end = Step::End::Discarded;
    } else {
        step.irradiance = patch.power / glm::length(area);  // [eqs. 17 and 18]
        if (std::max({size.x, size.y, size.z}) > 1 + kHair) step.end = Step::End::Quartered;
    }
    return step;
}

void PaperFronts::quarter(const Patch& patch, std::vector<Patch>& out) {
    const auto between = [](const glm::dvec3(&at)[4], double u, double v) {
        return (1 - v) * ((1 - u) * at[0] + u * at[1]) + v * ((1 - u) * at[3] + u * at[2]);
    };
    for (int part = 0; part < 4; ++part) {
        const double u = part % 2 * 0.5, v = part / 2 * 0.5;
        Patch quarter = patch;
        const double us[4] = {u, u + 0.5, u + 0.5, u}, vs[4] = {v, v, v + 0.5, v + 0.5};
        for (int i = 0; i < 4; ++i) {
            quarter.corner[i] = between(patch.corner, us[i], vs[i]);
            quarter.momentum[i] = between(patch.momentum, us[i], vs[i]);
        }
        quarter.power *= 0.25;
        for (int i = 0; i < 2; ++i) quarter.across[i] *= 0.5, quarter.turn[i] *= 0.5;
        out.push_back(quarter);
    }
}

void PaperFronts::note(const Patch& patch, const Step& step, LightField& field) {
    if (!patch.lit || step.irradiance == glm::dvec3(0)) return;
    const NeededVoxels& needed = field.needed();
    const int slot = needed.slotOf(step.voxel), offset = NeededVoxels::offsetInLeaf(step.voxel);
    if (slot < 0 || !NeededVoxels::maskBit(needed.mask(slot), offset)) return;
    const int channels = field.channels().irradiance;
    const double mean = channelMean(step.irradiance);
    if (field.state(slot) == LeafState::Dense && !(mean > field.irradiance(step.voxel))) return;
    float* out = field.makeDense(slot) + offset;
    for (int k = 0; k < channels; ++k)
        out[k * LightField::kLeafVoxels] = static_cast<float>(channels == 3 ? step.irradiance[k] : mean);
    const glm::dvec3 direction = patch.direction();
    for (int a = 0; a < 3 && field.channels().flux; ++a)
        out[(channels + a) * LightField::kLeafVoxels] = static_cast<float>(mean * direction[a]);
}

void PaperFronts::lay(const Front& launched, LightField& field, SweepTotals& totals, Monitor& monitor) const {
    const Stopwatch watch;
    constexpr double kFaint = 1e-3;
    std::vector<Patch> patches, next;
    double first_time = std::numeric_limits<double>::infinity();
    for (const Front::Ray& ray : launched.rays) first_time = std::min(first_time, ray.time);
    // Tubes are launched in pairs, (a, b, c) and (a, c, d).
    for (std::size_t t = 0; t + 1 < launched.tubes.size(); t += 2) {
        const Front::Tube &first = launched.tubes[t], &second = launched.tubes[t + 1];
        const std::uint32_t rays[4] = {first.ray[0], first.ray[1], first.ray[2], second.ray[2]};
        Patch patch;
        for (int i = 0; i < 4; ++i) {
            const Front::Ray& ray = launched.rays[rays[i]];
            // Particles of a wavefront have equal time: back along the rays to where the first one is.
            const double back = (ray.time - first_time) / glm::dot(ray.momentum, ray.momentum);
            patch.corner[i] = frame_.worldFromIndex(ray.voxel) - back * ray.momentum, patch.momentum[i] = ray.momentum;
            patch.lit = patch.lit || ray.lit;
        }
        patch.power = first.power + second.power, patch.faint = kFaint * channelMean(patch.power);
        patch.beginNeighbours();
        patch.turned = glm::dot(patch.area(), patch.direction()) < 0 ? -1 : 1;
        patches.push_back(patch);
    }
    totals.tubes += static_cast<std::int64_t>(patches.size());
    totals.rays += static_cast<std::int64_t>(launched.rays.size());
    // Light that runs in circles is given up after sixteen times the space's diagonal.
    const auto most_steps = static_cast<std::int64_t>(16 * glm::distance(low_, high_) / time_);
    for (std::int64_t done = 0; !patches.empty(); ++done) {
        monitor.checkCancelled();
        monitor.progress("deposit", std::min(1.0, 8.0 * static_cast<double>(done) / static_cast<double>(most_steps)));
        if (patches.size() > kMostPatches)
            throw Error(ErrorCode::Input,
                        fmt::format("the front went apart into {} patches; the limit is {}: use larger voxels, or the "
                                    "method's own tubes instead of the paper's preset",
                                    patches.size(), kMostPatches));
        std::vector<Step> steps(patches.size());
        parallelFor(static_cast<std::int64_t>(patches.size()), [&](std::int64_t i) {
            steps[static_cast<std::size_t>(i)] = move(patches[static_cast<std::size_t>(i)], field);
        });
        next.clear();
        for (std::size_t i = 0; i < patches.size(); ++i) {
            const Patch& patch = patches[i];
            const Step& step = steps[i];
            totals.power.absorbed_medium += channelMean(step.absorbed);
            totals.power.scattered += channelMean(step.scattered), totals.deposit.expected += step.path;
            note(patch, step, field);
            if (step.end == Step::End::Left)
                (patch.lit ? totals.power.escaped : totals.power.culled) += channelMean(patch.power);
            else if (step.end == Step::End::Discarded || done > most_steps)
                totals.power.dropped += channelMean(patch.power);
            else if (step.end == Step::End::Quartered)
                quarter(patch, next);
            else
                next.push_back(patch);
        }
        patches.swap(next);
    }
    totals.deposit_seconds += watch.seconds();
}

}  // namespace photic
