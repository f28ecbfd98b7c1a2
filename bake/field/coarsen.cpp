// SPDX-License-Identifier: Apache-2.0
#include "bake/field/coarsen.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "bake/field/floor_div.h"
#include "bake/field/needed_voxels.h"

namespace photic {
namespace {

constexpr int kVoxels = LightField::kLeafVoxels;
constexpr int kSteps = 12;
constexpr double kSmallEnough = 1e-4;  // of the residual, against the right-hand side: far below half floats' effect
constexpr int kPadded = 10;            // a leaf of coarse voxels and one around it

GridFrame coarseFrame(const GridFrame& fine, int factor, CoarseCentres centres) {
    GridFrame coarse;
    coarse.setWorldFromIndex(fine.worldFromIndex() * double(factor));
    coarse.origin_world =
        fine.worldFromIndex(glm::dvec3(centres == CoarseCentres::OfTheirCells ? 0.5 * (factor - 1) : 0.0));
    for (int a = 0; a < 3; ++a) {
        coarse.min[a] = floorDiv(fine.min[a], factor) - 1;
        coarse.max[a] = floorDiv(fine.max[a], factor) + 1;
    }
    return coarse;
}

// Coarse voxels around the leaves that are there.
NeededVoxels coarseNeeded(const LightField& field, int factor, CoarseCentres centres) {
    NeededVoxels needed = NeededVoxels::none(coarseFrame(field.frame(), factor, centres));
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
using Padded = std::array<float, kPadded * kPadded * kPadded>;

// The look-up A at the fine voxels' centres, and its transpose, leaf by coarse leaf. Weights are products of one for
// each axis, so that a look-up goes axis by axis: planes across x, rows along z, voxels.
class Fit {
public:
    Fit(const LightField& fine, std::shared_ptr<const NeededVoxels> coarse, int factor, CoarseCentres centres)
        : fine_(fine), coarse_(std::move(coarse)), factor_(factor) {
        // Fine voxels between two coarse ones of a padded leaf.
        for (int v = -factor; v < 9 * factor; ++v) {
            const double at = centres == CoarseCentres::OfTheirCells ? (v + 0.5) / factor - 0.5 : double(v) / factor;
            const double below = std::floor(at);
            if (below < -1 || below > 7) continue;
            if (places_.empty()) first_ = v;
            places_.push_back({static_cast<int>(below) + 1, static_cast<float>(at - below)});
        }
    }

    std::size_t size() const { return static_cast<std::size_t>(coarse_->leafCount()) * kVoxels; }

    /// to = A^T A from.
    void applyNormal(const Vector& from, Vector& to) const {
        forEachLeaf(*coarse_, [&](int slot) {
            Padded padded;
            load(from, slot, padded.data());
            // The coarse values at the plane's x, then at each row's y too.
            std::array<float, kPadded * kPadded> at_x;
            std::vector<float> at_y(places_.size() * kPadded);
            const auto enter = [&](const Place& x) {
                const float* below = padded.data() + x.below * kPadded * kPadded;
                mix(below, below + kPadded * kPadded, x.above_weight, kPadded * kPadded, at_x.data());
                for (std::size_t y = 0; y < places_.size(); ++y) {
                    const float* row = at_x.data() + places_[y].below * kPadded;
                    mix(row, row + kPadded, places_[y].above_weight, kPadded, at_y.data() + y * kPadded);
                }
            };
            sum(slot, to, Share::Weight, enter, [&](const FinePlace& v) {
                const Place& z = places_[v.z];
                const float* row = at_y.data() + v.y * kPadded + z.below;
                return row[0] + z.above_weight * (row[1] - row[0]);
            });
        });
    }
    /// to = A^T values.
    void applyTransposed(int channel, Vector& to) const {
        forEachLeaf(*coarse_, [&](int slot) {
            sum(
                slot, to, Share::Weight, [](const Place&) {},
                [&](const FinePlace& v) {
                    const LeafState state = fine_.state(v.slot);
                    return state == LeafState::Dense   ? fine_.dense(v.slot)[channel * kVoxels + v.offset]
                           : state == LeafState::Empty ? 0.0f
                                                       : fine_.constant(v.slot)[static_cast<std::size_t>(channel)];
                });
        });
    }
    /// The diagonal of A^T A, and A^T 1.
    void weights(Vector& diagonal, Vector& row_sums) const {
        const auto enter = [](const Place&) {};
        const auto one = [](const FinePlace&) { return 1.0f; };
        forEachLeaf(*coarse_, [&](int slot) {
            sum(slot, row_sums, Share::Weight, enter, one);
            sum(slot, diagonal, Share::WeightSquared, enter, one);
        });
    }

private:
    // A fine voxel that is there: its place along y and z, and where its values are.
    struct FinePlace {
        std::size_t y, z;
        int slot, offset;
    };

    std::size_t base(int slot) const { return static_cast<std::size_t>(slot) * kVoxels; }

    static void mix(const float* below, const float* above, float above_weight, int count, float* to) {
        for (int i = 0; i < count; ++i) to[i] = below[i] + above_weight * (above[i] - below[i]);
    }

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

    /// Sums value(fine voxel) times its share into a coarse leaf; enter(x) precedes the voxels of a plane.
    template <class Enter, class Value>
    void sum(int slot, Vector& to, Share share, Enter enter, Value value) const {
        const auto below_share = [share](float w) { return share == Share::Weight ? 1 - w : (1 - w) * (1 - w); };
        const auto above_share = [share](float w) { return share == Share::Weight ? w : w * w; };
        const glm::ivec3 first = coarse_->leafOrigin(slot) * factor_ + first_;
        const int count = static_cast<int>(places_.size());
        const FineLeaves leaves(fine_, first, count);
        Padded sums{};
        std::vector<float> rows(places_.size() * kPadded);
        for (int x = 0; x < count; ++x) {
            if (!leaves.any(first.x + x)) continue;
            const Place& place = places_[static_cast<std::size_t>(x)];
            enter(place);
            std::fill(rows.begin(), rows.end(), 0.0f);
            leaves.forEachOfPlane(first, count, first.x + x, [&](const FinePlace& v) {
                const Place& z = places_[v.z];
                const float t = value(v);
                float* row = rows.data() + v.y * kPadded + z.below;
                row[0] += t * below_share(z.above_weight);
                row[1] += t * above_share(z.above_weight);
            });
            std::array<float, kPadded * kPadded> plane{};
            for (std::size_t y = 0; y < places_.size(); ++y) {
                const float* row = rows.data() + y * kPadded;
                float* below = plane.data() + places_[y].below * kPadded;
                const float w = places_[y].above_weight;
                addScaled(row, below_share(w), kPadded, below);
                addScaled(row, above_share(w), kPadded, below + kPadded);
            }
            float* below = sums.data() + place.below * kPadded * kPadded;
            addScaled(plane.data(), below_share(place.above_weight), kPadded * kPadded, below);
            addScaled(plane.data(), above_share(place.above_weight), kPadded * kPadded, below + kPadded * kPadded);
        }
        for (int i = 0; i < kVoxels; ++i)
            to[base(slot) + static_cast<std::size_t>(i)] =
                sums[static_cast<std::size_t>((((i >> 6) + 1) * kPadded + (i >> 3 & 7) + 1) * kPadded + (i & 7) + 1)];
    }

    static void addScaled(const float* from, float scale, int count, float* to) {
        for (int i = 0; i < count; ++i) to[i] += scale * from[i];
    }

    // The fine leaves in a cube of `count` voxels from `first` on.
    class FineLeaves {
    public:
        FineLeaves(const LightField& fine, const glm::ivec3& first, int count)
            : fine_(fine), low_(first.x >> 3, first.y >> 3, first.z >> 3) {
            for (int a = 0; a < 3; ++a) sides_[a] = ((first[a] + count - 1) >> 3) - low_[a] + 1;
            for (int x = 0; x < sides_.x; ++x)
                for (int y = 0; y < sides_.y; ++y)
                    for (int z = 0; z < sides_.z; ++z)
                        slots_.push_back(fine.needed().slotOf((low_ + glm::ivec3(x, y, z)) * 8));
        }
        /// Some leaf may have voxels in the plane.
        bool any(int x) const {
            const auto begin = slots_.begin() + ((x >> 3) - low_.x) * sides_.y * sides_.z;
            return std::any_of(begin, begin + sides_.y * sides_.z, [](int slot) { return slot >= 0; });
        }
        template <class Body>
        void forEachOfPlane(const glm::ivec3& first, int count, int x, Body body) const {
            const auto word_of_plane = static_cast<std::size_t>(x & 7);
            auto slot = slots_.begin() + ((x >> 3) - low_.x) * sides_.y * sides_.z;
            for (int ly = 0; ly < sides_.y; ++ly)
                for (int lz = 0; lz < sides_.z; ++lz, ++slot) {
                    if (*slot < 0) continue;
                    // A leaf's voxels across x are one word of its mask.
                    for (std::uint64_t rest = fine_.needed().mask(*slot)[word_of_plane]; rest != 0; rest &= rest - 1) {
                        const int bit = std::countr_zero(rest);
                        const int y = (low_.y + ly) * 8 + (bit >> 3) - first.y,
                                  z = (low_.z + lz) * 8 + (bit & 7) - first.z;
                        if (y < 0 || z < 0 || y >= count || z >= count) continue;
                        body(FinePlace{static_cast<std::size_t>(y), static_cast<std::size_t>(z), *slot,
                                       static_cast<int>(word_of_plane) * 64 + bit});
                    }
                }
        }

    private:
        const LightField& fine_;
        glm::ivec3 low_, sides_{1};
        std::vector<int> slots_;
    };

    const LightField& fine_;
    std::shared_ptr<const NeededVoxels> coarse_;
    int factor_, first_ = 0;
    std::vector<Place> places_;
};

double dot(const Vector& a, const Vector& b) {
    // In a fixed order, the same for any number of threads; four sums, so that none waits for the one before.
    std::array<double, 4> sums{};
    for (std::size_t i = 0; i < a.size(); ++i) sums[i & 3] += double(a[i]) * double(b[i]);
    return sums[0] + sums[1] + sums[2] + sums[3];
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

LightField coarsened(const LightField& field, int factor, const Monitor& monitor, CoarseCentres centres) {
    const auto needed = std::make_shared<const NeededVoxels>(coarseNeeded(field, factor, centres));
    const Fit fit(field, needed, factor, centres);
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
