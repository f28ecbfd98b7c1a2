// SPDX-License-Identifier: Apache-2.0
#include "bake/field/resample.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "bake/field/needed_voxels.h"

namespace photic {
namespace {

// Adds `weight` times a voxel's channels.
void addVoxel(const LightField& field, const glm::ivec3& voxel, float weight, std::array<float, 8>& sum) {
    const int slot = field.needed().slotOf(voxel);
    if (slot < 0 || field.state(slot) == LeafState::Empty) return;
    const int offset = NeededVoxels::offsetInLeaf(voxel);
    if (!NeededVoxels::maskBit(field.needed().mask(slot), offset)) return;
    const auto channels = static_cast<std::size_t>(field.channels().count());
    const bool dense = field.state(slot) == LeafState::Dense;
    const float* data = dense ? field.dense(slot) + offset : field.constant(slot).data();
    const std::size_t stride = dense ? LightField::kLeafVoxels : 1;
    for (std::size_t c = 0; c < channels; ++c) sum[c] += weight * data[c * stride];
}

}  // namespace

std::array<float, 8> sampleTrilinear(const LightField& field, const glm::dvec3& point_index) {
    const glm::dvec3 below = glm::floor(point_index), f = point_index - below;
    const glm::ivec3 base(below);
    std::array<float, 8> sum{};
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 step(corner >> 2, corner >> 1 & 1, corner & 1);
        const double weight = (step.x ? f.x : 1 - f.x) * (step.y ? f.y : 1 - f.y) * (step.z ? f.z : 1 - f.z);
        if (weight > 0) addVoxel(field, base + step, static_cast<float>(weight), sum);
    }
    return sum;
}

LightField reindexed(const LightField& field, const glm::ivec3& shift) {
    GridFrame frame = field.frame();
    frame.origin_world = frame.worldFromIndex(-glm::dvec3(shift));
    frame.min += shift, frame.max += shift;
    NeededVoxels needed = NeededVoxels::none(frame);
    for (int slot = 0; slot < field.leafCount(); ++slot) {
        const glm::ivec3 origin = field.needed().leafOrigin(slot) + shift;
        const auto& mask = field.needed().mask(slot);
        for (int i = 0; i < LightField::kLeafVoxels; ++i)
            if (NeededVoxels::maskBit(mask, i)) needed.add(origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7));
    }
    needed.finish();
    LightField out(std::make_shared<const NeededVoxels>(std::move(needed)), field.channels());
    forEachLeaf(out.needed(), [&](int slot) {
        float* to = out.makeDense(slot);
        const glm::ivec3 origin = out.needed().leafOrigin(slot) - shift;
        for (int c = 0; c < field.channels().count(); ++c)
            for (int i = 0; i < LightField::kLeafVoxels; ++i)
                *to++ = field.value(origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7), c);
    });
    return out;
}

LightField resampledToAxes(const LightField& field) {
    const GridFrame& from = field.frame();
    const double h = std::min(glm::length(from.worldFromIndex()[0]), glm::length(from.worldFromIndex()[1]));
    GridFrame to;
    to.setWorldFromIndex(glm::dmat3(h));
    to.origin_world = glm::dvec3(0.5 * h);

    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p = from.worldFromIndex({corner & 1 ? from.max.x + 0.5 : from.min.x - 0.5,
                                                  corner & 2 ? from.max.y + 0.5 : from.min.y - 0.5,
                                                  corner & 4 ? from.max.z + 0.5 : from.min.z - 0.5});
        low = glm::min(low, p), high = glm::max(high, p);
    }
    constexpr double kTolerance = 1e-6;  // [voxels]
    to.min = glm::ivec3(glm::floor(low / h + kTolerance)), to.max = glm::ivec3(glm::ceil(high / h - kTolerance)) - 1;

    LightField out(std::make_shared<const NeededVoxels>(NeededVoxels::everything(to)), field.channels());
    const auto channels = static_cast<std::size_t>(field.channels().count());
    forEachLeaf(out.needed(), [&](int slot) {
        std::array<float, 8 * LightField::kLeafVoxels> values;
        bool light = false;
        const glm::ivec3 origin = out.needed().leafOrigin(slot);
        const auto& mask = out.needed().mask(slot);
        for (int i = 0; i < LightField::kLeafVoxels; ++i) {
            std::array<float, 8> v{};
            if (NeededVoxels::maskBit(mask, i))
                v = sampleTrilinear(
                    field, from.indexFromWorld(to.worldFromIndex(origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7))));
            for (std::size_t c = 0; c < channels; ++c) {
                values[c * LightField::kLeafVoxels + static_cast<std::size_t>(i)] = v[c];
                light |= v[c] != 0;
            }
        }
        if (!light) return;
        std::copy_n(values.begin(), channels * LightField::kLeafVoxels, out.makeDense(slot));
    });
    return out;
}

}  // namespace photic
