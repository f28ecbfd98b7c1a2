// SPDX-License-Identifier: Apache-2.0
#include "bake/field/post_process.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "bake/field/needed_voxels.h"

namespace photic {
namespace {

// Scales flux down to at most the mean irradiance, for `count` voxels `stride` floats a channel apart.
void boundFlux(float* data, int irradiance_channels, int count, int stride) {
    float *fx = data + irradiance_channels * stride, *fy = fx + stride, *fz = fy + stride;
    // One rounding below 1: the scaled vector's length must not round up past the bound.
    constexpr float kBelowOne = 1.0f - 2 * std::numeric_limits<float>::epsilon();
    for (int i = 0; i < count; ++i) {
        float e = data[i];
        if (irradiance_channels == 3) e = (e + data[i + stride] + data[i + 2 * stride]) * (1.0f / 3);
        e = std::max(e, 0.0f);
        // In double: squares of faint light would vanish in single precision.
        const double x = double(fx[i]), y = double(fy[i]), z = double(fz[i]), length = std::sqrt(x * x + y * y + z * z);
        const float scale = length > double(e) ? kBelowOne * static_cast<float>(double(e) / length) : 1.0f;
        fx[i] *= scale, fy[i] *= scale, fz[i] *= scale;
    }
}

}  // namespace

void restoreFluxBound(LightField& field) {
    if (!field.channels().flux) return;
    const int irradiance = field.channels().irradiance;
    forEachLeaf(field.needed(), [&](int slot) {
        if (field.state(slot) == LeafState::Dense)
            boundFlux(field.dense(slot), irradiance, LightField::kLeafVoxels, LightField::kLeafVoxels);
        if (field.state(slot) == LeafState::Constant) {
            std::array<float, 8> values{};
            std::copy(field.constant(slot).begin(), field.constant(slot).end(), values.begin());
            boundFlux(values.data(), irradiance, 1, 1);
            field.setConstant(slot, values);
        }
    });
}

int collapseConstantLeaves(LightField& field, double relative, double threshold) {
    const NeededVoxels& needed = field.needed();
    const auto channels = static_cast<std::size_t>(field.channels().count());
    const auto colours = static_cast<std::size_t>(field.channels().irradiance);
    std::vector<std::uint8_t> changed(static_cast<std::size_t>(field.leafCount()));
    forEachLeaf(needed, [&](int slot) {
        if (field.state(slot) != LeafState::Dense) return;
        const float* data = field.dense(slot);
        const auto& mask = needed.mask(slot);
        std::array<float, 8> low, high;
        low.fill(std::numeric_limits<float>::infinity()), high.fill(-low[0]);
        std::array<double, 8> sum{};
        int count = 0;
        for (int i = 0; i < LightField::kLeafVoxels; ++i) count += NeededVoxels::maskBit(mask, i);
        const bool full = needed.leafFull(slot);
        float brightest = 0;
        for (std::size_t c = 0; c < channels; ++c) {
            const float* v = data + c * LightField::kLeafVoxels;
            for (int i = 0; i < LightField::kLeafVoxels; ++i) {
                if (!full && !NeededVoxels::maskBit(mask, i)) continue;
                low[c] = std::min(low[c], v[i]), high[c] = std::max(high[c], v[i]);
                sum[c] += double(v[i]);
            }
            if (c < colours) brightest = std::max(brightest, high[c]);
        }
        auto& mark = changed[static_cast<std::size_t>(slot)];
        if (double(brightest) <= threshold) {
            field.setEmpty(slot);
            mark = 1;
            return;
        }
        for (std::size_t c = 0; c < channels; ++c)
            if (!(double(high[c] - low[c]) <= relative * double(brightest)))
                return;  // a NaN stays where it can be found
        std::array<float, 8> mean{};
        for (std::size_t c = 0; c < channels; ++c) mean[c] = static_cast<float>(sum[c] / count);
        field.setConstant(slot, mean);
        mark = 1;
    });
    return static_cast<int>(std::count(changed.begin(), changed.end(), std::uint8_t{1}));
}

}  // namespace photic
