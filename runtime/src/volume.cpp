// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
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

namespace {

void add(const VolumeData& data, const Vec3& world, Light& light) {
    const Sums sums = interpolate(data, world);
    const double scale = data.metadata.reference_irradiance;
    const auto add3 = [scale](Vec3& to, double x, double y, double z) {
        to.x += scale * x, to.y += scale * y, to.z += scale * z;
    };
    add3(light.flux, sums[0], sums[1], sums[2]);
    if (data.coloured) {
        add3(light.irradiance, sums[4], sums[5], sums[6]);
    } else {
        add3(light.irradiance, sums[3], sums[3], sums[3]);
    }
}

void add(const VolumeData& data, const Vec3& world, const Vec3& normal, Vec3& received) {
    const Sums sums = interpolate(data, world);
    double factor = data.metadata.reference_irradiance;
    if (data.has_direction) factor *= towards(normal, {sums[0], sums[1], sums[2]}, sums[3]);
    received.x += factor * sums[data.coloured ? 4 : 3];
    received.y += factor * sums[data.coloured ? 5 : 3];
    received.z += factor * sums[data.coloured ? 6 : 3];
}

}  // namespace

Light Volume::sample(const Vec3& world) const {
    Light light;
    add(*data_, world, light);
    if (data_->second) add(*data_->second, world, light);
    return light;
}

Vec3 Volume::irradiance(const Vec3& world, const Vec3& normal) const {
    Vec3 received;
    add(*data_, world, normal, received);
    if (data_->second) add(*data_->second, world, normal, received);
    return received;
}

Volume Volume::secondLobe() const { return data_->second ? Volume(data_->second) : Volume(); }
bool Volume::hasSecondLobe() const { return data_->second != nullptr; }

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
           data_->rgb.size() * sizeof(std::array<Half, 3>) + (data_->blocks ? data_->blocks->bytes() : 0) +
           (data_->second ? Volume(data_->second).bytes() : 0);
}

namespace {

/// Which of a brick's 512 voxels hold light: bit x of row y + 8 z.
std::array<std::uint8_t, 64> litRows(const VolumeData& data, std::size_t first) {
    std::array<std::uint8_t, 64> rows{};
    for (std::size_t v = 0; v < VolumeData::kVoxels; ++v) {
        bool lit = std::bit_cast<std::uint64_t>(data.light[first + v]) != 0;
        if (data.coloured) lit = lit || data.rgb[first + v] != std::array<Half, 3>{};
        rows[v >> 3] = static_cast<std::uint8_t>(rows[v >> 3] | (lit ? 1U : 0U) << (v & 7));
    }
    return rows;
}

void findLitVoxels(VolumeData& data) {
    data.lit_min = {kLargestIndex, kLargestIndex, kLargestIndex};
    data.lit_max = {-kLargestIndex, -kLargestIndex, -kLargestIndex};
    data.lit_voxels = 0;
    const auto include = [&](std::size_t axis, int low, int high) {
        data.lit_min[axis] = std::min(data.lit_min[axis], low);
        data.lit_max[axis] = std::max(data.lit_max[axis], high);
    };
    std::size_t page = 0;
    for (int pz = 0; pz < data.brick_count[2]; ++pz) {
        for (int py = 0; py < data.brick_count[1]; ++py) {
            for (int px = 0; px < data.brick_count[0]; ++px, ++page) {
                const std::size_t first = std::size_t{data.pages[page]} * VolumeData::kVoxels;
                if (first == 0) continue;
                const Int3 corner = {8 * (data.brick_min[0] + px), 8 * (data.brick_min[1] + py),
                                     8 * (data.brick_min[2] + pz)};
                unsigned columns = 0;  // bit x: any voxel there
                int row = 0;
                for (const unsigned bits : litRows(data, first)) {
                    if (bits != 0) {
                        data.lit_voxels += static_cast<std::uint64_t>(std::popcount(bits));
                        columns |= bits;
                        include(1, corner[1] + (row & 7), corner[1] + (row & 7));
                        include(2, corner[2] + (row >> 3), corner[2] + (row >> 3));
                    }
                    ++row;
                }
                if (columns != 0) {
                    include(0, corner[0] + std::countr_zero(columns),
                            corner[0] + static_cast<int>(std::bit_width(columns)) - 1);
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

/// Where the file does not say how high the water stands: the highest point of the lit voxels.
void findSurface(VolumeData& data) {
    double* surface = data.metadata.surface;
    if (!std::isinf(surface[3]) || data.lit_voxels == 0) return;
    double highest = -std::numeric_limits<double>::infinity();
    for (int corner = 0; corner < 8; ++corner) {
        Double3 index;
        for (std::size_t a = 0; a < 3; ++a)
            index[a] = (corner >> a & 1) != 0 ? data.lit_max[a] + 0.5 : data.lit_min[a] - 0.5;
        const Double3 offset = multiply(data.transform.world_from_index, index);
        double height = 0;
        for (std::size_t a = 0; a < 3; ++a) height += surface[a] * (data.transform.origin_world[a] + offset[a]);
        highest = std::max(highest, height);
    }
    surface[3] = highest;
}

}  // namespace

void finishTransform(VoxelTransform& transform, const std::string& what) {
    const Matrix3& m = transform.world_from_index;
    // Far below these bounds products overflow or vanish in float; no scene in metres is near them.
    constexpr double kLargest = 1e9, kSmallestVolume = 1e-27;
    const auto sensible = [](double v) { return std::fabs(v) < kLargest; };
    const double determinant =
        m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
    if (!std::all_of(m.begin(), m.end(), sensible) ||
        !std::all_of(transform.origin_world.begin(), transform.origin_world.end(), sensible) ||
        !(std::fabs(determinant) > kSmallestVolume)) {
        fail(ErrorCode::Format, what + ": the transform is not finite, has no inverse, or has voxels below 1e-9 m");
    }
    transform.index_from_world = {(m[4] * m[8] - m[5] * m[7]) / determinant, (m[2] * m[7] - m[1] * m[8]) / determinant,
                                  (m[1] * m[5] - m[2] * m[4]) / determinant, (m[5] * m[6] - m[3] * m[8]) / determinant,
                                  (m[0] * m[8] - m[2] * m[6]) / determinant, (m[2] * m[3] - m[0] * m[5]) / determinant,
                                  (m[3] * m[7] - m[4] * m[6]) / determinant, (m[1] * m[6] - m[0] * m[7]) / determinant,
                                  (m[0] * m[4] - m[1] * m[3]) / determinant};
}

void finishVolume(VolumeData& data) {
    findLitVoxels(data);
    data.period = {0, 0, 0};
    const Vec3& p = data.metadata.period;
    if (p.x != 0) addPeriod(data, {p.x, 0, 0});
    if (p.y != 0) addPeriod(data, {0, p.y, 0});
    if (p.z != 0) addPeriod(data, {0, 0, p.z});
    findSurface(data);
    data.coarse = CoarseBlocks::of(data.metadata.coarse_blocks);
    // Light that repeats is cut where a period begins: a block across that place would read what is not there.
    for (std::size_t a = 0; a < 3; ++a) {
        if (data.period[a] != 0) data.coarse.keepWithin(a, data.lit_min[a], data.lit_min[a] + data.period[a]);
    }
}

}  // namespace photic::runtime
