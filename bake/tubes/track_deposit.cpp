// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/track_deposit.h"

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
      index_from_world_(glm::inverse(needed.frame().world_from_index)),
      origin_world_(needed.frame().origin_world),
      box_low_(needed.frame().min),
      box_high_(needed.frame().max + 1),
      needed_low_(box_high_),
      needed_high_(box_low_),
      leaf_bytes_(leafBytes<Real>(channels)),
      arena_(std::make_unique<LeafArena>(leaf_bytes_, std::max(1, needed.leafCount()))),
      leaves_(static_cast<std::size_t>(needed.leafCount()), nullptr) {
    if (needed.isEverything()) {
        needed_low_ = box_low_, needed_high_ = box_high_;
        return;
    }
    for (int slot = 0; slot < needed.leafCount(); ++slot) {
        const glm::dvec3 leaf(needed.leafOrigin(slot));
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
    return leaf ? reinterpret_cast<const std::uint32_t*>(leaf + kLeafVoxels * static_cast<std::size_t>(channels_.count())) : nullptr;
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
bool TrackAccumulator<Real>::clipTo(const Ray& ray, const glm::dvec3& low, const glm::dvec3& high, double& begin, double& end) const {
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
bool TrackAccumulator<Real>::clip(const glm::dvec3& origin, const glm::dvec3& direction, double& begin, double& end) const {
    begin = 0, end = std::numeric_limits<double>::infinity();
    return clipTo({index_from_world_ * (origin - origin_world_) + 0.5, index_from_world_ * direction}, box_low_, box_high_, begin, end);
}

template <class Real>
DepositedTrack TrackAccumulator<Real>::deposit(const Track& track) {
    const Ray ray{index_from_world_ * (track.origin - origin_world_) + 0.5, index_from_world_ * track.direction};
    double begin = track.begin, end = track.end;
    if (!clipTo(ray, needed_low_, needed_high_, begin, end) || !std::isfinite(end)) return {};

    const bool medium = track.extinction != glm::dvec3(0);
    DepositedTrack out;
    if (channels_.irradiance == 1)
        out = channels_.flux ? medium ? walk<1, true, true>(track, ray, begin, end) : walk<1, true, false>(track, ray, begin, end)
                             : medium ? walk<1, false, true>(track, ray, begin, end) : walk<1, false, false>(track, ray, begin, end);
    else
        out = channels_.flux ? medium ? walk<3, true, true>(track, ray, begin, end) : walk<3, true, false>(track, ray, begin, end)
                             : medium ? walk<3, false, true>(track, ray, begin, end) : walk<3, false, false>(track, ray, begin, end);
    // With every voxel needed the ledger does not trust the walk.
    if (needed_->isEverything()) {
        out.path = 0;
        for (int c = 0; c < channels_.irradiance; ++c)
            out.path += track.power[c] * meanTransmittance(track.extinction[c], begin, end - begin) * (end - begin) / channels_.irradiance;
    }
    return out;
}

template <class Real>
template <int Channels, bool Flux, bool Medium>
DepositedTrack TrackAccumulator<Real>::walk(const Track& track, const Ray& ray, double begin, double end) {
    constexpr int kStride = Channels + (Flux ? 3 : 0);
    constexpr int kShift[3] = {6, 3, 0};
    const bool everything = needed_->isEverything();

    // First voxel; rounding may put the entry a hair outside.
    glm::ivec3 voxel;
    double next[3], delta[3];
    int step[3];
    for (int a = 0; a < 3; ++a) {
        const double at = ray.origin[a] + begin * ray.direction[a];
        voxel[a] = static_cast<int>(std::clamp(std::floor(at), needed_low_[a], needed_high_[a] - 1));
        const double d = ray.direction[a];
        step[a] = d < 0 ? -1 : 1;
        delta[a] = d == 0 ? std::numeric_limits<double>::infinity() : 1.0 / std::fabs(d);
        next[a] = d == 0 ? std::numeric_limits<double>::infinity() : (voxel[a] + (d > 0 ? 1 : 0) - ray.origin[a]) / d;
    }

    double along[3] = {track.direction.x, track.direction.y, track.direction.z};
    double power[Channels], transmittance[Channels];
    for (int c = 0; c < Channels; ++c) power[c] = track.power[c], transmittance[c] = Medium ? std::exp(-track.extinction[c] * begin) : 1.0;

    DepositedTrack out;
    double t = begin;
    while (true) {
        // A leaf: find it once, then walk its voxels.
        const int slot = needed_->slotOf(voxel);
        const bool full = slot >= 0 && needed_->leafFull(slot);
        const NeededVoxels::Mask mask = slot >= 0 ? needed_->mask(slot) : NeededVoxels::Mask{};
        Real* leaf = full ? leafAt(slot) : slot >= 0 ? leaves_[static_cast<std::size_t>(slot)] : nullptr;
        int offset = NeededVoxels::offsetInLeaf(voxel);
        while (true) {
            const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
            const double to = std::min(next[axis], end), length = to - t;
            const bool record = length > 0 && (full || (slot >= 0 && NeededVoxels::maskBit(mask, offset)));
            if (record && !leaf) leaf = leafAt(slot);
            double deposit[Channels];
            for (int c = 0; c < Channels; ++c) {
                if constexpr (Medium) {
                    const double depth = track.extinction[c] * std::max(length, 0.0), mean = meanTransmittance(depth);
                    deposit[c] = power[c] * transmittance[c] * mean * length;
                    transmittance[c] *= 1.0 - depth * mean;
                } else {
                    deposit[c] = power[c] * length;
                }
            }
            if (record) {
                Real* sum = leaf + static_cast<std::size_t>(offset) * kStride;
                double mean = deposit[0];
                if constexpr (Channels == 3) mean = (deposit[0] + deposit[1] + deposit[2]) * (1.0 / 3);
                for (int c = 0; c < Channels; ++c) sum[c] += static_cast<Real>(deposit[c]);
                if constexpr (Flux)
                    for (int a = 0; a < 3; ++a) sum[Channels + a] += static_cast<Real>(mean * along[a]);
                ++reinterpret_cast<std::uint32_t*>(leaf + kLeafVoxels * kStride)[offset];
                out.touched = true;
                if (!everything) out.path += mean;
            }
            if (next[axis] >= end) return out;
            t = std::max(t, to);
            next[axis] += delta[axis];
            voxel[axis] += step[axis];
            const int shift = kShift[axis], local = (offset >> shift & 7) + step[axis];
            if (local & ~7) break;
            offset += step[axis] * (1 << shift);
        }
    }
}

template class TrackAccumulator<float>;
template class TrackAccumulator<double>;

}  // namespace photic
