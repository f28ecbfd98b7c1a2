// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/spline_index.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "bake/report/error.h"
#include "bake/scene/vector_clones.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr double kMostNodes = 1073741824.0;  // 2^30: 4 GiB

/// Lines of nodes that are filtered together: their recurrences go side by side, and what is fetched is used.
constexpr std::size_t kSideBySide = 16;

/// 1 / (4 - the one before): what elimination divides by, the same for all lines.
std::vector<double> pivotsOf(std::size_t count) {
    std::vector<double> pivots(count, 0);
    for (std::size_t i = 1; i + 1 < count; ++i) pivots[i] = 1 / (4 - pivots[i - 1]);
    return pivots;
}

/// Samples of kSideBySide lines, in place, to the coefficients of the splines through them that go on straight beyond
/// the ends: c[i - 1] + 4 c[i] + c[i + 1] = 6 f[i], and c = f at both ends [Unser 1999].
void prefilterLines(std::vector<double>& lines, const std::vector<double>& pivots) {
    const std::size_t last = pivots.size() - 1;
    for (std::size_t i = 1; i < last; ++i) {
        double* here = &lines[i * kSideBySide];
        const double* before = here - kSideBySide;
        for (std::size_t s = 0; s < kSideBySide; ++s) here[s] = (6 * here[s] - before[s]) * pivots[i];
    }
    for (std::size_t i = last; i-- > 1;) {
        double* here = &lines[i * kSideBySide];
        const double* after = here + kSideBySide;
        for (std::size_t s = 0; s < kSideBySide; ++s) here[s] -= pivots[i] * after[s];
    }
}

inline CubicWeights weightsAt(double t) {
    const double u = 1 - t, t2 = t * t, u2 = u * u;
    return {{u2 * u / 6, (4 - 6 * t2 + 3 * t2 * t) / 6, (4 - 6 * u2 + 3 * u2 * u) / 6, t2 * t / 6},
            {-u2 / 2, (3 * t - 4) * t / 2, (4 - 3 * u) * u / 2, t2 / 2}};
}

}  // namespace

CubicWeights cubicBSpline(double t) { return weightsAt(t); }

SplineIndex::SplineIndex(const Nodes& nodes, const std::function<double(const glm::dvec3&)>& half_square, SplineFit fit)
    : nodes_(nodes), fit_(fit) {
    const double count = double(nodes.count.x) * nodes.count.y * nodes.count.z;
    if (count > kMostNodes)
        throw Error(ErrorCode::Input, fmt::format("the index of refraction would take {} x {} x {} samples; the limit "
                                                  "is 2^30: use larger voxels, or a smaller domain",
                                                  nodes.count.x, nodes.count.y, nodes.count.z));
    coefficients_.resize(static_cast<std::size_t>(count));
    sample(half_square);
    constexpr double kJump = 0.25;
    if (fit == SplineFit::Auto) fit_ = steepest_ > kJump ? SplineFit::Plain : SplineFit::Through;
    if (fit_ == SplineFit::Through)
        for (int axis = 0; axis < 3; ++axis) prefilter(axis);
}

void SplineIndex::sample(const std::function<double(const glm::dvec3&)>& half_square) {
    const glm::ivec3 count = nodes_.count;
    std::vector<double> least(static_cast<std::size_t>(count.z)), largest(least), step(least);
    std::vector<std::string> wrong(least.size());  // of each layer: the lowest is told, whichever thread is first
    parallelFor(count.z, [&](std::int64_t layer) {
        const int z = static_cast<int>(layer);
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x) {
                const glm::dvec3 world = nodes_.first_world + glm::dvec3(x, y, z) * nodes_.spacing;
                const double g = half_square(world);
                if (!(g > 0) || !std::isfinite(g)) {
                    wrong[static_cast<std::size_t>(z)] = fmt::format(
                        "the square of the index is {:.4g} at ({:.4g}, {:.4g}, {:.4g}) m; it must be above 0", 2 * g,
                        world.x, world.y, world.z);
                    return;
                }
                coefficients_[flat(x, y, z)] = static_cast<float>(g);
                low = std::min(low, g), high = std::max(high, g);
            }
        least[static_cast<std::size_t>(z)] = low, largest[static_cast<std::size_t>(z)] = high;
    });
    for (const std::string& why : wrong)
        if (!why.empty()) throw Error(ErrorCode::Input, why);
    least_ = *std::min_element(least.begin(), least.end()),
    largest_ = *std::max_element(largest.begin(), largest.end());
    parallelFor(count.z, [&](std::int64_t layer) {
        const int z = static_cast<int>(layer);
        double most = 0;
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x) {
                const double here = double(coefficients_[flat(x, y, z)]);
                for (const glm::ivec3 d : {glm::ivec3(1, 0, 0), {0, 1, 0}, {0, 0, 1}}) {
                    const glm::ivec3 n = glm::ivec3(x, y, z) + d;
                    if (n.x < count.x && n.y < count.y && n.z < count.z)
                        most = std::max(most, std::fabs(double(coefficients_[flat(n.x, n.y, n.z)]) - here));
                }
            }
        step[static_cast<std::size_t>(z)] = most;
    });
    if (largest_ > least_) steepest_ = *std::max_element(step.begin(), step.end()) / (largest_ - least_);
}

