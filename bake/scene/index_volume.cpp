// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/index_volume.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace photic {
namespace {

std::size_t flat(const glm::ivec3& size, int x, int y, int z) {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size.x) +
           static_cast<std::size_t>(x);
}

/// Weights of four samples around a place, t of the way from the second to the third [Keys 1981, eq. 15].
struct Taps {
    int index[4];
    double weight[4];
};
Taps tapsAt(double place, int count, bool hold) {
    Taps taps{};
    if (count == 1 && hold) {
        taps.weight[1] = 1;
        return taps;
    }
    const double p = hold ? std::clamp(place, 0.0, count - 1.0) : std::clamp(place, -3.0, count + 2.0);
    const int first = hold ? std::min(static_cast<int>(p), count - 2) : static_cast<int>(std::floor(p));
    const double t = p - first, t2 = t * t, t3 = t2 * t;
    const double w[4] = {-0.5 * t + t2 - 0.5 * t3, 1 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2 * t2 - 1.5 * t3,
                         0.5 * (t3 - t2)};
    for (int k = 0; k < 4; ++k) taps.index[k] = first - 1 + k, taps.weight[k] = w[k];
    if (!hold) return taps;
    // Beyond the ends the samples go on in a straight line: the gradient is right up to the last.
    if (taps.index[0] < 0) taps.index[0] = 0, taps.weight[1] += 2 * w[0], taps.weight[2] -= w[0], taps.weight[0] = 0;
    if (taps.index[3] >= count) {
        taps.index[3] = count - 1;
        taps.weight[2] += 2 * w[3], taps.weight[1] -= w[3], taps.weight[3] = 0;
    }
    return taps;
}

}  // namespace

IndexVolume::IndexVolume(Samples samples, double medium)
    : samples_(std::move(samples)),
      index_from_world_(glm::inverse(samples_.world_from_index)),
      medium_(medium),
      least_(std::numeric_limits<double>::infinity()),
      largest_(0) {
    full_ = std::none_of(samples_.values.begin(), samples_.values.end(), [](float n) { return std::isnan(n); });
    if (!full_) given_.resize(samples_.values.size());
    for (std::size_t i = 0; i < samples_.values.size(); ++i) {
        float& n = samples_.values[i];
        if (!full_) given_[i] = !std::isnan(n);
        if (std::isnan(n)) n = static_cast<float>(medium);
        least_ = std::min(least_, static_cast<double>(n)), largest_ = std::max(largest_, static_cast<double>(n));
    }
    if (!full_) least_ = std::min(least_, medium), largest_ = std::max(largest_, medium);
    const glm::ivec3 size = samples_.size;
    double step[3] = {0, 0, 0};  // between neighbours along each axis of the grid
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const double here = sample(x, y, z);
                step[0] = std::max(step[0], std::fabs(sample(x + 1, y, z) - here));
                step[1] = std::max(step[1], std::fabs(sample(x, y + 1, z) - here));
                step[2] = std::max(step[2], std::fabs(sample(x, y, z + 1) - here));
            }
    for (int a = 0; a < 3; ++a)
        for (int i = 0; i < 3; ++i) steepest_[a] += step[i] * std::fabs(index_from_world_[a][i]);
}

IndexVolume::IndexVolume(std::vector<GradedObject> objects)
    : objects_(std::move(objects)), index_from_world_(1), medium_(1), least_(1), largest_(1) {
    samples_.size = glm::ivec3(1), samples_.values = {1.0f};
}

float IndexVolume::sample(int x, int y, int z) const {
    const glm::ivec3 size = samples_.size;
    if (full_)
        x = std::clamp(x, 0, size.x - 1), y = std::clamp(y, 0, size.y - 1), z = std::clamp(z, 0, size.z - 1);
    else if (x < 0 || y < 0 || z < 0 || x >= size.x || y >= size.y || z >= size.z)
        return static_cast<float>(medium_);
    return samples_.values[flat(size, x, y, z)];
}

bool IndexVolume::holds(const glm::dvec3& sample) const {
    if (full_) return true;
    const glm::ivec3 size = samples_.size, low(glm::floor(sample));
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 p = low + glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
        if (p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < size.x && p.y < size.y && p.z < size.z &&
            given_[flat(size, p.x, p.y, p.z)])
            return true;
    }
    return false;
}

double IndexVolume::at(const glm::dvec3& world) const {
    const glm::dvec3 p = index_from_world_ * (world - samples_.origin_world);
    const glm::ivec3 size = samples_.size;
    const Taps x = tapsAt(p.x, size.x, full_), y = tapsAt(p.y, size.y, full_), z = tapsAt(p.z, size.z, full_);
    double n = 0;
    for (int k = 0; k < 4; ++k) {
        if (z.weight[k] == 0) continue;
        for (int j = 0; j < 4; ++j) {
            if (y.weight[j] == 0) continue;
            double row = 0;
            for (int i = 0; i < 4; ++i)
                if (x.weight[i] != 0) row += x.weight[i] * sample(x.index[i], y.index[j], z.index[k]);
            n += z.weight[k] * y.weight[j] * row;
        }
    }
    return std::clamp(n, least_, largest_);
}

IndexVolume layeredIndex(std::vector<std::pair<double, double>> layers) {
    constexpr int kSamples = 1025;
    std::sort(layers.begin(), layers.end());
    IndexVolume::Samples samples;
    const double low = layers.front().first, high = layers.back().first;
    const int count = layers.size() > 1 ? kSamples : 1;
    samples.size = {1, 1, count};
    samples.origin_world = {0, 0, low};
    if (count > 1) samples.world_from_index[2].z = (high - low) / (count - 1);
    std::size_t above = std::min<std::size_t>(1, layers.size() - 1);
    for (int k = 0; k < count; ++k) {
        const double z = low + k * samples.world_from_index[2].z;
        while (above + 1 < layers.size() && layers[above].first < z) ++above;
        const auto &to = layers[above], &from = layers[above > 0 ? above - 1 : 0];
        const double part = above > 0 ? std::clamp((z - from.first) / (to.first - from.first), 0.0, 1.0) : 0.0;
        samples.values.push_back(static_cast<float>(from.second + part * (to.second - from.second)));
    }
    return {std::move(samples), layers.front().second};
}

}  // namespace photic
