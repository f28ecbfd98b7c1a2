// SPDX-License-Identifier: Apache-2.0
#include "bake/field/coarsen.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "bake/field/floor_div.h"
#include "bake/field/needed_voxels.h"

namespace photic {
namespace {

constexpr int kVoxels = LightField::kLeafVoxels;
constexpr int kSteps = 12;
constexpr double kSmallEnough = 1e-4;  // of the residual, against the right-hand side: far below half floats' effect
constexpr int kPadded = 10;            // a leaf of coarse voxels and one around it

GridFrame coarseFrame(const GridFrame& fine, int factor) {
    GridFrame coarse;
    coarse.setWorldFromIndex(fine.worldFromIndex() * double(factor));
    coarse.origin_world = fine.worldFromIndex(glm::dvec3(0.5 * (factor - 1)));
    for (int a = 0; a < 3; ++a) {
        coarse.min[a] = floorDiv(fine.min[a], factor) - 1;
        coarse.max[a] = floorDiv(fine.max[a], factor) + 1;
    }
    return coarse;
}

// Coarse voxels around the leaves that are there.
NeededVoxels coarseNeeded(const LightField& field, int factor) {
    NeededVoxels needed = NeededVoxels::none(coarseFrame(field.frame(), factor));
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        const glm::ivec3 origin = field.needed().leafOrigin(slot);
        glm::ivec3 low, high;
        for (int a = 0; a < 3; ++a)
            low[a] = floorDiv(origin[a], factor) - 1, high[a] = floorDiv(origin[a] + 7, factor) + 1;
        for (int x = low.x; x <= high.x; ++x)
            for (int y = low.y; y <= high.y; ++y) needed.addColumn(x, y, low.z, high.z);
    }
    needed.finish();
    return needed;
}

// A fine voxel along one axis: the coarse voxel below it, counted in the padded leaf, and the weight of the one above.
struct Place {
    int below;
    float above_weight;
};

// What a fine voxel gives each of its eight coarse ones.
enum class Share { Weight, WeightSquared };

// Values of one channel on all coarse voxels, slot after slot.
using Vector = std::vector<float>;

class Fit {
public:
    Fit(const LightField& fine, std::shared_ptr<const NeededVoxels> coarse, int factor)
        : fine_(fine), coarse_(std::move(coarse)), factor_(factor) {
        // Fine voxels with a share in coarse 0..7 of a leaf: from within coarse -1 to within coarse 8.
        for (int v = -factor; v < 9 * factor; ++v) {
            const double at = (v + 0.5) / factor - 0.5, below = std::floor(at);
            places_.push_back({static_cast<int>(below) + 1, static_cast<float>(at - below)});
        }
    }

    std::size_t size() const { return static_cast<std::size_t>(coarse_->leafCount()) * kVoxels; }

    /// to = A^T A from, A being the look-up at the fine voxels' centres.
    void applyNormal(const Vector& from, Vector& to) const {
        forEachLeaf(*coarse_, [&](int slot) {
            std::array<float, kPadded * kPadded * kPadded> padded;
            load(from, slot, padded.data());
            gather(slot, to, [&](const glm::ivec3&, const std::array<int, 8>& at, const std::array<float, 8>& weight) {
                float sum = 0;
                for (std::size_t c = 0; c < 8; ++c) sum += weight[c] * padded[static_cast<std::size_t>(at[c])];
                return sum;
            });
        });
    }
    /// to = A^T values.
    void applyTransposed(int channel, Vector& to) const {
        forEachLeaf(*coarse_, [&](int slot) {
            gather(slot, to, [&](const glm::ivec3& v, const std::array<int, 8>&, const std::array<float, 8>&) {
                return fine_.value(v, channel);
            });
        });
    }
    /// The diagonal of A^T A, and A^T A 1.
    void weights(Vector& diagonal, Vector& row_sums) const {
        forEachLeaf(*coarse_, [&](int slot) {
            gather(slot, row_sums,
                   [](const glm::ivec3&, const std::array<int, 8>&, const std::array<float, 8>&) { return 1.0f; });
            gather(
                slot, diagonal,
                [](const glm::ivec3&, const std::array<int, 8>&, const std::array<float, 8>&) { return 1.0f; },
                Share::WeightSquared);
        });
    }

private:
    std::size_t base(int slot) const { return static_cast<std::size_t>(slot) * kVoxels; }

