// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/track_deposit.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "bake/field/leaf_arena.h"
#include "bake/optics/beer_lambert.h"

namespace photic {
namespace {

constexpr std::size_t kLeafVoxels = LightField::kLeafVoxels;

template <class Real>
std::size_t leafBytes(FieldChannels channels) {
    return kLeafVoxels * (static_cast<std::size_t>(channels.count()) * sizeof(Real) + sizeof(std::uint32_t));
}

/// sum += factor * weight; four values at once where there are four.
template <int Count, class Real>
void addScaled(Real factor, const Real* weight, Real* sum) {
    if constexpr (Count == 4) {
        typedef Real Four __attribute__((vector_size(4 * sizeof(Real))));
        Four w, s;
        std::memcpy(&w, weight, sizeof(Four));
        std::memcpy(&s, sum, sizeof(Four));
        s += factor * w;
        std::memcpy(sum, &s, sizeof(Four));
    } else {
        for (int c = 0; c < Count; ++c) sum[c] += factor * weight[c];
    }
}

/// Where a track is in the grid: its voxel, as a leaf and the offset in it, and where it leaves it across each axis.
struct VoxelSteps {
    /// @param begin  where the track enters the box from `low` to `high`; rounding may put that a hair outside
    VoxelSteps(const glm::dvec3& origin, const glm::dvec3& direction, double begin, const glm::dvec3& low,
               const glm::dvec3& high) {
        glm::ivec3 voxel;
        double next[3], delta[3];
        bool up[3];
        for (int a = 0; a < 3; ++a) {
            const double d = direction[a], at = origin[a] + begin * d;
            voxel[a] = static_cast<int>(std::clamp(std::floor(at), low[a], high[a] - 1));
            up[a] = d > 0;
            delta[a] = d == 0 ? std::numeric_limits<double>::infinity() : 1.0 / std::fabs(d);
            next[a] = d == 0 ? std::numeric_limits<double>::infinity() : (voxel[a] + (d > 0 ? 1 : 0) - origin[a]) / d;
        }
        next_x = next[0], next_y = next[1], next_z = next[2];
        delta_x = delta[0], delta_y = delta[1], delta_z = delta[2];
        step_x = up[0] ? 64 : -64, step_y = up[1] ? 8 : -8, step_z = up[2] ? 1 : -1;
        last_x = up[0] ? 7 << 6 : 0, last_y = up[1] ? 7 << 3 : 0, last_z = up[2] ? 7 : 0;
        leaf_origin = voxel & ~7;
        offset = NeededVoxels::offsetInLeaf(voxel);
    }

    /// Where the track leaves its voxel.
    double leaves() const { return std::min(next_z, std::min(next_x, next_y)); }

    /// Goes on to the next voxel, across the face that is met at leaves().
    /// @return whether it is of the same leaf
    bool advance(double to) {
        if (to == next_z) {
            next_z += delta_z;
            if ((offset & 7) == last_z) {
                offset ^= 7, leaf_origin.z += 8 * step_z;
                return false;
            }
            offset += step_z;
        } else if (to == next_x) {
            next_x += delta_x;
            if ((offset & 7 << 6) == last_x) {
                offset ^= 7 << 6, leaf_origin.x += step_x / 8;
                return false;
            }
            offset += step_x;
        } else {
            next_y += delta_y;
            if ((offset & 7 << 3) == last_y) {
                offset ^= 7 << 3, leaf_origin.y += step_y;
                return false;
            }
            offset += step_y;
        }
        return true;
    }

    glm::ivec3 leaf_origin;
    int offset;

private:
    double next_x, next_y, next_z, delta_x, delta_y, delta_z;
    int step_x, step_y, step_z;  ///< of the offset
    int last_x, last_y, last_z;  ///< the offset's bits of an axis before the leaf ends
};

/// What a track adds to the voxels that it passes.
template <class Real, int Channels, bool Flux, bool Medium>
struct TrackLight {
    static constexpr int kStride = Channels + (Flux ? 3 : 0);

    TrackLight(const Track& of, double begin) : track(of) {
        for (int c = 0; c < Channels; ++c) {
            mean_power += track.power[c] / Channels;
            transmittance[c] = Medium ? std::exp(-track.extinction[c] * begin) : 1.0;
            weight[c] = static_cast<Real>(track.power[c]);
        }
        if constexpr (Flux)
            for (int a = 0; a < 3; ++a)
                weight[Channels + a] = static_cast<Real>((Channels == 1 ? mean_power : 1.0) * track.direction[a]);
    }

