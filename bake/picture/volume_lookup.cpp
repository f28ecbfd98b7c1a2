// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/volume_lookup.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace photic {

VolumeLookup::VolumeLookup(const LightVolume& volume)
    : field_(volume.field),
      second_(volume.second ? &*volume.second : nullptr),
      channels_(volume.field.channels()),
      has_direction_(volume.has_direction && volume.field.channels().flux),
      index_from_world_(volume.field.frame().indexFromWorld()),
      origin_world_(volume.field.frame().origin_world) {}

void VolumeLookup::add(const LightField& field, const glm::ivec3& voxel, double weight, std::array<double, 6>& sums) {
    const int slot = field.needed().slotOf(voxel);
    if (slot < 0 || !field.needed().contains(voxel)) return;
    const auto count = static_cast<std::size_t>(field.channels().count());
    switch (field.state(slot)) {
        case LeafState::Empty:
            return;
        case LeafState::Constant: {
            const auto values = field.constant(slot);
            for (std::size_t c = 0; c < count; ++c) sums[c] += weight * static_cast<double>(values[c]);
            return;
        }
        case LeafState::Dense: {
            const float* values = field.dense(slot) + NeededVoxels::offsetInLeaf(voxel);
            for (std::size_t c = 0; c < count; ++c) {
                sums[c] += weight * static_cast<double>(values[c * LightField::kLeafVoxels]);
            }
            return;
        }
    }
}

LookedUpLight VolumeLookup::sampleOf(const std::array<double, 6>& sums) const {
    LookedUpLight sample;
    const auto colours = static_cast<std::size_t>(channels_.irradiance);
    sample.irradiance = colours == 3 ? glm::dvec3(sums[0], sums[1], sums[2]) : glm::dvec3(sums[0]);
    if (channels_.flux) sample.flux = {sums[colours], sums[colours + 1], sums[colours + 2]};
    return sample;
}

template <class Body>
void VolumeLookup::forEachCorner(const glm::dvec3& position_world, const Body& body) const {
    const glm::dvec3 index = index_from_world_ * (position_world - origin_world_);
    const glm::dvec3 low = glm::floor(index);
    // Also keeps NaN and far away points from overflowing the integers.
    if (!(glm::all(glm::greaterThan(low, glm::dvec3(-1e9))) && glm::all(glm::lessThan(low, glm::dvec3(1e9))))) return;
    const glm::dvec3 high_weight = index - low;
    const glm::ivec3 base(low);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 step(corner >> 2 & 1, corner >> 1 & 1, corner & 1);
        const glm::dvec3 w = glm::mix(1.0 - high_weight, high_weight, glm::dvec3(step));
        const double weight = w.x * w.y * w.z;
        if (weight > 0) body(base + step, weight);
    }
}

LookedUpLight VolumeLookup::at(const glm::dvec3& position_world, int lobe) const {
    const LightField* field = lobe == 0 ? &field_ : second_;
    std::array<double, 6> sums{};
    if (field != nullptr)
        forEachCorner(position_world,
                      [&](const glm::ivec3& voxel, double weight) { add(*field, voxel, weight, sums); });
    return sampleOf(sums);
}

LookedUpLight VolumeLookup::allAt(const glm::dvec3& position_world) const {
    LookedUpLight all = at(position_world);
    if (second_ != nullptr) {
        const LookedUpLight more = at(position_world, 1);
        all.irradiance += more.irradiance, all.flux += more.flux;
    }
    return all;
}

double VolumeLookup::covered(const glm::dvec3& position_world) const {
    double sum = 0;
    forEachCorner(position_world, [&](const glm::ivec3& voxel, double weight) {
        if (field_.needed().contains(voxel)) sum += weight;
    });
    return sum;
}

LookedUpLight VolumeLookup::voxel(const glm::ivec3& voxel, int lobe) const {
    const LightField* field = lobe == 0 ? &field_ : second_;
    std::array<double, 6> sums{};
    if (field != nullptr) add(*field, voxel, 1.0, sums);
    return sampleOf(sums);
}

glm::dvec3 VolumeLookup::receiverIrradiance(const glm::dvec3& position_world, const glm::dvec3& normal) const {
    glm::dvec3 received(0);
    for (int lobe = 0; lobe < lobes(); ++lobe) {
        const LookedUpLight sample = at(position_world, lobe);
        const double mean = sample.meanIrradiance();
        if (mean <= 0) continue;
        received += has_direction_ ? sample.irradiance * std::max(0.0, -glm::dot(normal, sample.flux) / mean)
                                   : sample.irradiance;
    }
    return received;
}

}  // namespace photic
