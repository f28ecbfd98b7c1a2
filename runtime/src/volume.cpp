// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>

#include "runtime/src/guarded.h"
#include "runtime/src/volume_data.h"

namespace photic::runtime {
namespace {

constexpr double kFarthestIndex = 1e9;  // what floor() of still fits an int

/// flux.xyz, mean irradiance, then r, g, b when coloured; in stored units.
using Sums = std::array<double, 7>;

void add(const VolumeData& data, std::size_t slot, double weight, Sums& sums) {
    const Half4& light = data.light[slot];
    for (std::size_t c = 0; c < 4; ++c) sums[c] += weight * static_cast<double>(floatOfHalf(light[c]));
    if (!data.coloured) return;
    for (std::size_t c = 0; c < 3; ++c) sums[4 + c] += weight * static_cast<double>(floatOfHalf(data.rgb[slot][c]));
}

Sums interpolate(const VolumeData& data, const Vec3& world) {
    Sums sums{};
    const Double3 index = data.transform.indexOf({world.x, world.y, world.z});
    Int3 low;
    Double3 fraction;
    for (std::size_t a = 0; a < 3; ++a) {
        if (!(std::fabs(index[a]) < kFarthestIndex)) return sums;  // NaN too
        low[a] = static_cast<int>(std::floor(index[a]));
        fraction[a] = index[a] - low[a];
    }
    for (int corner = 0; corner < 8; ++corner) {
        const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
        const double weight = (x ? fraction[0] : 1 - fraction[0]) * (y ? fraction[1] : 1 - fraction[1]) *
                              (z ? fraction[2] : 1 - fraction[2]);
        const std::size_t slot = data.slot(low[0] + x, low[1] + y, low[2] + z);
        if (slot >= VolumeData::kVoxels) add(data, slot, weight, sums);  // brick 0 is dark
    }
    return sums;
}

}  // namespace

Volume::Volume() {
    static const auto kDark = [] {
        auto data = std::make_shared<VolumeData>();
        data->light.resize(VolumeData::kVoxels);
        return std::shared_ptr<const VolumeData>(std::move(data));
    }();
    data_ = kDark;
}

Light Volume::sample(const Vec3& world) const {
    const Sums sums = interpolate(*data_, world);
    const double scale = data_->metadata.reference_irradiance;
    Light light;
    light.flux = {scale * sums[0], scale * sums[1], scale * sums[2]};
    light.irradiance = data_->coloured ? Vec3{scale * sums[4], scale * sums[5], scale * sums[6]}
                                       : Vec3{scale * sums[3], scale * sums[3], scale * sums[3]};
    return light;
}

Vec3 Volume::irradiance(const Vec3& world, const Vec3& normal) const {
    const Sums sums = interpolate(*data_, world);
    double factor = data_->metadata.reference_irradiance;
    if (data_->has_direction) {
        const double towards = -(normal.x * sums[0] + normal.y * sums[1] + normal.z * sums[2]);
        if (!(towards > 0 && sums[3] > 0)) return {};
        factor *= towards / sums[3];
    }
    if (data_->coloured) return {factor * sums[4], factor * sums[5], factor * sums[6]};
    return {factor * sums[3], factor * sums[3], factor * sums[3]};
}

const Metadata& Volume::metadata() const { return data_->metadata; }
bool Volume::coloured() const { return data_->coloured; }
bool Volume::hasDirection() const { return data_->has_direction; }
std::uint64_t Volume::litVoxelCount() const { return data_->lit_voxels; }
std::uint64_t Volume::repairedValues() const { return data_->repaired_values; }

VoxelBox Volume::litVoxels() const {
    VoxelBox box;
    std::copy(data_->lit_min.begin(), data_->lit_min.end(), box.min);
    std::copy(data_->lit_max.begin(), data_->lit_max.end(), box.max);
    return box;
}

Vec3 Volume::voxelCentre(int i, int j, int k) const {
    const VoxelTransform& t = data_->transform;
    const Double3 offset = multiply(t.world_from_index, {double(i), double(j), double(k)});
    return {t.origin_world[0] + offset[0], t.origin_world[1] + offset[1], t.origin_world[2] + offset[2]};
}

std::uint64_t Volume::bytes() const {
    return sizeof(VolumeData) + data_->pages.size() * sizeof(std::uint32_t) + data_->light.size() * sizeof(Half4) +
           data_->rgb.size() * sizeof(std::array<Half, 3>);
}

namespace {

void findLitVoxels(VolumeData& data) {
    data.lit_min = {kLargestIndex, kLargestIndex, kLargestIndex};
    data.lit_max = {-kLargestIndex, -kLargestIndex, -kLargestIndex};
    data.lit_voxels = 0;
    std::size_t page = 0;
    for (int pz = 0; pz < data.brick_count[2]; ++pz) {
        for (int py = 0; py < data.brick_count[1]; ++py) {
            for (int px = 0; px < data.brick_count[0]; ++px, ++page) {
                const std::size_t first = std::size_t{data.pages[page]} * VolumeData::kVoxels;
                if (first == 0) continue;
                const Int3 corner = {8 * (data.brick_min[0] + px), 8 * (data.brick_min[1] + py),
                                     8 * (data.brick_min[2] + pz)};
                for (int v = 0; v < VolumeData::kVoxels; ++v) {
                    const std::size_t slot = first + static_cast<std::size_t>(v);
                    const bool lit =
                        data.light[slot] != Half4{} || (data.coloured && data.rgb[slot] != std::array<Half, 3>{});
                    if (!lit) continue;
                    ++data.lit_voxels;
                    const Int3 voxel = {corner[0] + (v & 7), corner[1] + (v >> 3 & 7), corner[2] + (v >> 6)};
                    for (std::size_t a = 0; a < 3; ++a) {
                        data.lit_min[a] = std::min(data.lit_min[a], voxel[a]);
                        data.lit_max[a] = std::max(data.lit_max[a], voxel[a]);
                    }
                }
            }
        }
    }
    if (data.lit_voxels == 0) data.lit_min = {0, 0, 0}, data.lit_max = {-1, -1, -1};
}

/// The period along one world axis as whole voxels along one axis of the grid.
void addPeriod(VolumeData& data, const Double3& period_world) {
    const Double3 steps = multiply(data.transform.index_from_world, period_world);
    const auto longest = static_cast<std::size_t>(
        std::max_element(steps.begin(), steps.end(), [](double a, double b) { return std::fabs(a) < std::fabs(b); }) -
        steps.begin());
    const double voxels = std::fabs(steps[longest]);
    constexpr double kTolerance = 1e-3;  // [voxels]
    double off = std::fabs(voxels - std::round(voxels));
    for (std::size_t a = 0; a < 3; ++a) off = a == longest ? off : std::max(off, std::fabs(steps[a]));
    if (!(off <= kTolerance && voxels >= 1 && voxels < kLargestIndex)) {
        fail(ErrorCode::Format,
             "the period is " + std::to_string(voxels) +
                 " voxels, which is no whole number along one axis; bake with a voxel size that divides it");
    }
    data.period[longest] = static_cast<int>(std::lround(voxels));
}

}  // namespace

void finishVolume(VolumeData& data) {
    findLitVoxels(data);
    data.period = {0, 0, 0};
    const Vec3& p = data.metadata.period;
    if (p.x != 0) addPeriod(data, {p.x, 0, 0});
    if (p.y != 0) addPeriod(data, {0, p.y, 0});
    if (p.z != 0) addPeriod(data, {0, 0, p.z});
}

}  // namespace photic::runtime