    /// Goes on by `length`; `factor` is the integral of what is left of the power along it.
    void pass(double length, double (&factor)[Channels]) {
        for (int c = 0; c < Channels; ++c) {
            factor[c] = length;
            if constexpr (Medium) {
                const double depth = track.extinction[c] * length, mean = meanTransmittance(depth);
                factor[c] *= transmittance[c] * mean;
                // Past some 30 optical depths the difference is rounding, which may be negative.
                transmittance[c] *= depth < 30 ? 1.0 - depth * mean : std::exp(-depth);
            }
        }
    }

    /// @return power times length, of one channel over its power
    double add(const double (&factor)[Channels], Real* sum) const {
        if constexpr (Channels == 1) {
            addScaled<kStride>(static_cast<Real>(factor[0]), weight, sum);
            return factor[0];
        } else {
            double mean = 0;
            for (int c = 0; c < Channels; ++c) {
                sum[c] += static_cast<Real>(factor[c]) * weight[c];
                mean += factor[c] * track.power[c];
            }
            mean /= Channels;
            if constexpr (Flux)
                for (int a = Channels; a < kStride; ++a) sum[a] += static_cast<Real>(mean) * weight[a];
            return mean;
        }
    }

    const Track& track;
    Real weight[kStride];  ///< what a unit of power along a unit of length adds, channel after channel
    double transmittance[Channels], mean_power = 0;
};

}  // namespace

/// A track in index space; the parameter stays in metres.
template <class Real>
struct TrackAccumulator<Real>::Ray {
    glm::dvec3 origin, direction;
};

template <class Real>
TrackAccumulator<Real>::TrackAccumulator(const NeededVoxels& needed, FieldChannels channels)
    : needed_(&needed),
      channels_(channels),
      index_from_world_(needed.frame().indexFromWorld()),
      origin_world_(needed.frame().origin_world),
      box_low_(needed.frame().min),
      box_high_(needed.frame().max + 1),
      needed_low_(box_high_),
      needed_high_(box_low_),
      leaf_bytes_(leafBytes<Real>(channels)),
      arena_(std::make_unique<LeafArena>(leaf_bytes_, std::max(1, needed.leafCount()))),
      leaves_(static_cast<std::size_t>(needed.leafCount()), nullptr),
      full_(static_cast<std::size_t>(needed.leafCount())) {
    for (int slot = 0; slot < needed.leafCount(); ++slot) full_[static_cast<std::size_t>(slot)] = needed.leafFull(slot);
    // A part's walks begin and end where the whole's do, so that their steps round alike.
    const NeededVoxels& whole = needed.whole();
    if (whole.isEverything()) {
        needed_low_ = box_low_, needed_high_ = box_high_;
        return;
    }
    for (int slot = 0; slot < whole.leafCount(); ++slot) {
        const glm::dvec3 leaf(whole.leafOrigin(slot));
        needed_low_ = glm::min(needed_low_, leaf), needed_high_ = glm::max(needed_high_, leaf + 8.0);
    }
    needed_low_ = glm::max(needed_low_, box_low_), needed_high_ = glm::min(needed_high_, box_high_);
}

template <class Real>
TrackAccumulator<Real>::~TrackAccumulator() = default;
template <class Real>
TrackAccumulator<Real>::TrackAccumulator(TrackAccumulator&&) noexcept = default;

template <class Real>
const std::uint32_t* TrackAccumulator<Real>::counts(int slot) const {
    const Real* leaf = leaves_[static_cast<std::size_t>(slot)];
    return leaf ? reinterpret_cast<const std::uint32_t*>(leaf +
                                                         kLeafVoxels * static_cast<std::size_t>(channels_.count()))
                : nullptr;
}

template <class Real>
void TrackAccumulator<Real>::clear(int slot) {
    if (Real* leaf = leaves_[static_cast<std::size_t>(slot)]) std::memset(leaf, 0, leaf_bytes_);
}

template <class Real>
Real* TrackAccumulator<Real>::leafAt(int slot) {
    Real*& leaf = leaves_[static_cast<std::size_t>(slot)];
    if (!leaf) {
        bool zeroed = false;
        leaf = static_cast<Real*>(arena_->allocate(zeroed));
        if (!zeroed) std::memset(leaf, 0, leaf_bytes_);
    }
    return leaf;
}

template <class Real>
bool TrackAccumulator<Real>::clipTo(const Ray& ray, const glm::dvec3& low, const glm::dvec3& high, double& begin,
                                    double& end) const {
    for (int a = 0; a < 3; ++a) {
        if (ray.direction[a] == 0) {
            if (ray.origin[a] < low[a] || ray.origin[a] >= high[a]) return false;
            continue;
        }
        const double inverse = 1.0 / ray.direction[a];
        const double t0 = (low[a] - ray.origin[a]) * inverse, t1 = (high[a] - ray.origin[a]) * inverse;
        begin = std::max(begin, std::min(t0, t1));
        end = std::min(end, std::max(t0, t1));
    }
    return begin < end;
}

template <class Real>
DepositedTrack TrackAccumulator<Real>::deposit(const Track& track) {
    const Ray ray{index_from_world_ * (track.origin - origin_world_) + 0.5, index_from_world_ * track.direction};
    double begin = track.begin, end = track.end;
    if (!clipTo(ray, needed_low_, needed_high_, begin, end) || !std::isfinite(end)) return {};

    const bool medium = track.extinction != glm::dvec3(0);
    DepositedTrack out;
    if (channels_.irradiance == 1)
        out = channels_.flux
                  ? medium ? walk<1, true, true>(track, ray, begin, end) : walk<1, true, false>(track, ray, begin, end)
              : medium ? walk<1, false, true>(track, ray, begin, end)
                       : walk<1, false, false>(track, ray, begin, end);
    else
        out = channels_.flux
                  ? medium ? walk<3, true, true>(track, ray, begin, end) : walk<3, true, false>(track, ray, begin, end)
              : medium ? walk<3, false, true>(track, ray, begin, end)
                       : walk<3, false, false>(track, ray, begin, end);
    // With every voxel needed the ledger does not trust the walk.
    if (needed_->isEverything()) {
        out.path = 0;
        for (int c = 0; c < channels_.irradiance; ++c)
            out.path += track.power[c] * meanTransmittance(track.extinction[c], begin, end - begin) * (end - begin) /
                        channels_.irradiance;
    }
    return out;
}

template <class Real>
template <int Channels, bool Flux, bool Medium>
DepositedTrack TrackAccumulator<Real>::walk(const Track& track, const Ray& ray, double begin, double end) {
    using Light = TrackLight<Real, Channels, Flux, Medium>;
    constexpr int kStride = Light::kStride;
    VoxelSteps at(ray.origin, ray.direction, begin, needed_low_, needed_high_);
    Light light(track, begin);
    DepositedTrack out;
    double t = begin, path = 0;
    std::uint32_t counted = track.continues ? 0 : 1;
    while (true) {
        // A leaf: find it once, then walk its voxels.
        const int slot = needed_->slotOf(at.leaf_origin);
        const bool full = slot >= 0 && full_[static_cast<std::size_t>(slot)];
        const NeededVoxels::Mask mask = slot >= 0 && !full ? needed_->mask(slot) : NeededVoxels::Mask{};
        Real* leaf = full ? leafAt(slot) : slot >= 0 ? leaves_[static_cast<std::size_t>(slot)] : nullptr;
        auto* counts = reinterpret_cast<std::uint32_t*>(leaf + (leaf ? kLeafVoxels * kStride : 0));
        bool same_leaf = true;
        while (same_leaf) {
            const double to = at.leaves(), length = std::min(to, end) - t;
            if (length > 0) {
                t += length;
                double factor[Channels];
                light.pass(length, factor);
                if (full || (slot >= 0 && NeededVoxels::maskBit(mask, at.offset))) {
                    if (!leaf)
                        leaf = leafAt(slot), counts = reinterpret_cast<std::uint32_t*>(leaf + kLeafVoxels * kStride);
                    out.touched = true;
                    counts[at.offset] += counted;
                    path += light.add(factor, leaf + at.offset * kStride);
                } else if (needed_->isPart() && !out.touched) {
                    out.touched = needed_->whole().contains(
                        at.leaf_origin + glm::ivec3(at.offset >> 6, at.offset >> 3 & 7, at.offset & 7));
                }
            }
            counted = 1;
            if (to >= end) {
                out.path = Channels == 1 ? path * light.mean_power : path;
                return out;
            }
            same_leaf = at.advance(to);
        }
    }
}

template class TrackAccumulator<float>;
template class TrackAccumulator<double>;

}  // namespace photic
