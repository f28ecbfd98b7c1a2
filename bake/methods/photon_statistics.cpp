// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/photon_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr std::size_t kVoxels = LightField::kLeafVoxels;
constexpr std::int64_t kLeavesATask = 32;

std::size_t bytesOf(FieldChannels channels, std::size_t lobes) {
    const std::size_t sums = static_cast<std::size_t>(channels.count()) * lobes;
    return kVoxels * ((sums + 1) * sizeof(double) + sizeof(std::uint32_t));
}

template <class Body>
void forSlots(int slots, const Body& body) {
    parallelFor((slots + kLeavesATask - 1) / kLeavesATask, [&](std::int64_t task) {
        const std::int64_t end = std::min<std::int64_t>(slots, (task + 1) * kLeavesATask);
        for (std::int64_t slot = task * kLeavesATask; slot < end; ++slot) body(static_cast<int>(slot));
    });
}

/// What the root of the unbiased variance of n normal values is of their deviation, on average: less than 1, since a
/// root bends downwards (0.984 for 16).
double rootBias(double n) {
    return std::sqrt(2 / (n - 1)) * std::exp(std::lgamma(0.5 * n) - std::lgamma(0.5 * (n - 1)));
}

}  // namespace

PhotonStatistics::PhotonStatistics(std::shared_ptr<const NeededVoxels> needed, FieldChannels channels, int lobes)
    : needed_(std::move(needed)),
      channels_(channels),
      lobes_(static_cast<std::size_t>(lobes)),
      leaf_bytes_(bytesOf(channels, lobes_)),
      arena_(leaf_bytes_, std::max(1, needed_->leafCount())),
      leaves_(static_cast<std::size_t>(needed_->leafCount()), nullptr) {}

template <class Real>
void PhotonStatistics::fold(std::vector<TrackAccumulator<Real>>& repetitions, std::size_t count) {
    repetitions_ += static_cast<int>(count);
    forSlots(needed_->leafCount(), [&](int slot) { foldLeaf(slot, repetitions, count); });
}

template <class Real>
void PhotonStatistics::foldLeaf(int slot, std::vector<TrackAccumulator<Real>>& repetitions, std::size_t count) {
    const auto stride = static_cast<std::size_t>(channels_.count()),
               colours = static_cast<std::size_t>(channels_.irradiance);
    double*& leaf = leaves_[static_cast<std::size_t>(slot)];
    for (std::size_t r = 0; r < count; ++r) {
        std::array<double, kVoxels> light{};  // of both lobes, sum of the channels
        bool lit = false;
        for (std::size_t l = 0; l < lobes_; ++l) {
            TrackAccumulator<Real>& repetition = repetitions[r * lobes_ + l];
            const Real* x = repetition.sums(slot);
            if (!x) continue;
            lit = true;
            if (!leaf) {
                bool zeroed = false;
                leaf = static_cast<double*>(arena_.allocate(zeroed));
                if (!zeroed) std::memset(leaf, 0, leaf_bytes_);
            }
            double* sums = leaf + kVoxels * stride * l;
            for (std::size_t i = 0; i < kVoxels * stride; ++i) sums[i] += static_cast<double>(x[i]);
            for (std::size_t v = 0; v < kVoxels; ++v)
                for (std::size_t c = 0; c < colours; ++c) light[v] += static_cast<double>(x[v * stride + c]);
            auto* paths = reinterpret_cast<std::uint32_t*>(leaf + kVoxels * (stride * lobes_ + 1));
            const std::uint32_t* crossed = repetition.counts(slot);
            for (std::size_t v = 0; v < kVoxels; ++v) paths[v] += crossed[v];
            repetition.clear(slot);
        }
        if (!lit) continue;
        double* squares = leaf + kVoxels * stride * lobes_;
        for (std::size_t v = 0; v < kVoxels; ++v) {
            const double mean = light[v] / static_cast<double>(colours);
            squares[v] += mean * mean;
        }
    }
}

template void PhotonStatistics::fold(std::vector<TrackAccumulator<float>>&, std::size_t);
template void PhotonStatistics::fold(std::vector<TrackAccumulator<double>>&, std::size_t);

PhotonStatistics::Result PhotonStatistics::result() const {
    Result out{emptyLobes(needed_, channels_, lobes_ > 1), LightField(needed_, {1, false}),
               LightField(needed_, {1, false})};
    const auto stride = static_cast<std::size_t>(channels_.count()),
               colours = static_cast<std::size_t>(channels_.irradiance);
    const double n = repetitions_, volume = needed_->frame().voxelVolume();
    const double error_scale = 1 / (volume * rootBias(n) * std::sqrt(n * (n - 1)));
    std::vector<std::int64_t> active(static_cast<std::size_t>(needed_->leafCount()), 0);
    forSlots(needed_->leafCount(), [&](int slot) {
        const double* leaf = leaves_[static_cast<std::size_t>(slot)];
        if (!leaf) return;
        const double* squares = leaf + kVoxels * stride * lobes_;
        const auto* paths = reinterpret_cast<const std::uint32_t*>(squares + kVoxels);
        bool was_empty = false;
        float* field[2] = {out.field.first.makeDenseUninitialised(slot, was_empty), nullptr};
        if (out.field.second) field[1] = out.field.second->makeDenseUninitialised(slot, was_empty);
        float* error = out.standard_error.makeDenseUninitialised(slot, was_empty);
        float* count = out.path_count.makeDenseUninitialised(slot, was_empty);
        for (std::size_t v = 0; v < kVoxels; ++v) {
            double sum = 0;
            for (std::size_t l = 0; l < lobes_; ++l) {
                const double* sums = leaf + (kVoxels * l + v) * stride;
                for (std::size_t c = 0; c < stride; ++c)
                    field[l][c * kVoxels + v] = static_cast<float>(sums[c] / (n * volume));
                for (std::size_t c = 0; c < colours; ++c) sum += sums[c];
            }
            sum /= static_cast<double>(colours);
            error[v] = static_cast<float>(std::sqrt(std::max(0.0, squares[v] - sum * sum / n)) * error_scale);
            count[v] = static_cast<float>(paths[v]);
            active[static_cast<std::size_t>(slot)] += paths[v] > 0;
        }
    });
    for (const std::int64_t a : active) out.active_voxels += a;
    return out;
}

}  // namespace photic
