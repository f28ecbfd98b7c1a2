// SPDX-License-Identifier: Apache-2.0
// The bytes that games upload themselves, read back as docs/volume_bytes.md says and by nothing else.
#include "photic/volume_bytes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "runtime/src/half_float.h"
#include "tests/runtime/loaded_volume.h"

namespace photic::runtime {
namespace {

using test::NvdbSpec;

/// The uniform block, by the page's table.
struct Parameters {
    explicit Parameters(const VolumeBytes& b) : bytes(b.parameters.data()) {}
    float real(std::size_t at) const { return get<float>(at); }
    int whole(std::size_t at) const { return get<std::int32_t>(at); }
    template <class T>
    T get(std::size_t at) const {
        T value;
        std::memcpy(&value, bytes + at, sizeof(T));
        return value;
    }
    const unsigned char* bytes;
};

/// A look-up in the bytes, step by step as the page lists them.
class Reader {
public:
    explicit Reader(const VolumeBytes& bytes) : b_(bytes), p_(bytes) {}

    /// flux.xyz, mean, then r, g, b [W/m2].
    std::array<double, 7> at(const Vec3& world) const {
        std::array<double, 7> out{};
        const double d[3] = {world.x - p_.real(48), world.y - p_.real(52), world.z - p_.real(56)};
        int cell[3];
        double fraction[3];
        for (std::size_t a = 0; a < 3; ++a) {
            double local = p_.real(16 * a + 12);
            for (std::size_t c = 0; c < 3; ++c) local += p_.real(16 * a + 4 * c) * d[c];
            cell[a] = static_cast<int>(std::floor(local)) + p_.whole(64 + 4 * a);
            fraction[a] = local - std::floor(local);
            const int low = p_.whole(80 + 4 * a), high = p_.whole(96 + 4 * a), period = p_.whole(112 + 4 * a);
            if (period > 0) cell[a] = low + ((cell[a] - low) % period + period) % period;
            if (cell[a] < low || cell[a] > high) return out;
        }
        for (int corner = 0; corner < 8; ++corner) {
            double weight = 1;
            int step[3];
            for (int a = 0; a < 3; ++a) {
                step[a] = corner >> a & 1;
                weight *= step[a] ? fraction[a] : 1 - fraction[a];
            }
            for (std::size_t c = 0; c < 7; ++c) out[c] += weight * voxel(cell, step, c);
        }
        for (double& v : out) v *= p_.real(60);
        return out;
    }

private:
    static double half(const unsigned char* bytes) {
        Half h;
        std::memcpy(&h, bytes, 2);
        return static_cast<double>(floatOfHalf(h));
    }
    double texel(const TextureBytes& t, const int (&at)[3], std::size_t c) const {
        std::size_t place[3];
        for (std::size_t a = 0; a < 3; ++a) {
            const auto side = static_cast<int>(t.size[a]);
            place[a] = static_cast<std::size_t>(b_.sampler_repeats[a] ? at[a] % side : std::min(at[a], side - 1));
        }
        return half(t.texels.data() + 8 * ((place[2] * t.size[1] + place[1]) * t.size[0] + place[0]) + 2 * c);
    }
    double voxel(const int (&cell)[3], const int (&step)[3], std::size_t c) const {
        const bool coloured = p_.whole(92) != 0;
        if (c >= 4 && !coloured) return voxel(cell, step, 3);
        const std::size_t component = c < 4 ? c : c - 4;
        if (p_.whole(76) == 2) {
            int at[3];
            for (int a = 0; a < 3; ++a) at[a] = cell[a] + step[a] - p_.whole(128 + 4 * static_cast<std::size_t>(a));
            return texel(c < 4 ? b_.light : b_.colour, at, component);
        }
        const auto page = [&](int a) { return static_cast<std::size_t>(cell[a] >> 3); };
        std::uint32_t entry;
        std::memcpy(&entry,
                    b_.pages.texels.data() + 4 * ((page(2) * b_.pages.size[1] + page(1)) * b_.pages.size[0] + page(0)),
                    4);
        if (!b_.bricks.empty()) {
            const std::size_t v = (entry & 0xffffff) * std::size_t{729} +
                                  static_cast<std::size_t>((cell[0] & 7) + step[0] + 9 * ((cell[1] & 7) + step[1]) +
                                                           81 * ((cell[2] & 7) + step[2]));
            return half(b_.bricks.data() + v * (coloured ? 16 : 8) + (c < 4 ? 0 : 8) + 2 * component);
        }
        const int at[3] = {static_cast<int>(entry & 255) * 9 + (cell[0] & 7) + step[0],
                           static_cast<int>(entry >> 8 & 255) * 9 + (cell[1] & 7) + step[1],
                           static_cast<int>(entry >> 16 & 255) * 9 + (cell[2] & 7) + step[2]};
        return texel(c < 4 ? b_.light : b_.colour, at, component);
    }

