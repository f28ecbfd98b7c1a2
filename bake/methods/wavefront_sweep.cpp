// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/wavefront_sweep.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bake/graded/ray_integrator.h"
#include "bake/report/stopwatch.h"
#include "bake/threads/parallel_for.h"
#include "bake/tubes/bent_rows.h"

namespace photic {
namespace {

constexpr int kLanes = BentRows::kLanes;
constexpr std::size_t kTubesOfBlock = 128;
constexpr double kFarLayers = 1e6;  // past any grid, and exact in single precision

double channelMean(const glm::dvec3& v) { return (v.x + v.y + v.z) / 3; }

}  // namespace

void Front::append(const Front& other) {
    const auto first = static_cast<std::uint32_t>(rays.size());
    rays.insert(rays.end(), other.rays.begin(), other.rays.end());
    for (Tube tube : other.tubes) {
        for (std::uint32_t& ray : tube.ray) ray += first;
        tubes.push_back(tube);
    }
}

/// Some consecutive layers: a slab, or layers that nobody needs.
struct FrontSweep::Chunk {
    int first = 0, layers = 0;
    const SlabGroup* group = nullptr;  ///< null: nobody needs them
    std::size_t slab = 0;
};

/// A front's tubes, in its order, as the deposit takes them.
struct FrontSweep::Packed {
    TubeSet set;
    BentRows bent;
};

/// A tube that turned away in this chunk.
struct FrontSweep::Turned {
    std::uint32_t tube;
    int lane;  ///< that it does not pass any more
};

struct FrontSweep::State {
    FrontRays rays, before;  ///< before: at the chunk's entry
    Packed packed;
    IndexSlices slices;
    std::vector<char> alive;  ///< per tube
    std::vector<Turned> turned;
    std::map<std::pair<int, int>, Front> next;  ///< by axis and sense
    std::map<std::pair<int, int>, std::map<std::pair<std::uint32_t, int>, std::uint32_t>> places;  ///< of rays in them
    VoxeliseOptions options;                                                                       ///< of the chunk
    bool attenuates = false;
    int channels = 1;
};

std::vector<FrontSweep::Chunk> FrontSweep::chunksOf(const Front& front, const std::vector<SlabGroup>& groups) const {
    std::vector<Chunk> chunks;
    int next = space_.low[front.axis];
    const auto skipTo = [&](int layer) {
        for (; next < layer; next += std::min(kLanes, layer - next))
            chunks.push_back({next, std::min(kLanes, layer - next), nullptr, 0});
    };
    for (const SlabGroup& group : groups)
        for (std::size_t s = 0; s < group.slabs.size(); ++s) {
            skipTo(group.slabs[s].first);
            chunks.push_back({group.slabs[s].first, group.slabs[s].active, &group, s});
            next = group.slabs[s].first + group.slabs[s].active;
        }
    skipTo(space_.high[front.axis] + 1);
    if (front.sense < 0) std::reverse(chunks.begin(), chunks.end());
    return chunks;
}

void FrontSweep::pack(const Front& front, Packed& packed) const {
    TubeSet& set = packed.set;
    const int channels = field_.channels().irradiance;
    set.axis = front.axis, set.sense = front.sense, set.channels = channels;
    const auto axes = axesFor(front.axis);
    for (std::size_t a = 0; a < 3; ++a)
        packed.bent.voxel[a] = static_cast<float>(field_.frame().worldFromIndex()[axes[a]][axes[a]]);
    for (std::size_t a = 0; a < 2; ++a) packed.bent.first_column[a] = origin()[axes[a]];
    packed.bent.channels = channels;
    std::vector<std::uint32_t> local(front.rays.size(), 0), stamp(front.rays.size(), 0);
    std::uint32_t block_number = 0;
    for (std::size_t from = 0; from < front.tubes.size(); from += kTubesOfBlock) {
        const std::size_t to = std::min(from + kTubesOfBlock, front.tubes.size());
        // At most 255 corners a block: tubes that hang together have far fewer, loose ones three each.
        std::size_t t = from;
        while (t < to) {
            ++block_number;
            TubeBlock block{nullptr, static_cast<std::uint32_t>(set.corners.size()),
                            static_cast<std::uint32_t>(set.tubes.size())};
            std::vector<BlockTopology::Triangle> triangles;
            std::uint32_t corners = 0;
            for (; t < to && corners + 3 < BlockTopology::kNone; ++t) {
                BlockTopology::Triangle triangle{};
                for (int c = 0; c < 3; ++c) {
                    const std::uint32_t ray = front.tubes[t].ray[c];
                    if (stamp[ray] != block_number) {
                        stamp[ray] = block_number, local[ray] = corners++;
                        CornerRay corner;
                        corner.w = front.rays[ray].voxel[front.axis], corner.w_end = front.sense * kFarLayers;
                        set.corners.push_back(corner), packed.bent.rays.push_back(ray);
                    }
                    triangle.corner[c] = static_cast<std::uint8_t>(local[ray]);
                }
                triangles.push_back(triangle);
                TubeConstants tube{};
                const glm::dvec3& power = front.tubes[t].power;
                for (int k = 0; k < 3; ++k) tube.power[k] = static_cast<float>(channels == 3 ? power[k] : power[0]);
                set.tubes.push_back(tube);
            }
            const auto same = [&](const BlockTopology& other) {
                return other.vertex_count == static_cast<int>(corners) && other.triangles.size() == triangles.size() &&
                       std::equal(
                           triangles.begin(), triangles.end(), other.triangles.begin(),
                           [](const auto& a, const auto& b) { return std::equal(a.corner, a.corner + 3, b.corner); });
            };
            block.topology = !set.blocks.empty() && same(*set.blocks.back().topology)
                                 ? set.blocks.back().topology
                                 : BlockTopology::fromTriangles(static_cast<int>(corners), std::move(triangles));
            set.blocks.push_back(std::move(block));
        }
    }
}

/// Where the index changes much within a step, a ray may gain or lose more than it should, and light that is to be
/// reflected totally leaks out of its glass: there steps are shorter.
int FrontSweep::stepsIn(const Front& front, const Chunk& chunk) const {
    constexpr double kGentle = 0.05;  // of n^2 / 2
    constexpr int kMost = 8;
    const int first = chunk.first - space_.first_node[front.axis];
    const double steep = space_.index->steepest(front.axis, first - 2, first + chunk.layers + 1);
    return std::max(space_.steps, std::min(kMost, static_cast<int>(std::ceil(steep / kGentle))));
}

void FrontSweep::march(const Front& front, const Chunk& chunk, State& state) {
    const Stopwatch watch;
    const glm::ivec3 node = space_.first_node - origin();
    const int first_w = chunk.first - origin()[front.axis];
    collapseIndex(*space_.index, {front.axis, node}, first_w, chunk.layers, front.sense, stepsIn(front, chunk),
                  state.slices);
    FrontMedia media = space_.table;
    const auto axes = axesFor(front.axis);
    const glm::ivec3 count = space_.index->nodes().count;
    const std::size_t strides[3] = {1, static_cast<std::size_t>(count.x),
                                    static_cast<std::size_t>(count.x) * static_cast<std::size_t>(count.y)};
    media.of_node = state.attenuates ? space_.media.data() : nullptr;
    media.stride_u = strides[axes[0]], media.stride_v = strides[axes[1]], media.stride_w = strides[axes[2]];

    FrontMarch march;
    march.slices = &state.slices, march.media = &media;
    std::copy_n(state.packed.bent.voxel, 3, march.voxel);
    march.first_w = first_w, march.layers = chunk.layers, march.sense = front.sense;
    march.node_w = node[front.axis];
    march.least_lit = space_.least_lit, march.channels = state.channels;
    BentRows& bent = state.packed.bent;
    bent.values.resize(front.rays.size() * bent.rayStride());
    state.before = state.rays;
    constexpr std::size_t kBatch = 1024;
    const FrontKernel kernel = frontKernel();
    parallelFor(static_cast<std::int64_t>((front.rays.size() + kBatch - 1) / kBatch), [&](std::int64_t i) {
        const std::size_t from = static_cast<std::size_t>(i) * kBatch;
        kernel(march, state.rays, from, std::min(kBatch, state.rays.u.size() - from), bent.values.data(),
               bent.rayStride());
    });
    totals_.trace_seconds += watch.seconds();
}

/// Finds the tubes that turned away in a chunk, and hands them on.
void FrontSweep::turnAway(const Front& front, const Chunk& chunk, State& state) {
    state.turned.clear();
    for (std::size_t t = 0; t < front.tubes.size(); ++t) {
        if (!state.alive[t]) continue;
        int earliest = -1;
        for (const std::uint32_t ray : front.tubes[t].ray) {
            const int lane = state.rays.stopped[ray];
            if (lane < 0) continue;
            earliest = earliest < 0 ? lane : front.sense > 0 ? std::min(earliest, lane) : std::max(earliest, lane);
        }
        if (earliest < 0) continue;
        state.turned.push_back({static_cast<std::uint32_t>(t), earliest});
        state.alive[t] = 0;
        passOn(front, chunk, state, state.turned.back());
    }
}

/// Carries a ray on through some part of a layer, with its index: straight on it would keep an energy that it does not
/// have at a face, and leave glass that reflects it.
void FrontSweep::carryOn(int axis, double layers, Front::Ray& ray) const {
    const GridFrame& frame = field_.frame();
    const SplineGradedIndex index(*space_.index);
    GradedRay on{frame.worldFromIndex(ray.voxel), ray.momentum, 0};
    constexpr int kSteps = 4;
    const double step = layers * frame.worldFromIndex()[axis][axis] / kSteps;
    for (int i = 0; i < kSteps; ++i)
        if (!stepBetweenPlanes(index, axis, step, on)) {
            // It turns around before it gets there: it goes on level from where it is.
            on.momentum[axis] = 0;
            break;
        }
    ray.voxel = frame.indexFromWorld(on.position), ray.momentum = on.momentum;
}

/// A tube's ray where it leaves its front.
struct FrontSweep::Leaving {
    Front::Ray ray;
    glm::dvec3 left{0};  ///< of its power, per channel
};

FrontSweep::Leaving FrontSweep::leave(const Front& front, const Chunk& chunk, const State& state, std::uint32_t ray,
                                      int lane) const {
    const auto axes = axesFor(front.axis);
    const BentRows& bent = state.packed.bent;
    const int before = lane - front.sense;  // the last lane that the tube passes
    // From the grid's first voxel, as rays and rows count.
    const int first_w = chunk.first - origin()[front.axis];
    const double face = first_w + lane - 0.5 * front.sense;
    Leaving out;
    glm::dvec3 slope, at;  // along (u, v, w)
    double n = 1;
    if (before >= 0 && before < chunk.layers) {
        const float* rows = &bent.values[ray * bent.rayStride()];
        const auto row = [&](int which) { return static_cast<double>(rows[which * kLanes + before]); };
        slope = {row(BentRows::kSlopeU), row(BentRows::kSlopeV), 1};
        at = {row(BentRows::kU), row(BentRows::kV), first_w + before};
        n = row(BentRows::kMomentum);
        out.ray.lit = row(BentRows::kLit) > 0;
        for (int k = 0; k < 3; ++k) out.left[k] = row(BentRows::kLeft + std::min(k, bent.channels - 1));
    } else {
        const FrontRays& r = state.before;
        slope = {double(r.pu[ray]) * double(bent.voxel[2]) / double(bent.voxel[0]),
                 double(r.pv[ray]) * double(bent.voxel[2]) / double(bent.voxel[1]), 1};
        slope.x *= front.sense / double(r.pw[ray]), slope.y *= front.sense / double(r.pw[ray]);
        at = {double(r.u[ray]), double(r.v[ray]), double(r.w[ray])};
        n = glm::length(glm::dvec3(r.pu[ray], r.pv[ray], r.pw[ray]));
        out.ray.lit = r.lit[ray] > 0;
        for (int k = 0; k < 3; ++k)
            out.left[k] = state.attenuates ? std::exp(-double(r.depth[std::min(k, bent.channels - 1)][ray])) : 1.0;
    }
    glm::dvec3 direction;
    for (int a = 0; a < 3; ++a)
        out.ray.voxel[axes[static_cast<std::size_t>(a)]] = at[a] + origin()[axes[static_cast<std::size_t>(a)]],
        direction[axes[static_cast<std::size_t>(a)]] = front.sense * slope[a] * double(bent.voxel[a]);
    out.ray.momentum = n * glm::normalize(direction);
    // On to the face, unless the ray starts beyond it.
    if (front.sense * (face - at.z) > 0) carryOn(front.axis, face - at.z, out.ray);
    return out;
}

namespace {

/// The axis and sense along which all three rays of a tube go on best; those of the front where none is good.
std::pair<int, int> bestWay(const Front& front, const Front::Ray (&rays)[3]) {
    glm::dvec3 mean(0);
    for (const Front::Ray& ray : rays) mean += glm::normalize(ray.momentum);
    std::pair<int, int> best{front.axis, front.sense};
    double best_cosine = 0.5;
    for (int a = 0; a < 3; ++a) {
        if (a == front.axis) continue;
        const int sense = mean[a] > 0 ? 1 : -1;
        double least = 1;
        for (const Front::Ray& ray : rays) least = std::min(least, sense * ray.momentum[a] / glm::length(ray.momentum));
        if (least > best_cosine) best_cosine = least, best = {a, sense};
    }
    return best;
}

}  // namespace

void FrontSweep::passOn(const Front& front, const Chunk& chunk, State& state, const Turned& turned) {
    const Front::Tube& tube = front.tubes[turned.tube];
    Front::Ray rays[3];
    glm::dvec3 left(0);
    for (int c = 0; c < 3; ++c) {
        const Leaving leaving = leave(front, chunk, state, tube.ray[c], turned.lane);
        rays[c] = leaving.ray, left += leaving.left / 3.0;
    }
    const glm::dvec3 power = tube.power * left;
    countLoss(tube.power, left);
    ++totals_.turned;
    const std::pair<int, int> best = bestWay(front, rays);
    if (best.first == front.axis) {
        totals_.power.dropped += channelMean(power);
        if (lost_) lost_->push_back(tube.source);
        return;
    }
    Front& next = state.next[best];
    next.axis = best.first, next.sense = best.second;
    auto& places = state.places[best];
    Front::Tube out;
    out.power = power, out.source = tube.source;
    for (int c = 0; c < 3; ++c) {
        const auto [place, fresh] = places.emplace(std::pair{tube.ray[c], chunk.first + turned.lane},
                                                   static_cast<std::uint32_t>(next.rays.size()));
        if (fresh) next.rays.push_back(rays[c]);
        out.ray[c] = place->second;
    }
    next.tubes.push_back(out);
}

void FrontSweep::lay(const Front& front, const Chunk& chunk, State& state) {
    TubeSet& set = state.packed.set;
    const BentRows& bent = state.packed.bent;
    for (const Turned& t : state.turned)
        for (float& power : set.tubes[t.tube].power) power = 0;
    // The buffer follows the mean slope of the light; how often a layer is evaluated follows all slopes, which are of
    // both signs where light comes together.
    set.slope_u_power = set.slope_v_power = set.slope_power = 0;
    double squares = 0;
    const std::size_t step = std::max<std::size_t>(1, front.tubes.size() / 4096);
    for (std::size_t t = 0; t < front.tubes.size(); t += step) {
        if (!state.alive[t]) continue;
        const float* rows = &bent.values[front.tubes[t].ray[0] * bent.rayStride()];
        const auto row = [&](int which) { return static_cast<double>(rows[which * kLanes + chunk.layers / 2]); };
        const double power = channelMean(front.tubes[t].power) * row(BentRows::kLit), u = row(BentRows::kSlopeU),
                     v = row(BentRows::kSlopeV);
        set.slope_power += power, set.slope_u_power += power * u, set.slope_v_power += power * v;
        squares += power * (u * u + v * v);
    }
    state.options = options_;
    if (options_.quadrature == 0)
        state.options.quadrature = set.slope_power > 0 ? pointsAcrossLayer(std::sqrt(squares / set.slope_power)) : 1;
    voxeliseSlab(set, bent, *chunk.group, chunk.slab, field_, state.options, totals_.deposit, monitor_);
    if (!state.turned.empty()) layTurned(front, chunk, state);
}

/// The last layers of tubes that turned away in this chunk: each by itself, up to its cross-section.
void FrontSweep::layTurned(const Front& front, const Chunk& chunk, State& state) {
    Front loose;
    loose.axis = front.axis, loose.sense = front.sense;
    std::vector<std::uint32_t> ray_of;
    std::vector<double> ends;
    for (const Turned& t : state.turned) {
        Front::Tube tube;
        tube.power = front.tubes[t.tube].power;
        for (int c = 0; c < 3; ++c) {
            tube.ray[c] = static_cast<std::uint32_t>(loose.rays.size());
            loose.rays.push_back(front.rays[front.tubes[t.tube].ray[c]]);
            ray_of.push_back(front.tubes[t.tube].ray[c]);
            ends.push_back(chunk.first + t.lane - 0.5 * front.sense);
        }
        loose.tubes.push_back(tube);
    }
    Packed packed;
    pack(loose, packed);
    packed.set.slope_power = state.packed.set.slope_power, packed.set.slope_u_power = state.packed.set.slope_u_power,
    packed.set.slope_v_power = state.packed.set.slope_v_power;
    for (std::size_t c = 0; c < packed.set.corners.size(); ++c) packed.set.corners[c].w_end = ends[packed.bent.rays[c]];
    const std::size_t stride = packed.bent.rayStride();
    packed.bent.values.resize(ray_of.size() * stride);
    for (std::size_t r = 0; r < ray_of.size(); ++r)
        std::copy_n(&state.packed.bent.values[ray_of[r] * stride], stride, &packed.bent.values[r * stride]);
    voxeliseSlab(packed.set, packed.bent, *chunk.group, chunk.slab, field_, state.options, totals_.deposit, monitor_);
}

void FrontSweep::countLoss(const glm::dvec3& power, const glm::dvec3& left) {
    const glm::dvec3 lost = power * (1.0 - left);
    totals_.power.absorbed_medium += channelMean(lost * space_.absorbed_share);
    totals_.power.scattered += channelMean(lost * (1.0 - space_.absorbed_share));
}

void FrontSweep::finish(const Front& front, const State& state) {
    for (std::size_t t = 0; t < front.tubes.size(); ++t) {
        if (!state.alive[t]) continue;
        glm::dvec3 left(0);
        double lit = 0;  // a tube at the rim of a medium counts by its corners
        for (const std::uint32_t ray : front.tubes[t].ray) {
            lit += double(state.rays.lit[ray]) / 3;
            for (int k = 0; k < 3; ++k)
                left[k] += (state.attenuates ? std::exp(-double(state.rays.depth[std::min(k, state.channels - 1)][ray]))
                                             : 1.0) /
                           3;
        }
        countLoss(front.tubes[t].power, left);
        const double power = channelMean(front.tubes[t].power * left);
        totals_.power.escaped += power * lit, totals_.power.culled += power * (1 - lit);
    }
}

std::vector<std::uint32_t> FrontSweep::findLost(Front front, int turns) {
    for (std::uint32_t t = 0; t < front.tubes.size(); ++t) front.tubes[t].source = t;
    std::vector<std::uint32_t> lost;
    lost_ = &lost;
    std::vector<Front> fronts{std::move(front)};
    for (int turn = 0; turn <= turns && !fronts.empty(); ++turn) {
        std::vector<Front> next;
        for (const Front& at : fronts)
            for (Front& on : run(at)) next.push_back(std::move(on));
        fronts = std::move(next);
    }
    lost_ = nullptr;
    std::sort(lost.begin(), lost.end());
    lost.erase(std::unique(lost.begin(), lost.end()), lost.end());
    return lost;
}

std::vector<Front> FrontSweep::run(const Front& front) {
    if (front.tubes.empty()) return {};
    State state;
    state.attenuates = !space_.media.empty(), state.channels = field_.channels().irradiance;
    const auto axes = axesFor(front.axis);
    state.rays.resize(front.rays.size(), state.attenuates);
    for (std::size_t r = 0; r < front.rays.size(); ++r) {
        const Front::Ray& ray = front.rays[r];
        const glm::dvec3 voxel = ray.voxel - glm::dvec3(origin());
        state.rays.u[r] = static_cast<float>(voxel[axes[0]]), state.rays.v[r] = static_cast<float>(voxel[axes[1]]),
        state.rays.w[r] = static_cast<float>(voxel[axes[2]]);
        state.rays.pu[r] = static_cast<float>(ray.momentum[axes[0]]),
        state.rays.pv[r] = static_cast<float>(ray.momentum[axes[1]]),
        state.rays.pw[r] = static_cast<float>(front.sense * ray.momentum[axes[2]]);
        state.rays.lit[r] = ray.lit ? 1.0f : 0.0f;
    }
    pack(front, state.packed);
    state.alive.assign(front.tubes.size(), 1);
    totals_.tubes += static_cast<std::int64_t>(front.tubes.size());
    totals_.rays += static_cast<std::int64_t>(front.rays.size());

    const auto groups =
        planSlabs(field_.needed(), front.axis, TileSums::kColumns, widestLanes(options_.instruction_set));
    const std::vector<Chunk> chunks = chunksOf(front, groups);
    double earliest = kFarLayers;
    for (const Front::Ray& ray : front.rays) earliest = std::min(earliest, front.sense * ray.voxel[front.axis]);
    std::size_t done = 0;
    for (const Chunk& chunk : chunks) {
        monitor_.checkCancelled();
        monitor_.progress("deposit", static_cast<double>(done++) / static_cast<double>(chunks.size()));
        const double exit = front.sense > 0 ? chunk.first + chunk.layers : -(chunk.first - 1.0);
        if (exit < earliest) continue;  // all rays start beyond it
        march(front, chunk, state);
        turnAway(front, chunk, state);
        const Stopwatch watch;
        if (chunk.group && !lost_)
            lay(front, chunk, state);
        else
            for (const Turned& t : state.turned)
                for (float& power : state.packed.set.tubes[t.tube].power) power = 0;
        totals_.deposit_seconds += watch.seconds();
    }
    finish(front, state);
    std::vector<Front> out;
    for (auto& [way, next] : state.next) out.push_back(std::move(next));
    return out;
}

}  // namespace photic
