// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/wavefront_curvature.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr int kHalo = 2, kSide = BlockGrid::kSide + 2 * kHalo;

/// First and second difference of the arrival along one axis, per cell; 0 and 0 when there is nothing to differ from.
struct Differences {
    double first = 0, second = 0;
};
Differences differences(const double* t, int step) {
    const auto reached = [&](int k) { return t[k * step] < kUnreached; };
    if (reached(-1) && reached(1)) return {0.5 * (t[step] - t[-step]), t[step] - 2 * t[0] + t[-step]};
    for (const int side : {-1, 1})
        if (reached(side)) {
            const double near = t[side * step] - t[0];
            if (!reached(2 * side)) return {side * near, 0};
            const double far = t[2 * side * step] - t[side * step];
            return {side * (1.5 * near - 0.5 * far), far - near};
        }
    return {};
}

class Padded {
public:
    /// Fills the block and two cells around it, edges and corners not needed.
    template <class Value, class Array>
    void load(const BlockGrid& grid, int slot, const Array& from, Value missing) {
        std::fill_n(values_, kSide * kSide * kSide, static_cast<double>(missing));
        copy(grid, slot, from, {0, 0, 0});
        const auto& beside = grid.neighbours(slot);
        for (int f = 0; f < 6; ++f) {
            if (beside[static_cast<std::size_t>(f)] < 0) continue;
            glm::ivec3 shift(0);
            shift[f / 2] = f % 2 == 0 ? -8 : 8;
            copy(grid, beside[static_cast<std::size_t>(f)], from, shift);
        }
    }
    const double* at(int x, int y, int z) const { return &values_[index(x, y, z)]; }
    /// Leaves out the source's arrival where there is one.
    void subtract(const PointSource& source, const glm::dvec3& origin, double h) {
        for (int z = -kHalo; z < 8 + kHalo; ++z)
            for (int y = -kHalo; y < 8 + kHalo; ++y)
                for (int x = -kHalo; x < 8 + kHalo; ++x)
                    if (double& t = values_[index(x, y, z)]; t < kUnreached)
                        t -= source.arrival(origin + h * glm::dvec3(x, y, z));
    }
    static int step(int axis) { return axis == 0 ? 1 : axis == 1 ? kSide : kSide * kSide; }

private:
    static std::size_t index(int x, int y, int z) {
        return static_cast<std::size_t>(((z + kHalo) * kSide + y + kHalo) * kSide + x + kHalo);
    }
    template <class Array>
    void copy(const BlockGrid&, int slot, const Array& from, const glm::ivec3& shift) {
        const glm::ivec3 low = glm::max(shift, glm::ivec3(-kHalo)), high = glm::min(shift + 8, glm::ivec3(8 + kHalo));
        for (int z = low.z; z < high.z; ++z)
            for (int y = low.y; y < high.y; ++y)
                for (int x = low.x; x < high.x; ++x)
                    values_[index(x, y, z)] = static_cast<double>(
                        from[static_cast<std::size_t>(slot) * BlockGrid::kCells +
                             static_cast<std::size_t>((z - shift.z) << 6 | (y - shift.y) << 3 | (x - shift.x))]);
    }
    double values_[kSide * kSide * kSide];
};

}  // namespace

void wavefrontCurvature(const EikonalProblem& problem, std::span<const double> arrival,
                        const std::function<void(int, const FrontBlock&)>& visit) {
    const BlockGrid& grid = *problem.grid;
    const double h = problem.spacing;
    parallelFor(grid.blockCount(), [&](std::int64_t s) {
        const int slot = static_cast<int>(s);
        thread_local Padded t, n;
        thread_local FrontBlock out;
        t.load(grid, slot, arrival, kUnreached);
        const glm::dvec3 origin =
            problem.source ? h * glm::dvec3(grid.origin(slot)) - problem.source->place : glm::dvec3(0);
        if (problem.source) t.subtract(*problem.source, origin, h);
        const bool varies = !problem.slownesses.empty();
        // Outside of the grid the slowness goes on as it is: its gradient there is not known.
        if (varies) n.load(grid, slot, problem.slownesses, -1.0);
        for (int c = 0; c < BlockGrid::kCells; ++c) {
            const int x = c & 7, y = c >> 3 & 7, z = c >> 6;
            const double* here = t.at(x, y, z);
            out.curvature[c] = 0;
            for (auto& d : out.direction) d[c] = 0;
            if (!(*here < kUnreached)) continue;
            double lap = 0, squared = 0, across = 0;
            glm::dvec3 gradient(0);
            if (problem.source) {
                const glm::dvec3 d = origin + h * glm::dvec3(x, y, z);
                if (d != glm::dvec3(0))
                    lap = h * h * problem.source->laplacian(d), gradient = h * problem.source->slope(d);
            }
            const double slowness = varies ? *n.at(x, y, z) : problem.slowness;
            for (int a = 0; a < 3; ++a) {
                const Differences d = differences(here, Padded::step(a));
                lap += d.second, gradient[a] += d.first, squared += gradient[a] * gradient[a];
                if (!varies) continue;
                const double *m = n.at(x, y, z), low = m[-Padded::step(a)], high = m[Padded::step(a)];
                const double up = high > 0 ? high : slowness, down = low > 0 ? low : slowness;
                across += gradient[a] * (up - down) / ((high > 0) + (low > 0) > 1 ? 2.0 : 1.0);
            }
            out.curvature[c] = (lap / slowness - across / (slowness * slowness)) / (h * h);
            const double length = std::sqrt(squared);
            if (length > 0)
                for (int a = 0; a < 3; ++a) out.direction[a][c] = gradient[a] / length;
        }
        visit(slot, out);
    });
}

}  // namespace photic
