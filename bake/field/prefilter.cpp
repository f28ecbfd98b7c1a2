// SPDX-License-Identifier: Apache-2.0
#include "bake/field/prefilter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/vec3.hpp>
#include <vector>

#include "bake/field/post_process.h"
#include "bake/threads/parallel_for.h"

// A voxel holds the mean of the light over its cell. The mean over a cell of the piecewise linear function through
// values u is [1/8, 3/4, 1/8] * u, so a reader who interpolates the stored means sees them blurred by that kernel once
// more; storing u instead makes the interpolant's means right. Per axis that is a tridiagonal system: 3/4 on the
// diagonal, 1/8 beside it, and at an end 7/8, for what is mirrored there (u[-1] = u[0]). It is solved by elimination
// forwards and substitution backwards: the two-sided recursive filter whose pole is p = -3 + 2 sqrt(2), with the
// coefficients near the ends exact. The matrix is diagonally dominant, so single precision is enough.
//
// The solution is the stored mean and what crosses its faces: u[i] = e[i] + F[i-1] - F[i], F[i] = (u[i+1] - u[i]) / 8
// being the light that voxel i hands to i+1. Handed over in that form light is neither made nor lost, whatever share
// of each F is let through. Where light is so uneven that a voxel would hand on more than it can spare, all that it
// gives is cut to the same share (flux-corrected transport: Zalesak, J. Comput. Phys. 31, 1979, eqs. 10-13, with a
// lower bound only: peaks are what the filter is for). Beside darkness the light ends, as it does at the ends of what
// is needed: the filter would ring there, far into even light.