    void load(const Vector& from, int slot, float* padded) const {
        const glm::ivec3 origin = coarse_->leafOrigin(slot) - 1;
        for (int x = 0; x < kPadded; ++x)
            for (int y = 0; y < kPadded; ++y)
                for (int z = 0; z < kPadded; ++z) {
                    const glm::ivec3 v = origin + glm::ivec3(x, y, z);
                    const int at = coarse_->slotOf(v);
                    *padded++ =
                        at < 0 ? 0.0f : from[base(at) + static_cast<std::size_t>(NeededVoxels::offsetInLeaf(v))];
                }
    }

    /// Sums value(fine voxel, its eight coarse ones in the padded leaf, their weights) times share into a leaf.
    template <class Value>
    void gather(int slot, Vector& to, Value value, Share share = Share::Weight) const {
        std::array<float, kPadded * kPadded * kPadded> sums{};
        const glm::ivec3 first = coarse_->leafOrigin(slot) * factor_ - factor_;
        const int count = static_cast<int>(places_.size());
        // Fine leaf by fine leaf, so that each mask is looked up once.
        for (int lx = first.x & ~7; lx < first.x + count; lx += 8)
            for (int ly = first.y & ~7; ly < first.y + count; ly += 8)
                for (int lz = first.z & ~7; lz < first.z + count; lz += 8) {
                    const int fine_slot = fine_.needed().slotOf({lx, ly, lz});
                    if (fine_slot < 0) continue;
                    const auto& mask = fine_.needed().mask(fine_slot);
                    for (int i = 0; i < kVoxels; ++i) {
                        if (!NeededVoxels::maskBit(mask, i)) continue;
                        const glm::ivec3 v(lx + (i >> 6), ly + (i >> 3 & 7), lz + (i & 7)), local = v - first;
                        if (std::min({local.x, local.y, local.z}) < 0 || std::max({local.x, local.y, local.z}) >= count)
                            continue;
                        const Place &x = places_[static_cast<std::size_t>(local.x)],
                                    &y = places_[static_cast<std::size_t>(local.y)],
                                    &z = places_[static_cast<std::size_t>(local.z)];
                        // Places that no voxel of the padded leaf stands below or above.
                        if (std::min({x.below, y.below, z.below}) < 0 ||
                            std::max({x.below, y.below, z.below}) > kPadded - 2)
                            continue;
                        std::array<int, 8> at;
                        std::array<float, 8> weight;
                        for (int c = 0; c < 8; ++c) {
                            const auto n = static_cast<std::size_t>(c);
                            at[n] =
                                ((x.below + (c >> 2)) * kPadded + y.below + (c >> 1 & 1)) * kPadded + z.below + (c & 1);
                            weight[n] = (c >> 2 ? x.above_weight : 1 - x.above_weight) *
                                        (c >> 1 & 1 ? y.above_weight : 1 - y.above_weight) *
                                        (c & 1 ? z.above_weight : 1 - z.above_weight);
                        }
                        const float t = value(v, at, weight);
                        for (std::size_t c = 0; c < 8; ++c)
                            sums[static_cast<std::size_t>(at[c])] +=
                                t * (share == Share::Weight ? weight[c] : weight[c] * weight[c]);
                    }
                }
        for (int i = 0; i < kVoxels; ++i)
            to[base(slot) + static_cast<std::size_t>(i)] =
                sums[static_cast<std::size_t>((((i >> 6) + 1) * kPadded + (i >> 3 & 7) + 1) * kPadded + (i & 7) + 1)];
    }

