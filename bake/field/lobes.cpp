// SPDX-License-Identifier: Apache-2.0
#include "bake/field/lobes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

namespace photic {
namespace {

constexpr int kVoxels = LightField::kLeafVoxels;
constexpr double kOpposed = 0.03;  // of the light: what |direction| of all of it would lack

/// Values of a leaf that may be of any state.
class LeafValues {
public:
    LeafValues(const LightField& field, int slot)
        : channels_(field.channels()),
          dense_(field.state(slot) == LeafState::Dense ? field.dense(slot) : nullptr),
          constant_(field.state(slot) == LeafState::Constant ? field.constant(slot).data() : nullptr) {}
    double at(int channel, int voxel) const {
        return dense_ ? double(dense_[channel * kVoxels + voxel]) : constant_ ? double(constant_[channel]) : 0.0;
    }
    double irradiance(int voxel) const {
        double sum = 0;
        for (int c = 0; c < channels_.irradiance; ++c) sum += at(c, voxel);
        return sum / channels_.irradiance;
    }
    glm::dvec3 flux(int voxel) const {
        const int c = channels_.irradiance;
        return {at(c, voxel), at(c + 1, voxel), at(c + 2, voxel)};
    }

private:
    FieldChannels channels_;
    const float *dense_, *constant_;
};

bool opposes(const LobeFields& lobes, int slot, double faint) {
    if (lobes.first.state(slot) == LeafState::Empty || lobes.second->state(slot) == LeafState::Empty) return false;
    const LeafValues first(lobes.first, slot), second(*lobes.second, slot);
    const auto& needed = lobes.first.needed().mask(slot);
    for (int v = 0; v < kVoxels; ++v) {
        if (!NeededVoxels::maskBit(needed, v)) continue;
        const double light = first.irradiance(v) + second.irradiance(v);
        if (!(light > faint)) continue;
        const glm::dvec3 f1 = first.flux(v), f2 = second.flux(v);
        if (glm::length(f1) + glm::length(f2) - glm::length(f1 + f2) > kOpposed * light) return true;
    }
    return false;
}

void addLeaf(LightField& to, const LightField& from, int slot) {
    if (from.state(slot) == LeafState::Empty) return;
    float* out = to.makeDense(slot);
    const int channels = to.channels().count();
    if (from.state(slot) == LeafState::Dense) {
        const float* in = from.dense(slot);
        for (int i = 0; i < channels * kVoxels; ++i) out[i] += in[i];
        return;
    }
    for (int c = 0; c < channels; ++c)
        for (int i = 0; i < kVoxels; ++i) out[c * kVoxels + i] += from.constant(slot)[static_cast<std::size_t>(c)];
}

}  // namespace

LobeFields emptyLobes(const std::shared_ptr<const NeededVoxels>& needed, FieldChannels channels, bool parted) {
    LobeFields lobes{LightField(needed, channels), std::nullopt};
    if (parted && channels.flux) lobes.second.emplace(needed, channels);
    return lobes;
}

void addField(LightField& to, const LightField& from) {
    forEachLeaf(to.needed(), [&](int slot) { addLeaf(to, from, slot); });
}

void keepOpposedLight(LobeFields& lobes, double faint) {
    if (!lobes.second) return;
    const NeededVoxels& needed = lobes.first.needed();
    std::vector<std::uint8_t> opposed(static_cast<std::size_t>(needed.leafCount()));
    if (lobes.first.channels().flux)
        forEachLeaf(needed, [&](int slot) { opposed[static_cast<std::size_t>(slot)] = opposes(lobes, slot, faint); });
    const auto isBeside = [&](int slot) {
        const glm::ivec3 origin = needed.leafOrigin(slot);
        for (int n = 0; n < 27; ++n) {
            const int other = needed.slotOf(origin + 8 * glm::ivec3(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1));
            if (other >= 0 && opposed[static_cast<std::size_t>(other)]) return true;
        }
        return false;
    };
    forEachLeaf(needed, [&](int slot) {
        if (isBeside(slot)) return;
        addLeaf(lobes.first, *lobes.second, slot);
        lobes.second->setEmpty(slot);
    });
    if (std::find(opposed.begin(), opposed.end(), std::uint8_t{1}) == opposed.end()) lobes.second.reset();
}

bool totalIrradiance(const LightField& first, const LightField* second, int slot, double* out) {
    const bool two = second != nullptr && second->state(slot) != LeafState::Empty;
    if (!two && first.state(slot) == LeafState::Empty) return false;
    const LeafValues values(first, slot), others(two ? *second : first, slot);
    for (int v = 0; v < kVoxels; ++v) out[v] = values.irradiance(v) + (two ? others.irradiance(v) : 0);
    return true;
}

LightField joined(LobeFields lobes) {
    if (lobes.second) addField(lobes.first, *lobes.second);
    return std::move(lobes.first);
}

}  // namespace photic
