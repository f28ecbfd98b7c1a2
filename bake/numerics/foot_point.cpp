// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/foot_point.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "bake/numerics/foot_kernel.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr int kMaxRepairs = 16;  // of a layer whose neighbours know better feet

// Of the largest coordinate: points nearer to the surface than this lie on it. The way from their feet would be
// rounding by more than a millionth.
constexpr double kOnSurface = 1e6 * std::numeric_limits<double>::epsilon();

constexpr std::vector<double> FootPointLayer::*kFields[] = {
    &FootPointLayer::foot_x,    &FootPointLayer::foot_y,  &FootPointLayer::foot_z,  &FootPointLayer::foot_arrival,
    &FootPointLayer::slope_x,   &FootPointLayer::slope_y, &FootPointLayer::arrival, &FootPointLayer::distance,
    &FootPointLayer::curvature, &FootPointLayer::spread};

class FootPointSweep {
public:
    FootPointSweep(const FrontOnSurface& front, const PointLayers& points)
        : front_(front),
          points_(points),
          nx_(static_cast<std::size_t>(points.count_x)),
          ny_(static_cast<std::size_t>(points.count_y)),
          above_(points.count_x, points.count_y),
          here_(points.count_x, points.count_y),
          corner_(points.origin) {
        const double* c = front.surface->coefficients();
        const auto [low, high] =
            std::minmax_element(c, c + std::ptrdiff_t(front.surface->countX()) * front.surface->countY());
        lowest_ = *low, highest_ = *high;
        for (const double x : {px(0), px(nx_ - 1), py(0), py(ny_ - 1), lowest_, highest_})
            on_surface_ = std::max(on_surface_, kOnSurface * std::fabs(x));
    }

    void run(const std::function<bool(int, const FootPointLayer&)>& visit) {
        for (int k = 0; k < points_.count_z; ++k) {
            corner_ = points_.origin + static_cast<double>(k) * points_.step_z;
            if (corner_.z > highest_) {  // all of it lies above: both layers still say so
                if (!visit(k, here_)) return;
                continue;
            }
            // What is overwritten holds the feet of the layer above the one above, which the guess looks back at.
            std::swap(above_, here_);
            rows([&](std::size_t j) {
                const FootRow row = rowOf(j);
                kernels_.guess(front_, row, above_, here_);
                kernels_.solve(front_, row, here_);
                closeRow(j);
            });
            repair();
            if (!visit(k, here_)) return;
        }
    }

private:
    template <class Body>
    void rows(const Body& body) {
        constexpr std::size_t kTask = 8;
        parallelFor(static_cast<std::int64_t>((ny_ + kTask - 1) / kTask), [&](std::int64_t task) {
            const std::size_t end = std::min(ny_, (static_cast<std::size_t>(task) + 1) * kTask);
            for (std::size_t j = static_cast<std::size_t>(task) * kTask; j < end; ++j) body(j);
        });
    }
    double px(std::size_t i) const { return corner_.x + points_.step_x * static_cast<double>(i); }
    double py(std::size_t j) const { return corner_.y + points_.step_y * static_cast<double>(j); }
    FootRow rowOf(std::size_t j) const {
        return {here_.at(0, j),
                points_.count_x,
                corner_.x,
                points_.step_x,
                py(j),
                corner_.z,
                2 * std::max(points_.step_x, points_.step_y)};
    }

    /// Marks what lies above the surface, and the space between rows that the last register has written to.
    void closeRow(std::size_t j) {
        for (std::size_t i = nx_; i < here_.pitch - FootPointLayer::kBetween; ++i) mark(here_.at(i, j));
        const double z = corner_.z + on_surface_;
        if (z < lowest_) return;
        for (std::size_t i = 0; i < nx_; ++i)
            if (z >= front_.surface->at({px(i), py(j)}).h) mark(here_.at(i, j));
    }
    void mark(std::size_t at) { here_.arrival[at] = here_.foot_arrival[at] = FootPointLayer::kAboveSurface; }

    /// Arrival at a point by the foot that another point found.
    double by(std::size_t other, std::size_t i, std::size_t j) const {
        const double dx = px(i) - here_.foot_x[other], dy = py(j) - here_.foot_y[other],
                     dz = corner_.z - here_.foot_z[other];
        return here_.foot_arrival[other] + front_.slowness * std::sqrt(dx * dx + dy * dy + dz * dz);
    }

    struct Better {
        std::size_t i, j;
        double x, y;  // a foot to try
    };
    /// Feet that a neighbour knows to be better are taken over, until there are none.
    void repair() {
        const double margin = 1e-9 * points_.step_x * front_.slowness;
        std::vector<std::vector<Better>> found(ny_);
        for (int round = 0; round < kMaxRepairs; ++round) {
            std::atomic<bool> some{false};
            rows([&](std::size_t j) {
                found[j].clear();
                if (!kernels_.improvable(front_, rowOf(j), margin, here_)) return;
                some = true;
                for (std::size_t i = 0; i < nx_; ++i) {
                    const std::size_t at = here_.at(i, j);
                    if (here_.arrival[at] >= FootPointLayer::kAboveSurface) continue;
                    double least = here_.arrival[at] - margin;
                    std::size_t best = at;
                    for (const std::size_t n : {at - 1, at + 1, at - here_.pitch, at + here_.pitch})
                        if (const double t = by(n, i, j); t < least) least = t, best = n;
                    if (best != at) found[j].push_back({i, j, here_.foot_x[best], here_.foot_y[best]});
                }
            });
            if (!some) return;
            rows([&](std::size_t j) {
                if (found[j].empty()) return;
                FootPointLayer one(1, 1);
                for (const Better& b : found[j]) {
                    one.foot_x.assign(one.foot_x.size(), b.x), one.foot_y.assign(one.foot_y.size(), b.y);
                    FootRow row = rowOf(j);
                    row.first = one.at(0, 0), row.count = 1, row.x0 = px(b.i);
                    kernels_.solve(front_, row, one);
                    const std::size_t at = here_.at(b.i, b.j);
                    if (!(one.arrival[row.first] < here_.arrival[at])) continue;
                    for (const auto field : kFields) (here_.*field)[at] = (one.*field)[row.first];
                }
            });
        }
    }

    const FrontOnSurface& front_;
    const PointLayers& points_;
    std::size_t nx_, ny_;
    FootPointLayer above_, here_;
    glm::dvec3 corner_{0};
    double lowest_ = 0, highest_ = 0;  // the surface lies between
    double on_surface_ = 0;            // [m]
    const FootKernels kernels_ = footKernels();
};

}  // namespace

FootPointLayer::FootPointLayer(int count_x, int count_y)
    : pitch((static_cast<std::size_t>(count_x) + kBetween - 1) / kBetween * kBetween + kBetween) {
    const std::size_t size = (static_cast<std::size_t>(count_y) + 2) * pitch + kBetween;
    for (const auto field : kFields) (this->*field).assign(size, 0.0);
    arrival.assign(size, kAboveSurface), foot_arrival.assign(size, kAboveSurface);
}

void sweepFootPoints(const FrontOnSurface& front, const PointLayers& points,
                     const std::function<bool(int, const FootPointLayer&)>& visit) {
    FootPointSweep(front, points).run(visit);
}

}  // namespace photic