    const LightField& fine_;
    std::shared_ptr<const NeededVoxels> coarse_;
    int factor_;
    std::vector<Place> places_;
};

double dot(const Vector& a, const Vector& b) {
    double sum = 0;  // in order: the same for any number of threads
    for (std::size_t i = 0; i < a.size(); ++i) sum += double(a[i]) * double(b[i]);
    return sum;
}

// Conjugate gradients; x holds the result. `inverse` is the preconditioner, 0 where no fine voxel has a share.
void solve(const Fit& fit, const Vector& right, const Vector& inverse, const Vector& row_sums, Vector& x,
           const Monitor& monitor) {
    const std::size_t n = fit.size();
    Vector r(n), p(n), q(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = row_sums[i] > 0 ? right[i] / row_sums[i] : 0;
    fit.applyNormal(x, q);
    double rho = 0;
    for (std::size_t i = 0; i < n; ++i) {
        r[i] = right[i] - q[i];
        p[i] = inverse[i] * r[i];
        rho += double(r[i]) * double(p[i]);
    }
    double enough = 0;
    for (std::size_t i = 0; i < n; ++i) enough += double(right[i]) * double(right[i]) * double(inverse[i]);
    enough *= kSmallEnough * kSmallEnough;
    for (int step = 0; step < kSteps && rho > enough; ++step) {
        monitor.checkCancelled();
        fit.applyNormal(p, q);
        const double curvature = dot(p, q);
        if (!(curvature > 0)) return;
        const auto alpha = static_cast<float>(rho / curvature);
        double next = 0;
        for (std::size_t i = 0; i < n; ++i) {
            x[i] += alpha * p[i];
            r[i] -= alpha * q[i];
            next += double(r[i]) * double(r[i]) * double(inverse[i]);
        }
        const auto beta = static_cast<float>(next / rho);
        rho = next;
        for (std::size_t i = 0; i < n; ++i) p[i] = inverse[i] * r[i] + beta * p[i];
    }
}

// What look-ups must not break, restored voxel by voxel.
void makeLawful(float* leaf, FieldChannels channels) {
    for (int i = 0; i < kVoxels; ++i) {
        float mean = 0;
        for (int c = 0; c < channels.irradiance; ++c) {
            float& e = leaf[c * kVoxels + i];
            e = std::max(e, 0.0f);
            mean += e / static_cast<float>(channels.irradiance);
        }
        if (!channels.flux) continue;
        float* flux = leaf + channels.irradiance * kVoxels + i;
        const float length =
            std::sqrt(flux[0] * flux[0] + flux[kVoxels] * flux[kVoxels] + flux[2 * kVoxels] * flux[2 * kVoxels]);
        if (length <= mean) continue;
        for (int a = 0; a < 3; ++a) flux[a * kVoxels] *= mean / length;
    }
}

}  // namespace

LightField coarsened(const LightField& field, int factor, const Monitor& monitor) {
    const auto needed = std::make_shared<const NeededVoxels>(coarseNeeded(field, factor));
    const Fit fit(field, needed, factor);
    Vector inverse(fit.size()), row_sums(fit.size()), right(fit.size()), x(fit.size());
    fit.weights(inverse, row_sums);
    for (float& v : inverse) v = v > 0 ? 1 / v : 0;

    LightField out(needed, field.channels());
    for (int channel = 0; channel < field.channels().count(); ++channel) {
        fit.applyTransposed(channel, right);
        solve(fit, right, inverse, row_sums, x, monitor);
        forEachLeaf(*needed, [&](int slot) {
            std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(slot) * kVoxels, kVoxels,
                        out.makeDense(slot) + channel * kVoxels);
        });
    }
    forEachLeaf(*needed, [&](int slot) { makeLawful(out.makeDense(slot), out.channels()); });
    return out;
}

}  // namespace photic
