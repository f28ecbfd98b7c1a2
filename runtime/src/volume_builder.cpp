// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/volume_builder.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "runtime/src/guarded.h"

namespace photic::runtime {

bool holdsColour(Channels channels) {
    return channels == Channels::Rgb || channels == Channels::Red || channels == Channels::Green ||
           channels == Channels::Blue || channels == Channels::ColouredIrradiance;
}

VolumeBuilder::VolumeBuilder(const VoxelTransform& transform, std::uint64_t largest_memory)
    : data_(std::make_shared<VolumeData>()), largest_memory_(largest_memory) {
    data_->transform = transform;
    data_->has_direction = false;
}

void VolumeBuilder::requireMemory(std::uint64_t bytes) const {
    if (bytes <= largest_memory_) return;
    fail(ErrorCode::Limit, "the volume needs " + std::to_string(bytes) +
                               " bytes, more than LoadOptions::largest_memory, " + std::to_string(largest_memory_) +
                               "; raise it, or export with a --budget");
}

void VolumeBuilder::allocate(bool coloured) {
    VolumeData& d = *data_;
    d.coloured = coloured;
    const auto inOrder = [](const Int3& a, const Int3& b) {
        return std::array{a[2], a[1], a[0]} < std::array{b[2], b[1], b[0]};
    };
    std::sort(origins_.begin(), origins_.end(), inOrder);
    origins_.erase(std::unique(origins_.begin(), origins_.end()), origins_.end());

    std::uint64_t page_count = origins_.empty() ? 0 : 1;
    for (std::size_t a = 0; a < 3 && !origins_.empty(); ++a) {
        const auto [low, high] = std::minmax_element(origins_.begin(), origins_.end(),
                                                     [a](const Int3& p, const Int3& q) { return p[a] < q[a]; });
        d.brick_min[a] = (*low)[a] >> 3;
        d.brick_count[a] = ((*high)[a] >> 3) - d.brick_min[a] + 1;
        page_count *= static_cast<std::uint64_t>(d.brick_count[a]);  // each below 2^26: no overflow before the check
        requireMemory(page_count * sizeof(std::uint32_t));
    }
    const std::uint64_t bricks = origins_.size() + 1;
    const std::uint64_t voxel_bytes = sizeof(Half4) + (coloured ? sizeof(std::array<Half, 3>) : 0);
    requireMemory(page_count * sizeof(std::uint32_t) + bricks * VolumeData::kVoxels * voxel_bytes);

    d.pages.assign(static_cast<std::size_t>(page_count), 0);
    d.light.assign(static_cast<std::size_t>(bricks) * VolumeData::kVoxels, Half4{});
    if (coloured) d.rgb.assign(d.light.size(), {});
    std::uint32_t number = 1;
    for (const Int3& origin : origins_) {
        const auto at = [&](std::size_t a) { return static_cast<std::size_t>((origin[a] >> 3) - d.brick_min[a]); };
        const auto nx = static_cast<std::size_t>(d.brick_count[0]), ny = static_cast<std::size_t>(d.brick_count[1]);
        d.pages[(at(2) * ny + at(1)) * nx + at(0)] = number++;
    }
    origins_ = {};
}

void VolumeBuilder::setBlocks(std::shared_ptr<const BlockTexels> blocks) {
    requireMemory(blocks->bytes() + data_->light.size() * sizeof(Half4));
    data_->blocks = std::move(blocks);
}

void VolumeBuilder::beginChannels(Channels channels) {
    switch (channels) {
        case Channels::FluxAndIrradiance:
        case Channels::FluxX:
        case Channels::FluxY:
        case Channels::FluxZ:
        case Channels::Direction:
            data_->has_direction = true;
            break;
        default:
            break;
    }
}

Half VolumeBuilder::repaired(float value, float least) {
    if (value >= least && value <= kLargestHalf) return halfOfFloat(value);
    ++data_->repaired_values;
    if (!std::isfinite(value)) return 0;
    return halfOfFloat(std::clamp(value, least, kLargestHalf));
}

std::array<Half, VolumeData::kVoxels> VolumeBuilder::halves(const float* values, std::size_t stride, float least) {
    constexpr std::size_t kVoxels = VolumeData::kVoxels;
    std::array<float, kVoxels> component;
    bool sound = true;
    for (std::size_t v = 0; v < kVoxels; ++v) {
        component[v] = values[v * stride];
        sound = sound && component[v] >= least && component[v] <= kLargestHalf;
    }
    std::array<Half, kVoxels> out;
    // Nearly always nothing is to be repaired; then the loop is without branches and goes several at a time.
    if (sound) {
        for (std::size_t v = 0; v < kVoxels; ++v) out[v] = halfOfFiniteFloat(component[v]);
    } else {
        for (std::size_t v = 0; v < kVoxels; ++v) out[v] = repaired(component[v], least);
    }
    return out;
}

void VolumeBuilder::setBrick(const Int3& origin, Channels channels, const float* values) {
    VolumeData& d = *data_;
    const std::size_t first = std::size_t{d.page(origin[0] >> 3, origin[1] >> 3, origin[2] >> 3)} * VolumeData::kVoxels;
    Half4* light = d.light.data() + first;
    std::array<Half, 3>* rgb = d.coloured ? d.rgb.data() + first : nullptr;
    const auto setLight = [&](std::size_t component, std::size_t of, std::size_t number) {
        const auto half = halves(values + number, of, component < 3 ? -kLargestHalf : 0);
        for (std::size_t v = 0; v < VolumeData::kVoxels; ++v) light[v][component] = half[v];
    };
    const auto setColour = [&](std::size_t component, std::size_t of, std::size_t number) {
        const auto half = halves(values + number, of, 0);
        for (std::size_t v = 0; v < VolumeData::kVoxels; ++v) rgb[v][component] = half[v];
    };
    switch (channels) {
        case Channels::FluxAndIrradiance:
            for (std::size_t c = 0; c < 4; ++c) setLight(c, 4, c);
            break;
        case Channels::Irradiance:
            setLight(3, 1, 0);
            break;
        case Channels::FluxX:
        case Channels::FluxY:
        case Channels::FluxZ:
            setLight(static_cast<std::size_t>(channels) - static_cast<std::size_t>(Channels::FluxX), 1, 0);
            break;
        case Channels::Red:
        case Channels::Green:
        case Channels::Blue:
            setColour(static_cast<std::size_t>(channels) - static_cast<std::size_t>(Channels::Red), 1, 0);
            break;
        case Channels::Rgb:
        case Channels::ColouredIrradiance:
            for (std::size_t c = 0; c < 3; ++c) setColour(c, 3, c);
            if (channels == Channels::Rgb) break;
            for (std::size_t v = 0; v < VolumeData::kVoxels; ++v) {
                float sum = 0;
                for (const Half half : rgb[v]) sum += floatOfHalf(half);
                light[v][3] = halfOfFloat(sum / 3);
            }
            break;
        case Channels::Direction:
            for (std::size_t v = 0; v < VolumeData::kVoxels; ++v) {
                const float mean = floatOfHalf(light[v][3]);
                for (std::size_t c = 0; c < 3; ++c) light[v][c] = repaired(mean * values[3 * v + c], -kLargestHalf);
            }
            break;
    }
}

Volume VolumeBuilder::finish() {
    finishVolume(*data_);
    return Volume(std::shared_ptr<const VolumeData>(std::move(data_)));
}

}  // namespace photic::runtime
