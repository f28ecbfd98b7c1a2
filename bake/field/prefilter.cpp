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

namespace photic {
namespace {

constexpr std::size_t kLeaf = LightField::kLeafVoxels;
constexpr int kLines = 64;  // lines of voxels side by side in a row of leaves
constexpr float kSide = 0.125f;
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
    std::vector<int> slots;
};

struct Scratch {
    std::vector<float> planes, known, upper;
};

// Position of the first and last needed voxel of a row when every line agrees on one run; false otherwise.
bool oneRun(const NeededVoxels& needed, const LeafRow& row, int axis, int& first, int& last) {
    const GridFrame& frame = needed.frame();
    const int begin = needed.leafOrigin(row.slots.front())[axis];
    for (const int slot : row.slots) {
        if (needed.leafFull(slot)) continue;
        // Cut by the frame across the axis only at its ends, and not at all sideways.
        if (!needed.isEverything()) return false;
        const glm::ivec3 origin = needed.leafOrigin(slot);
        for (int a = 0; a < 3; ++a)
            if (a != axis && (origin[a] < frame.min[a] || origin[a] + 7 > frame.max[a])) return false;
    }
    first = std::max(frame.min[axis] - begin, 0);
    last = std::min(frame.max[axis] - begin, static_cast<int>(row.slots.size()) * 8 - 1);
    return true;
}

// Filters a row of leaves, channel after channel. The planes of a channel stay in `scratch` when some leaf is not
// Dense, since all channels together decide whether it becomes so.
void filterRow(LightField& field, const LeafRow& row, int axis, Scratch& scratch) {
    const NeededVoxels& needed = field.needed();
    const auto hasState = [&](LeafState state) {
        return [&field, state](int slot) { return field.state(slot) == state; };
    };
    if (std::all_of(row.slots.begin(), row.slots.end(), hasState(LeafState::Empty))) return;
    const bool dense = std::all_of(row.slots.begin(), row.slots.end(), hasState(LeafState::Dense));
    const auto leaves = row.slots.size();
    const auto channels = static_cast<std::size_t>(field.channels().count());
    const std::size_t length = leaves * kLeaf;
    scratch.planes.resize((dense ? 1 : channels) * length);

    int first = 0, last = 0;
    const bool whole = oneRun(needed, row, axis, first, last);
    if (!whole) {
        scratch.known.resize(length);
        std::array<float, kLeaf> bits;
        for (std::size_t n = 0; n < leaves; ++n) {
            const auto& mask = needed.mask(row.slots[n]);
            for (std::size_t i = 0; i < kLeaf; ++i)
                bits[i] = NeededVoxels::maskBit(mask, static_cast<int>(i)) ? 1.0f : 0.0f;
            loadPlanes(bits.data(), axis, scratch.known.data() + n * kLeaf);
        }
    }
    const RunCoefficients run(whole ? last - first + 1 : 0);

    for (std::size_t c = 0; c < channels; ++c) {
        float* planes = scratch.planes.data() + (dense ? 0 : c * length);
        for (std::size_t n = 0; n < leaves; ++n) {
            const int slot = row.slots[n];
            if (field.state(slot) == LeafState::Dense)
                loadPlanes(field.dense(slot) + c * kLeaf, axis, planes + n * kLeaf);
            else
                std::fill_n(planes + n * kLeaf, kLeaf,
                            field.state(slot) == LeafState::Constant ? field.constant(slot)[c] : 0.0f);
        }
        if (whole) {
            solveWhole(planes, first, last, run);
        } else {
            for (std::size_t i = 0; i < length; ++i) planes[i] *= scratch.known[i];
            solveMasked(planes, scratch.known.data(), static_cast<int>(leaves) * 8, scratch.upper);
        }
        if (dense)
            for (std::size_t n = 0; n < leaves; ++n)
                storePlanes(planes + n * kLeaf, axis, field.dense(row.slots[n]) + c * kLeaf);
    }
    if (dense) return;

    // Leaves that had one value keep it unless the filter changed it by something that counts.
    float largest = 0;
    for (const float v : scratch.planes) largest = std::max(largest, std::fabs(v));
    for (std::size_t n = 0; n < leaves; ++n) {
        const int slot = row.slots[n];
        if (field.state(slot) != LeafState::Dense) {
            float change = 0;
            for (std::size_t c = 0; c < channels; ++c) {
                const float old = field.state(slot) == LeafState::Constant ? field.constant(slot)[c] : 0.0f;
                const float* planes = scratch.planes.data() + c * length + n * kLeaf;
                const float* known = whole ? nullptr : scratch.known.data() + n * kLeaf;
                for (std::size_t i = 0; i < kLeaf; ++i)
                    if (known == nullptr || known[i] > 0) change = std::max(change, std::fabs(planes[i] - old));
            }
            if (change <= kNegligible * largest) continue;
            field.makeDense(slot);
        }
        for (std::size_t c = 0; c < channels; ++c)
            storePlanes(scratch.planes.data() + c * length + n * kLeaf, axis, field.dense(slot) + c * kLeaf);
    }
}

void filterAxis(LightField& field, int axis) {
    const NeededVoxels& needed = field.needed();
    glm::ivec3 step(0);
    step[axis] = 8;
    std::vector<int> starts;
    for (int slot = 0; slot < needed.leafCount(); ++slot)
        if (needed.slotOf(needed.leafOrigin(slot) - step) < 0) starts.push_back(slot);
    parallelFor(static_cast<std::int64_t>(starts.size()), [&](std::int64_t i) {
        thread_local Scratch scratch;
        thread_local LeafRow row;
        row.slots.clear();
        for (int slot = starts[static_cast<std::size_t>(i)]; slot >= 0;
             slot = needed.slotOf(needed.leafOrigin(slot) + step))
            row.slots.push_back(slot);
        filterRow(field, row, axis, scratch);
    });
}

void clampIrradiance(LightField& field) {
    const auto values = static_cast<std::size_t>(field.channels().irradiance);
    forEachLeaf(field.needed(), [&](int slot) {
        if (field.state(slot) != LeafState::Dense) return;  // Constant leaves were not changed
        float* data = field.dense(slot);
        for (std::size_t i = 0; i < values * kLeaf; ++i) data[i] = std::max(data[i], 0.0f);
    });
}

}  // namespace

void prefilterForTrilinear(LightField& field) {
    for (int axis = 2; axis >= 0; --axis) filterAxis(field, axis);
    clampIrradiance(field);
    restoreFluxBound(field);
}

}  // namespace photic