void SplineIndex::prefilter(int axis) {
    // Lines side by side are neighbours in memory, but for those along x.
    const int a = axis == 0 ? 1 : 0, b = 3 - axis - a;
    const std::size_t strides[3] = {1, flat(0, 1, 0), flat(0, 0, 1)};
    const auto count = static_cast<std::size_t>(nodes_.count[axis]), beside = static_cast<std::size_t>(nodes_.count[a]);
    const std::vector<double> pivots = pivotsOf(count);
    parallelFor(nodes_.count[b], [&](std::int64_t j) {
        std::vector<double> lines(count * kSideBySide, 0.0);
        for (std::size_t from = 0; from < beside; from += kSideBySide) {
            const std::size_t side = std::min(kSideBySide, beside - from);
            float* first = &coefficients_[static_cast<std::size_t>(j) * strides[b] + from * strides[a]];
            for (std::size_t i = 0; i < count; ++i)
                for (std::size_t s = 0; s < side; ++s)
                    lines[i * kSideBySide + s] = double(first[i * strides[axis] + s * strides[a]]);
            prefilterLines(lines, pivots);
            for (std::size_t i = 0; i < count; ++i)
                for (std::size_t s = 0; s < side; ++s)
                    first[i * strides[axis] + s * strides[a]] = static_cast<float>(lines[i * kSideBySide + s]);
        }
    });
}

double SplineIndex::steepest(int axis, int first, int last) const {
    glm::ivec3 low(0), high = nodes_.count - 1;
    low[axis] = std::clamp(first, 0, nodes_.count[axis] - 1), high[axis] = std::clamp(last, 0, nodes_.count[axis] - 1);
    std::vector<float> most(static_cast<std::size_t>(high.z - low.z + 1), 0.0f);
    parallelFor(high.z - low.z + 1, [&](std::int64_t layer) {
        const int z = low.z + static_cast<int>(layer);
        float step = 0;
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x) {
                const float here = coefficients_[flat(x, y, z)];
                if (x < high.x) step = std::max(step, std::fabs(coefficients_[flat(x + 1, y, z)] - here));
                if (y < high.y) step = std::max(step, std::fabs(coefficients_[flat(x, y + 1, z)] - here));
                if (z < high.z) step = std::max(step, std::fabs(coefficients_[flat(x, y, z + 1)] - here));
            }
        most[static_cast<std::size_t>(layer)] = step;
    });
    return double(*std::max_element(most.begin(), most.end()));
}

PHOTIC_VECTOR_CLONES
IndexSample SplineIndex::at(const glm::dvec3& world) const {
    const glm::dvec3 p = (world - nodes_.first_world) / nodes_.spacing;
    int cell[3] = {0, 0, 0};
    CubicWeights w[3] = {};
    bool beyond[3] = {false, false, false};
    for (int a = 0; a < 3; ++a) {
        const double inside = std::clamp(p[a], 1.0, nodes_.count[a] - 2.0);
        beyond[a] = inside != p[a];
        cell[a] = std::min(static_cast<int>(inside), nodes_.count[a] - 3);
        w[a] = weightsAt(inside - cell[a]);
    }
    // Rows along x side by side: the planes are summed first, with values and slopes across them.
    typedef double Four __attribute__((vector_size(4 * sizeof(double))));
    typedef float FourFloats __attribute__((vector_size(4 * sizeof(float))));
    Four value{}, slope_y{}, slope_z{};
    for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 4; ++j) {
            FourFloats row;
            std::memcpy(&row, &coefficients_[flat(cell[0] - 1, cell[1] - 1 + j, cell[2] - 1 + k)], sizeof(row));
            const Four c = __builtin_convertvector(row, Four);
            value += w[2].value[k] * w[1].value[j] * c;
            slope_y += w[2].value[k] * w[1].slope[j] * c;
            slope_z += w[2].slope[k] * w[1].value[j] * c;
        }
    IndexSample out{0, glm::dvec3(0)};
    for (int i = 0; i < 4; ++i) {
        out.half_square += w[0].value[i] * value[i], out.gradient.x += w[0].slope[i] * value[i];
        out.gradient.y += w[0].value[i] * slope_y[i], out.gradient.z += w[0].value[i] * slope_z[i];
    }
    out.gradient /= nodes_.spacing;
    for (int a = 0; a < 3; ++a)
        if (beyond[a]) out.gradient[a] = 0;
    return out;
}

}  // namespace photic