namespace photic {
namespace {

constexpr std::size_t kLeaf = LightField::kLeafVoxels;
constexpr int kLines = 64;  // lines of voxels side by side in a row of leaves
constexpr float kSide = 0.125f;
// A voxel keeps at least this share of the least of itself and its neighbours. With nothing kept the dark side of a
// coarse caustic goes to 0, with all of it fine caustics are hardly sharpened.
constexpr float kKept = 0.5f;
constexpr float kNegligible = 1e-6f;  // of the largest value in a row of leaves

// Copies one channel of a leaf to planes [position along the axis][line], and back.
void loadPlanes(const float* leaf, int axis, float* planes) {
    if (axis == 0) {
        std::memcpy(planes, leaf, sizeof(float) * kLeaf);
    } else if (axis == 1) {
        for (int x = 0; x < 8; ++x)
            for (int y = 0; y < 8; ++y)
                std::memcpy(planes + y * kLines + x * 8, leaf + x * 64 + y * 8, 8 * sizeof(float));
    } else {
        for (int line = 0; line < kLines; ++line)
            for (int z = 0; z < 8; ++z) planes[z * kLines + line] = leaf[line * 8 + z];
    }
}

void storePlanes(const float* planes, int axis, float* leaf) {
    if (axis == 0) {
        std::memcpy(leaf, planes, sizeof(float) * kLeaf);
    } else if (axis == 1) {
        for (int x = 0; x < 8; ++x)
            for (int y = 0; y < 8; ++y)
                std::memcpy(leaf + x * 64 + y * 8, planes + y * kLines + x * 8, 8 * sizeof(float));
    } else {
        for (int line = 0; line < kLines; ++line)
            for (int z = 0; z < 8; ++z) leaf[line * 8 + z] = planes[z * kLines + line];
    }
}

// Elimination coefficients of a run of n voxels, the same for every line: pivot[i] = 1 / (d_i - upper[i-1] / 8).
struct RunCoefficients {
    std::vector<float> pivot;
    explicit RunCoefficients(int n) : pivot(static_cast<std::size_t>(n)) {
        double upper = 0;
        for (int i = 0; i < n; ++i) {
            const double diagonal = 0.75 + (i == 0 ? 0.125 : 0) + (i == n - 1 ? 0.125 : 0);
            const double p = 1 / (diagonal - 0.125 * upper);
            pivot[static_cast<std::size_t>(i)] = static_cast<float>(p);
            upper = 0.125 * p;
        }
    }
};

// Rows [first, last] of all lines are one run.
void solveWhole(float* planes, int first, int last, const RunCoefficients& run) {
    for (int i = first; i <= last; ++i) {
        float* row = planes + i * kLines;
        const float pivot = run.pivot[static_cast<std::size_t>(i - first)];
        if (i == first) {
            for (int l = 0; l < kLines; ++l) row[l] *= pivot;
        } else {
            const float* before = row - kLines;
            for (int l = 0; l < kLines; ++l) row[l] = (row[l] - kSide * before[l]) * pivot;
        }
    }
    for (int i = last - 1; i >= first; --i) {
        float* row = planes + i * kLines;
        const float upper = kSide * run.pivot[static_cast<std::size_t>(i - first)];
        const float* after = row + kLines;
        for (int l = 0; l < kLines; ++l) row[l] -= upper * after[l];
    }
}

// Runs differ from line to line: `known` holds 1 where a voxel is needed, else 0; values there are 0 too.
void solveMasked(float* planes, const float* known, int count, std::vector<float>& upper) {
    upper.resize(static_cast<std::size_t>(count) * kLines);
    static constexpr std::array<float, kLines> kNone{};
    for (int i = 0; i < count; ++i) {
        float *row = planes + i * kLines, *up = upper.data() + i * kLines;
        const float *here = known + i * kLines, *low = i > 0 ? here - kLines : kNone.data();
        const float* high = i + 1 < count ? here + kLines : kNone.data();
        const float *before = i > 0 ? row - kLines : kNone.data(), *up_before = i > 0 ? up - kLines : kNone.data();
        for (int l = 0; l < kLines; ++l) {
            // At a run's first voxel up_before and before are 0, since the voxel below is not needed.
            const float diagonal = 1.0f - kSide * (low[l] + high[l]);
            const float pivot = 1 / (diagonal - kSide * up_before[l]);
            up[l] = here[l] * high[l] * kSide * pivot;
            row[l] = here[l] * (row[l] - kSide * before[l]) * pivot;
        }
    }
    for (int i = count - 2; i >= 0; --i) {
        float* row = planes + i * kLines;
        const float *up = upper.data() + i * kLines, *after = row + kLines;
        for (int l = 0; l < kLines; ++l) row[l] -= up[l] * after[l];
    }
}

// A row of leaves that touch along an axis.
struct LeafRow {
    int axis = 0;
    std::vector<int> slots;
};

// Voxels of a row, both inclusive, from its first leaf's border.
struct VoxelRun {
    int first = 0, last = 0;
};

struct Scratch {
    std::vector<float> planes, solved;  // by channel
    std::vector<float> known, upper, share;
};

// First and last needed voxel of a row, from its first leaf's border. False when the frame cuts the row sideways, or
// voxels of it are not needed.
bool oneRun(const NeededVoxels& needed, const LeafRow& row, VoxelRun& run) {
    const GridFrame& frame = needed.frame();
    const int axis = row.axis;
    const int begin = needed.leafOrigin(row.slots.front())[axis], count = static_cast<int>(row.slots.size()) * 8;
    run = {std::max(frame.min[axis] - begin, 0), std::min(frame.max[axis] - begin, count - 1)};
    for (const int slot : row.slots) {
        if (needed.leafFull(slot)) continue;
        if (!needed.isEverything()) return false;
        const glm::ivec3 origin = needed.leafOrigin(slot);
        for (int a = 0; a < 3; ++a)
            if (a != axis && (origin[a] < frame.min[a] || origin[a] + 7 > frame.max[a])) return false;
    }
    return true;
}

void loadRow(const LightField& field, const LeafRow& row, Scratch& scratch) {
    const auto channels = static_cast<std::size_t>(field.channels().count());
    const std::size_t leaves = row.slots.size(), length = leaves * kLeaf;
    scratch.planes.resize(channels * length), scratch.solved.resize(channels * length);
    for (std::size_t c = 0; c < channels; ++c)
        for (std::size_t n = 0; n < leaves; ++n) {
            float* planes = scratch.planes.data() + c * length + n * kLeaf;
            const int slot = row.slots[n];
            if (field.state(slot) == LeafState::Dense)
                loadPlanes(field.dense(slot) + c * kLeaf, row.axis, planes);
            else
                std::fill_n(planes, kLeaf, field.constant(slot)[c]);
        }
}

// Marks the voxels that are needed and hold light: 1, else 0. Returns whether that is every voxel of the run.
bool markLit(const LightField& field, const LeafRow& row, const VoxelRun& run, bool whole, Scratch& scratch) {
    const int first = run.first, last = run.last;
    const std::size_t leaves = row.slots.size(), length = leaves * kLeaf;
    scratch.known.resize(length);
    std::fill_n(scratch.known.begin(), length, 0.0f);
    if (whole) std::fill(scratch.known.begin() + first * kLines, scratch.known.begin() + (last + 1) * kLines, 1.0f);
    if (!whole) {
        std::array<float, kLeaf> bits;
        for (std::size_t n = 0; n < leaves; ++n) {
            const auto& mask = field.needed().mask(row.slots[n]);
            for (std::size_t i = 0; i < kLeaf; ++i)
                bits[i] = NeededVoxels::maskBit(mask, static_cast<int>(i)) ? 1.0f : 0.0f;
            loadPlanes(bits.data(), row.axis, scratch.known.data() + n * kLeaf);
        }
    }
    bool all = whole;
    const auto colours = static_cast<std::size_t>(field.channels().irradiance);
    for (auto i = static_cast<std::size_t>(first) * kLines; i < (static_cast<std::size_t>(last) + 1) * kLines; ++i) {
        float light = 0;
        for (std::size_t c = 0; c < colours; ++c) light += scratch.planes[c * length + i];
        const float lit = light > 0 ? scratch.known[i] : 0.0f;
        all = all && lit > 0;
        scratch.known[i] = lit;
    }
    return all;
}

// Light that voxel i hands to the next one, where both are lit.
inline float handed(const float* u, const float* known, int i, int line) {
    const float *here = u + i * kLines + line, *lit = known + i * kLines + line;
    return kSide * (here[kLines] - here[0]) * lit[0] * lit[kLines];
}

// Lowers the shares of what a channel's voxels hand on to what they can spare.
// @param share  by face: [i] lies between voxels i and i + 1
void limitShares(const float* mean, const float* u, const float* known, const VoxelRun& run, float* share) {
    for (int i = run.first; i <= run.last; ++i)
        for (int l = 0; l < kLines; ++l) {
            const int at = i * kLines + l;
            float least = mean[at], to_low = 0, to_high = 0;
            if (i > run.first) {
                to_low = std::max(0.0f, -handed(u, known, i - 1, l));
                if (known[at - kLines] > 0) least = std::min(least, mean[at - kLines]);
            }
            if (i < run.last) {
                to_high = std::max(0.0f, handed(u, known, i, l));
                if (known[at + kLines] > 0) least = std::min(least, mean[at + kLines]);
            }
            const float asked = to_low + to_high, spare = mean[at] - kKept * std::max(least, 0.0f);
            if (asked <= spare) continue;
            const float part = std::max(spare, 0.0f) / asked;
            if (to_low > 0) share[at - kLines] = std::min(share[at - kLines], part);
            if (to_high > 0) share[at] = std::min(share[at], part);
        }
}

void handOver(float* mean, const float* u, const float* known, const VoxelRun& run, const float* share) {
    for (int i = run.first; i < run.last; ++i)
        for (int l = 0; l < kLines; ++l) {
            const float moved = share[i * kLines + l] * handed(u, known, i, l);
            mean[i * kLines + l] -= moved, mean[(i + 1) * kLines + l] += moved;
        }
}

// Writes the planes back. Leaves that had one value keep it unless the filter changed it by something that counts.
void storeRow(LightField& field, const LeafRow& row, const Scratch& scratch) {
    const auto channels = static_cast<std::size_t>(field.channels().count());
    const std::size_t leaves = row.slots.size(), length = leaves * kLeaf;
    float largest = 0;
    for (std::size_t i = 0; i < channels * length; ++i) largest = std::max(largest, std::fabs(scratch.planes[i]));
    for (std::size_t n = 0; n < leaves; ++n) {
        const int slot = row.slots[n];
        if (field.state(slot) == LeafState::Constant) {
            float change = 0;
            for (std::size_t c = 0; c < channels; ++c) {
                const float old = field.constant(slot)[c], *planes = scratch.planes.data() + c * length + n * kLeaf;
                for (std::size_t i = 0; i < kLeaf; ++i) change = std::max(change, std::fabs(planes[i] - old));
            }
            if (change <= kNegligible * largest) continue;
            field.makeDense(slot);
        }
        for (std::size_t c = 0; c < channels; ++c)
            storePlanes(scratch.planes.data() + c * length + n * kLeaf, row.axis, field.dense(slot) + c * kLeaf);
    }
}

// Filters a row of leaves, none of them Empty.
void filterRow(LightField& field, const LeafRow& row, Scratch& scratch) {
    const auto channels = static_cast<std::size_t>(field.channels().count()),
               colours = static_cast<std::size_t>(field.channels().irradiance);
    const std::size_t length = row.slots.size() * kLeaf;
    VoxelRun run;
    const bool one_run = oneRun(field.needed(), row, run);
    if (run.last <= run.first) return;
    loadRow(field, row, scratch);
    const bool whole = markLit(field, row, run, one_run, scratch);
    const RunCoefficients coefficients(whole ? run.last - run.first + 1 : 0);
    const float* known = scratch.known.data();
    for (std::size_t c = 0; c < channels; ++c) {
        const float* mean = scratch.planes.data() + c * length;
        float* u = scratch.solved.data() + c * length;
        std::copy_n(mean, length, u);
        if (whole) {
            solveWhole(u, run.first, run.last, coefficients);
        } else {
            for (std::size_t i = 0; i < length; ++i) u[i] *= known[i];
            solveMasked(u, known, static_cast<int>(row.slots.size()) * 8, scratch.upper);
        }
    }
    scratch.share.resize(length);
    std::fill_n(scratch.share.begin(), length, 1.0f);
    for (std::size_t c = 0; c < colours; ++c)
        limitShares(scratch.planes.data() + c * length, scratch.solved.data() + c * length, known, run,
                    scratch.share.data());
    // The same shares for colours and flux, so that neither tint nor direction changes where light is held back.
    for (std::size_t c = 0; c < channels; ++c)
        handOver(scratch.planes.data() + c * length, scratch.solved.data() + c * length, known, run,
                 scratch.share.data());
    storeRow(field, row, scratch);
}

void filterAxis(LightField& field, int axis) {
    const NeededVoxels& needed = field.needed();
    glm::ivec3 step(0);
    step[axis] = 8;
    // Rows of leaves that touch. One without light ends a row, as one that is not needed does.
    const auto litAt = [&](const glm::ivec3& voxel) {
        const int slot = needed.slotOf(voxel);
        return slot >= 0 && field.state(slot) != LeafState::Empty ? slot : -1;
    };
    std::vector<int> starts;
    for (int slot = 0; slot < needed.leafCount(); ++slot)
        if (field.state(slot) != LeafState::Empty && litAt(needed.leafOrigin(slot) - step) < 0) starts.push_back(slot);
    parallelFor(static_cast<std::int64_t>(starts.size()), [&](std::int64_t i) {
        thread_local Scratch scratch;
        thread_local LeafRow row;
        row.axis = axis;
        row.slots.clear();
        for (int slot = starts[static_cast<std::size_t>(i)]; slot >= 0; slot = litAt(needed.leafOrigin(slot) + step))
            row.slots.push_back(slot);
        filterRow(field, row, scratch);
    });
}

}  // namespace

void prefilterForTrilinear(LightField& field) {
    for (int axis = 2; axis >= 0; --axis) filterAxis(field, axis);
    restoreFluxBound(field);
}

}  // namespace photic
