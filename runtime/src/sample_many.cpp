// SPDX-License-Identifier: Apache-2.0
// Look-ups by the thousand: positions are turned into places in memory first, all of which are fetched at once, and
// only then are the halves read and mixed, in float. One by one each look-up would wait for its memory. Processors that
// turn halves to floats by themselves (F16C) mix two voxels at a time; the numbers are the same bits without.
#include "runtime/src/sample_many.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#if defined(__GNUC__) && defined(__x86_64__)
#include <immintrin.h>
#define PHOTIC_F16C __attribute__((target("avx,f16c")))
#define PHOTIC_INLINE inline __attribute__((always_inline))
#else
#define PHOTIC_INLINE inline
#endif

namespace photic::runtime {
namespace {

/// So many are under way at once: their lines of memory fit the nearest cache.
constexpr std::size_t kBlock = 32;
constexpr double kFarthestIndex = 1e9;  // what floor() of still fits an int

using Float4 = std::array<float, 4>;

Float4 mixed(const Float4& a, const Float4& b, float part) {
    Float4 out;
    for (std::size_t c = 0; c < 4; ++c) out[c] = a[c] + part * (b[c] - a[c]);
    return out;
}

Float4 floats(const Half4& halves) {
    Float4 out;
    for (std::size_t c = 0; c < 4; ++c) out[c] = floatOfFiniteHalf(halves[c]);
    return out;
}

Float4 floats(const std::array<Half, 3>& halves) {
    return {floatOfFiniteHalf(halves[0]), floatOfFiniteHalf(halves[1]), floatOfFiniteHalf(halves[2]), 0};
}

void fetch(const void* address) {
#if defined(__GNUC__)
    __builtin_prefetch(address);
#else
    (void)address;
#endif
}

/// The eight voxels around a position, x fastest, and where it lies between them.
struct Place {
    std::array<std::size_t, 8> slots;
    std::array<float, 3> fraction;
};

PHOTIC_INLINE Place placeOf(const VolumeData& data, const Vec3& world) {
    Place place{};  // brick 0: darkness
    const Double3 index = data.transform.indexOf({world.x, world.y, world.z});
    Int3 low;
    for (std::size_t a = 0; a < 3; ++a) {
        if (!(std::fabs(index[a]) < kFarthestIndex)) return place;  // NaN too
        const double floor = std::floor(index[a]);
        low[a] = static_cast<int>(floor);
        place.fraction[a] = static_cast<float>(index[a] - floor);
    }
    const bool repeats = data.period != Int3{0, 0, 0};
    if (!repeats && (low[0] & 7) != 7 && (low[1] & 7) != 7 && (low[2] & 7) != 7) {
        // Two of three: all eight lie in one brick.
        const std::size_t first = data.slot(low[0], low[1], low[2]);
        for (std::size_t corner = 0; corner < 8; ++corner)
            place.slots[corner] = first + (corner & 1) + 8 * (corner >> 1 & 1) + 64 * (corner >> 2);
        return place;
    }
    for (int corner = 0; corner < 8; ++corner) {
        place.slots[static_cast<std::size_t>(corner)] =
            data.slot(low[0] + (corner & 1), low[1] + (corner >> 1 & 1), low[2] + (corner >> 2));
    }
    return place;
}

/// Mixes along z, then y, then x, as PortableMix and HalfMix both do, so that they give the same bits.
struct PortableMix {
    template <class Voxel>
    static Float4 of(const std::vector<Voxel>& voxels, const Place& place) {
        std::array<Float4, 4> columns;
        for (std::size_t c = 0; c < 4; ++c)
            columns[c] = mixed(floats(voxels[place.slots[c]]), floats(voxels[place.slots[c + 4]]), place.fraction[2]);
        return mixed(mixed(columns[0], columns[2], place.fraction[1]), mixed(columns[1], columns[3], place.fraction[1]),
                     place.fraction[0]);
    }
};

#ifdef PHOTIC_F16C
struct HalfMix {
    template <class Voxel>
    PHOTIC_F16C static Float4 of(const std::vector<Voxel>& voxels, const Place& place) {
        // The two voxels of a row in the halves of a register.
        __m256 rows[4];
        for (std::size_t r = 0; r < 4; ++r) {
            std::uint64_t pair[2] = {0, 0};
            std::memcpy(&pair[0], &voxels[place.slots[2 * r]], sizeof(Voxel));
            std::memcpy(&pair[1], &voxels[place.slots[2 * r + 1]], sizeof(Voxel));
            rows[r] = _mm256_cvtph_ps(_mm_set_epi64x(static_cast<long long>(pair[1]), static_cast<long long>(pair[0])));
        }
        const __m256 z = _mm256_set1_ps(place.fraction[2]), y = _mm256_set1_ps(place.fraction[1]);
        const __m256 low = _mm256_add_ps(rows[0], _mm256_mul_ps(z, _mm256_sub_ps(rows[2], rows[0])));
        const __m256 high = _mm256_add_ps(rows[1], _mm256_mul_ps(z, _mm256_sub_ps(rows[3], rows[1])));
        const __m256 both = _mm256_add_ps(low, _mm256_mul_ps(y, _mm256_sub_ps(high, low)));
        const __m128 first = _mm256_castps256_ps128(both), second = _mm256_extractf128_ps(both, 1);
        Float4 out;
        _mm_storeu_ps(out.data(),
                      _mm_add_ps(first, _mm_mul_ps(_mm_set1_ps(place.fraction[0]), _mm_sub_ps(second, first))));
        return out;
    }
};
#endif

/// Calls use(number, light, colour) for each position: flux.xyz and mean, then r, g, b, as they are stored.
template <class Mix, class Use>
PHOTIC_INLINE void sampleBlocksBy(const VolumeData& data, std::span<const Vec3> world, const Use& use) {
    std::array<Place, kBlock> places;
    for (std::size_t first = 0; first < world.size(); first += kBlock) {
        const std::size_t count = std::min(kBlock, world.size() - first);
        for (std::size_t i = 0; i < count; ++i) {
            places[i] = placeOf(data, world[first + i]);
            // Voxels that follow one another along x lie on one line of memory, as a rule.
            for (const std::size_t corner : {0, 2, 4, 6}) {
                fetch(&data.light[places[i].slots[corner]]);
                if (data.coloured) fetch(&data.rgb[places[i].slots[corner]]);
            }
        }
        for (std::size_t i = 0; i < count; ++i) {
            const Float4 light = Mix::of(data.light, places[i]);
            const Float4 colour =
                data.coloured ? Mix::of(data.rgb, places[i]) : Float4{light[3], light[3], light[3], 0};
            use(first + i, light, colour);
        }
    }
}

#ifdef PHOTIC_F16C
template <class Use>
PHOTIC_F16C void sampleBlocksByHalves(const VolumeData& data, std::span<const Vec3> world, const Use& use) {
    sampleBlocksBy<HalfMix>(data, world, use);
}
#endif

template <class Use>
void sampleBlocks(const VolumeData& data, std::span<const Vec3> world, HalfConversion conversion, const Use& use) {
#ifdef PHOTIC_F16C
    static const bool has_halves = __builtin_cpu_supports("avx") && __builtin_cpu_supports("f16c");
    if (has_halves && conversion == HalfConversion::WhereThereIs) return sampleBlocksByHalves(data, world, use);
#endif
    static_cast<void>(conversion);
    sampleBlocksBy<PortableMix>(data, world, use);
}

Vec3 scaled(const Float4& v, double by) {
    return {by * static_cast<double>(v[0]), by * static_cast<double>(v[1]), by * static_cast<double>(v[2])};
}

void addTo(Vec3& to, const Vec3& v) { to.x += v.x, to.y += v.y, to.z += v.z; }

}  // namespace

void sampleMany(const VolumeData& data, std::span<const Vec3> world, std::span<Light> light,
                HalfConversion conversion) {
    std::fill(light.begin(), light.end(), Light{});
    for (const VolumeData* lobe : {&data, data.second.get()}) {
        if (lobe == nullptr) continue;
        const double scale = lobe->metadata.reference_irradiance;
        sampleBlocks(*lobe, world, conversion, [&](std::size_t i, const Float4& flux, const Float4& colour) {
            addTo(light[i].flux, scaled(flux, scale));
            addTo(light[i].irradiance, scaled(colour, scale));
        });
    }
}

void Volume::sample(std::span<const Vec3> world, std::span<Light> light) const {
    const std::size_t count = std::min(world.size(), light.size());
    sampleMany(*data_, world.first(count), light.first(count), HalfConversion::WhereThereIs);
}

void Volume::irradiance(std::span<const Vec3> world, std::span<const Vec3> normals, std::span<Vec3> out) const {
    const std::size_t count = std::min({world.size(), normals.size(), out.size()});
    std::fill_n(out.begin(), count, Vec3{});
    for (const VolumeData* lobe : {data_.get(), data_->second.get()}) {
        if (lobe == nullptr) continue;
        const bool directed = lobe->has_direction;
        const auto use = [&](std::size_t i, const Float4& flux, const Float4& colour) {
            double factor = lobe->metadata.reference_irradiance;
            if (directed) factor *= towards(normals[i], {flux[0], flux[1], flux[2]}, static_cast<double>(flux[3]));
            addTo(out[i], scaled(colour, factor));
        };
        sampleBlocks(*lobe, world.first(count), HalfConversion::WhereThereIs, use);
    }
}

}  // namespace photic::runtime
