// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/block_marching.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>

#include "bake/numerics/march_kernel.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

// A block that is still restless after this many visits goes on in first order, whose updates cannot cycle.
constexpr std::uint16_t kPatience = 150;

template <class Real>
void atomicMin(std::atomic<Real>& to, Real value) {
    Real seen = to.load(std::memory_order_relaxed);
    while (value < seen && !to.compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
    }
}

/// Keys of rows are kept in single precision; early is harmless, late is not.
float floatBelow(double value) {
    const auto f = static_cast<float>(value);
    return static_cast<double>(f) > value ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

class BlockMarcher {
public:
    BlockMarcher(const EikonalProblem& problem, const BlockMarchingOptions& options, std::span<double> arrival)
        : problem_(problem),
          options_(options),
          grid_(*problem.grid),
          arrival_(arrival),
          row_key_(grid_.cellCount() / BlockGrid::kSide),
          key_(static_cast<std::size_t>(grid_.blockCount())),
          slowness_(meanSlowness()),
          visits_(static_cast<std::size_t>(grid_.blockCount())) {
        for (auto& k : key_) k.store(kNever, std::memory_order_relaxed);
        for (auto& k : row_key_) k.store(std::numeric_limits<float>::infinity(), std::memory_order_relaxed);
    }

    BlockMarchingReport run() {
        seed();
        const double band = options_.band * problem_.spacing * slowness_;
        std::vector<int> chosen[2];
        for (;; ++report_.rounds) {
            double earliest = kNever;
            for (const int slot : queue_) earliest = std::min(earliest, keyOf(slot));
            if (!(earliest < kUnreached)) break;
            if (report_.rounds % 16 == 15) {
                if (options_.progress) options_.progress(reachedFraction());
                if (neededDone(earliest)) {
                    report_.stopped_early = true;
                    break;
                }
            }
            if (report_.rounds > limit()) {
                report_.converged = false;
                break;
            }
            limit_ = earliest + band;
            chosen[0].clear(), chosen[1].clear();
            for (const int slot : queue_)
                if (keyOf(slot) <= limit_) chosen[colour(slot)].push_back(slot);
            for (const auto& blocks : chosen) advance(blocks);
            rebuildQueue();
        }
        for (const auto visits : visits_) report_.first_order_blocks += visits > kPatience;
        return report_;
    }

private:
    double keyOf(int slot) const { return key_[static_cast<std::size_t>(slot)].load(std::memory_order_relaxed); }
    int colour(int slot) const {
        const glm::ivec3 b = grid_.origin(slot) / BlockGrid::kSide;
        return (b.x + b.y + b.z) & 1;
    }
    std::int64_t limit() const {
        return 64 * (std::int64_t(grid_.blocks().x) + grid_.blocks().y + grid_.blocks().z) + 4096;
    }
    double meanSlowness() const {
        if (problem_.slownesses.empty()) return problem_.slowness;
        double sum = 0;
        for (const float n : problem_.slownesses) sum += static_cast<double>(n);
        return sum / static_cast<double>(problem_.slownesses.size());
    }

    /// Clears what is not fixed; every row beside a seed is due.
    void seed() {
        const int blocks = grid_.blockCount();
        parallelFor(blocks, [&](std::int64_t s) {
            const std::uint8_t* fixed = problem_.fixed->block(static_cast<int>(s));
            double* t = &arrival_[static_cast<std::size_t>(s) * BlockGrid::kCells];
            for (int r = 0; r < 64; ++r)
                for (int l = 0; l < 8; ++l)
                    if (!(fixed[r] >> l & 1)) t[r * 8 + l] = kUnreached;
        });
        for (int slot = 0; slot < blocks; ++slot) {
            const std::uint8_t* fixed = problem_.fixed->block(slot);
            const double* t = &arrival_[static_cast<std::size_t>(slot) * BlockGrid::kCells];
            double least = kUnreached;
            bool any_fixed = false;
            for (int r = 0; r < 64; ++r) {
                if (fixed[r] == 0) continue;
                for (int l = 0; l < 8; ++l)
                    if (fixed[r] >> l & 1) least = std::min(least, t[r * 8 + l]);
                any_fixed = true;
            }
            if (!any_fixed || !(least < kUnreached)) continue;
            markAll(slot, least);
            for (const int beside : grid_.neighbours(slot))
                if (beside >= 0) markAll(beside, least);
        }
        for (int slot = 0; slot < blocks; ++slot)
            if (keyOf(slot) < kUnreached) queue_.push_back(slot);
    }
    void markAll(int slot, double key) {
        for (std::size_t r = 0; r < 64; ++r)
            atomicMin(row_key_[static_cast<std::size_t>(slot) * 64 + r], floatBelow(key));
        atomicMin(key_[static_cast<std::size_t>(slot)], key);
    }

    /// All blocks of one colour, side by side.
    void advance(const std::vector<int>& blocks) {
        constexpr std::size_t kTask = 4;
        std::atomic<std::int64_t> updates{0};
        parallelFor(static_cast<std::int64_t>((blocks.size() + kTask - 1) / kTask), [&](std::int64_t task) {
            LocalBlock local;
            local.uniform_cost = problem_.slowness * problem_.spacing;
            local.varies = !problem_.slownesses.empty(), local.factored = problem_.source != nullptr;
            // How much earlier than a cell one may be that depends on it.
            const double turning = problem_.order == MarchingOrder::Second ? kFarLater : 0;
            local.slack = (local.factored ? 1 : turning) * problem_.spacing * slowness_;
            std::fill_n(local.cost, 8, local.uniform_cost);
            std::int64_t sum = 0;
            const std::size_t end = std::min(blocks.size(), (static_cast<std::size_t>(task) + 1) * kTask);
            for (std::size_t i = static_cast<std::size_t>(task) * kTask; i < end; ++i) sum += visit(blocks[i], local);
            updates += sum;
        });
        report_.visits += static_cast<std::int64_t>(blocks.size());
        report_.row_updates += updates;
    }

    std::int64_t visit(int slot, LocalBlock& local) {
        const auto s = static_cast<std::size_t>(slot);
        std::atomic<float>* keys = &row_key_[s * 64];
        for (std::size_t r = 0; r < 64; ++r)
            local.key[r] = static_cast<double>(keys[r].load(std::memory_order_relaxed));
        local.limit = limit_;
        local.second_order = problem_.order == MarchingOrder::Second && visits_[s] < kPatience;
        if (visits_[s] <= kPatience) ++visits_[s];
        local.fixed = problem_.fixed->block(slot);
        local.tolerance = options_.tolerance * problem_.spacing * slowness_;
        local.settled = std::sqrt(options_.tolerance) * 0.1 * problem_.spacing * slowness_;
        load(slot, local);
        if (problem_.source) missesOf(slot, local);
        solve_block_(local);
        store(slot, local);
        double least = kNever;
        for (std::size_t r = 0; r < 64; ++r) {
            least = std::min(least, local.key[r]);
            keys[r].store(floatBelow(local.key[r]), std::memory_order_relaxed);
        }
        key_[s].store(least, std::memory_order_relaxed);
        const auto& beside = grid_.neighbours(slot);
        for (std::size_t f = 0; f < 6; ++f) {
            if (beside[f] < 0) continue;
            const auto to = static_cast<std::size_t>(beside[f]);
            double first = kNever;
            for (std::uint64_t rows = local.leaving[f]; rows != 0; rows &= rows - 1) {
                const auto r = static_cast<std::size_t>(std::countr_zero(rows));
                first = std::min(first, local.leaving_key[f][r]);
                atomicMin(row_key_[to * 64 + r], floatBelow(local.leaving_key[f][r]));
            }
            if (first < kNever) atomicMin(key_[to], first);
        }
        return local.updates;
    }

    void load(int slot, LocalBlock& local) const {
        const double* own = &arrival_[static_cast<std::size_t>(slot) * BlockGrid::kCells];
        for (int z = 0; z < 8; ++z)
            for (int y = 0; y < 8; ++y) std::memcpy(local.t + LocalBlock::row(y, z), own + (z * 8 + y) * 8, 64);
        const auto& beside = grid_.neighbours(slot);
        const auto block = [&](std::size_t face) {
            return beside[face] < 0 ? nullptr : &arrival_[static_cast<std::size_t>(beside[face]) * BlockGrid::kCells];
        };
        const double *xm = block(0), *xp = block(1), *ym = block(2), *yp = block(3), *zm = block(4), *zp = block(5);
        for (int z = 0; z < 8; ++z)
            for (int y = 0; y < 8; ++y) {
                double* row = local.t + LocalBlock::row(y, z);
                const int at = (z * 8 + y) * 8;
                row[-2] = xm ? xm[at + 6] : kUnreached, row[-1] = xm ? xm[at + 7] : kUnreached;
                row[8] = xp ? xp[at] : kUnreached, row[9] = xp ? xp[at + 1] : kUnreached;
            }
        const auto copyRow = [&](int y, int z, const double* from, int from_y, int from_z) {
            double* row = local.t + LocalBlock::row(y, z);
            if (from)
                std::memcpy(row, from + (from_z * 8 + from_y) * 8, 64);
            else
                std::fill_n(row, 8, kUnreached);
        };
        for (int k = 0; k < 8; ++k)
            for (int d = 0; d < 2; ++d) {
                copyRow(-2 + d, k, ym, 6 + d, k), copyRow(8 + d, k, yp, d, k);
                copyRow(k, -2 + d, zm, k, 6 + d), copyRow(k, 8 + d, zp, k, d);
            }
        if (local.varies)
            for (std::size_t i = 0; i < BlockGrid::kCells; ++i)
                local.cost[i] =
                    problem_.spacing *
                    static_cast<double>(problem_.slownesses[static_cast<std::size_t>(slot) * BlockGrid::kCells + i]);
    }

    /// What differences of the source's arrival T0 miss. One-sided differences of u = T - T0 plus T0's own derivative
    /// are those of T with their neighbours' value moved by T0 - value(T0) -+ (1 or 2/3) h dT0.
    void missesOf(int slot, LocalBlock& local) const {
        const PointSource& source = *problem_.source;
        const double h = problem_.spacing;
        const glm::dvec3 origin = h * glm::dvec3(grid_.origin(slot)) - source.place;
        for (int c = 0; c < BlockGrid::kCells; ++c) {
            const glm::dvec3 d = origin + h * glm::dvec3(c & 7, c >> 3 & 7, c >> 6);
            const double here = source.arrival(d);
            const glm::dvec3 slope = here > 0 ? source.slope(d) : glm::dvec3(0);
            for (int axis = 0; axis < 3; ++axis)
                for (int side = 0; side < 2; ++side) {
                    glm::dvec3 step(0);
                    step[axis] = side == 0 ? -h : h;
                    const double near = source.arrival(d + step), far = source.arrival(d + 2.0 * step);
                    const double along = step[axis] * slope[axis];  // -h dT0 towards lower cells
                    local.misses[axis][side][0][c] = here - near + along;
                    local.misses[axis][side][1][c] = here - (4 * near - far) / 3 + 2.0 / 3 * along;
                }
        }
    }

    void store(int slot, const LocalBlock& local) {
        double* own = &arrival_[static_cast<std::size_t>(slot) * BlockGrid::kCells];
        for (std::uint64_t rows = local.changed; rows != 0; rows &= rows - 1) {
            const int r = std::countr_zero(rows);
            std::memcpy(own + r * 8, local.t + LocalBlock::row(r & 7, r >> 3), 64);
        }
    }

    /// Blocks that wait, in the order of their slots: the same for any number of threads.
    void rebuildQueue() {
        queue_.clear();
        const int blocks = grid_.blockCount();
        for (int slot = 0; slot < blocks; ++slot)
            if (keyOf(slot) < kUnreached) queue_.push_back(slot);
    }

    bool neededDone(double earliest) const {
        if (options_.needed_blocks.empty()) return false;
        for (int slot = 0; slot < grid_.blockCount(); ++slot) {
            if (!options_.needed_blocks[static_cast<std::size_t>(slot)]) continue;
            const std::uint8_t* fixed = problem_.fixed->block(slot);
            const double* t = &arrival_[static_cast<std::size_t>(slot) * BlockGrid::kCells];
            for (int r = 0; r < 64; ++r)
                for (int l = 0; l < 8; ++l)
                    if (!(fixed[r] >> l & 1) && t[r * 8 + l] >= earliest) return false;
        }
        return true;
    }
    double reachedFraction() const {
        std::size_t reached = 0;
        for (int slot = 0; slot < grid_.blockCount(); ++slot)
            reached += arrival_[static_cast<std::size_t>(slot) * BlockGrid::kCells + 255] < kUnreached;
        return static_cast<double>(reached) / static_cast<double>(std::max(1, grid_.blockCount()));
    }

    const EikonalProblem& problem_;
    const BlockMarchingOptions& options_;
    const BlockGrid& grid_;
    std::span<double> arrival_;
    std::vector<std::atomic<float>> row_key_;
    std::vector<std::atomic<double>> key_;
    const double slowness_;
    std::vector<std::uint16_t> visits_;
    std::vector<int> queue_;
    double limit_ = 0;
    const SolveBlock solve_block_ = blockSolver();
    BlockMarchingReport report_;
};

}  // namespace

BlockMarchingReport marchBlocks(const EikonalProblem& problem, const BlockMarchingOptions& options,
                                std::span<double> arrival) {
    return BlockMarcher(problem, options, arrival).run();
}

}  // namespace photic