    const VolumeBytes& b_;
    Parameters p_;
};

TEST(VolumeBytes, ReadBackAsThePageSays) {
    NvdbSpec spec;
    spec.min = {-5, 3, -11};
    spec.max = {20, 17, 9};
    spec.values = test::swirl;
    spec.active = [](int i, int j, int) { return (i / 9 + j / 5) % 2 == 0; };
    spec.world_from_index = {0.5, 0, 0.1, 0, 0.25, -0.05, 0, 0, 0.125};
    spec.origin_world = {10, -3, 0.5};
    std::mt19937 random(6);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const bool coloured : {false, true}) {
        spec.coloured = coloured;
        for (const char* json : {"{\"reference_irradiance\": 3}", "{\"period\": [13, 3.75, 0]}"}) {
            spec.json = json;
            spec.world_from_index[2] = json[2] == 'p' ? 0 : 0.1, spec.world_from_index[5] = json[2] == 'p' ? 0 : -0.05;
            const Volume volume = test::loaded(spec);
            for (const Layout layout : {Layout::Atlas, Layout::Dense, Layout::Buffer}) {
                UploadOptions options;
                options.layout = layout;
                const auto bytes = packVolume(volume, options);
                ASSERT_TRUE(bytes.ok()) << bytes.error().message;
                EXPECT_EQ(bytes->info.layout, layout);
                const Reader reader(*bytes);
                double brightest = 0;
                for (int n = 0; n < 3000; ++n) {
                    const Vec3 p = volume.voxelCentre(0, 0, 0);
                    const Vec3 at = {p.x - 4 + 18 * unit(random), p.y + 6 * unit(random), p.z - 2 + 4 * unit(random)};
                    const auto got = reader.at(at);
                    const Light light = volume.sample(at);
                    const double expected[7] = {light.flux.x,       light.flux.y,       light.flux.z,      0,
                                                light.irradiance.x, light.irradiance.y, light.irradiance.z};
                    for (std::size_t c = 0; c < 7; ++c) {
                        if (c == 3) continue;  // a mean has no place in Light
                        ASSERT_NEAR(got[c], expected[c], 2e-3) << "layout " << static_cast<int>(layout) << " at " << n;
                    }
                    brightest = std::max(brightest, got[3]);
                }
                EXPECT_GT(brightest, 5);
            }
        }
    }
}

TEST(VolumeBytes, LimitsAndBudgetsHold) {
    NvdbSpec spec;
    spec.max = {63, 63, 63};
    spec.values = test::swirl;
    const Volume volume = test::loaded(spec);
    UploadOptions options;
    options.largest_texture_3d = 40;
    const auto small = packVolume(volume, options);
    ASSERT_TRUE(small.ok());
    EXPECT_EQ(small->info.layout, Layout::Buffer);
    options.largest_storage_block = 1 << 20;
    const auto coarse = packVolume(volume, options);
    ASSERT_TRUE(coarse.ok());
    EXPECT_EQ(coarse->info.coarsened, 1);
    options.when_too_large = WhenTooLarge::Refuse;
    const auto refused = packVolume(volume, options);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::Limit);
    // What it says that a GPU needs is what there is.
    for (const Layout layout : {Layout::Atlas, Layout::Dense, Layout::Buffer}) {
        UploadOptions one;
        one.layout = layout;
        const auto bytes = packVolume(volume, one);
        ASSERT_TRUE(bytes.ok());
        EXPECT_EQ(bytes->info.bytes, bytes->light.texels.size() + bytes->colour.texels.size() +
                                         bytes->pages.texels.size() + bytes->bricks.size());
    }
    const auto dark = packVolume(Volume());
    ASSERT_TRUE(dark.ok());
    EXPECT_EQ(Reader(*dark).at({0, 0, 0})[3], 0);
}

}  // namespace
}  // namespace photic::runtime
