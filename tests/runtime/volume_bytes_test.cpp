// SPDX-License-Identifier: Apache-2.0
// The bytes that games upload themselves, read back as docs/volume_bytes.md says and by nothing else.
#include "photic/volume_bytes.h"

#include <gtest/gtest.h>

#include <algorithm>
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
        if (entryIsWide(cell)) {
            for (std::size_t a = 0; a < 3; ++a) fraction[a] = ((cell[a] & 1) + fraction[a]) / 2;
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
    std::uint32_t entryOf(const int (&cell)[3]) const {
        const auto page = [&](int a) { return static_cast<std::size_t>(cell[a] >> 3); };
        std::uint32_t entry;
        std::memcpy(&entry,
                    b_.pages.texels.data() + 4 * ((page(2) * b_.pages.size[1] + page(1)) * b_.pages.size[0] + page(0)),
                    4);
        return entry;
    }
    bool entryIsWide(const int (&cell)[3]) const {
        const std::uint32_t entry = p_.whole(76) == 2 ? 0 : entryOf(cell);
        return (entry & 0xffffff) != 0 && entry >> 24 == 1;
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
        const std::uint32_t entry = entryOf(cell);
        const bool wide = entryIsWide(cell);
        const int shift = wide ? 1 : 0, mask = wide ? 15 : 7;
        if (!b_.bricks.empty()) {
            const std::size_t v = (entry & 0xffffff) * std::size_t{729} +
                                  static_cast<std::size_t>(((cell[0] & mask) >> shift) + step[0] +
                                                           9 * (((cell[1] & mask) >> shift) + step[1]) +
                                                           81 * (((cell[2] & mask) >> shift) + step[2]));
            return half(b_.bricks.data() + v * (coloured ? 16 : 8) + (c < 4 ? 0 : 8) + 2 * component);
        }
        const int at[3] = {static_cast<int>(entry & 255) * 9 + ((cell[0] & mask) >> shift) + step[0],
                           static_cast<int>(entry >> 8 & 255) * 9 + ((cell[1] & mask) >> shift) + step[1],
                           static_cast<int>(entry >> 16 & 255) * 9 + ((cell[2] & mask) >> shift) + step[2]};
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

// Smooth blocks in bricks of every second voxel: the same light, from a fraction of the bytes.
TEST(VolumeBytes, TwoLevelsReadBackAsThePageSays) {
    NvdbSpec spec;
    spec.min = {-37, -3, 5};
    spec.max = {50, 50, 70};
    spec.values = test::swirl;
    for (const bool coloured : {false, true}) {
        spec.coloured = coloured;
        const NvdbSpec two = test::twoLevels(spec, [](int x, int y, int z) { return (x + y + z) % 3 != 0; });
        const Volume volume = test::loaded(two);
        for (const Layout layout : {Layout::Automatic, Layout::Atlas, Layout::Buffer}) {
            UploadOptions options;
            options.layout = layout;
            const auto bytes = packVolume(volume, options);
            ASSERT_TRUE(bytes.ok()) << bytes.error().message;
            EXPECT_EQ(bytes->info.layout, layout == Layout::Buffer ? Layout::Buffer : Layout::Atlas);
            EXPECT_GT(bytes->info.coarse_bricks, 10u);
            if (options.layout == Layout::Automatic) options.layout = Layout::Atlas;
            EXPECT_EQ(bytes->info.bricks + 7 * bytes->info.coarse_bricks,
                      packVolume(test::loaded(spec), options)->info.bricks);
            const Reader reader(*bytes);
            std::mt19937 random(8);
            for (int n = 0; n < 4000; ++n) {
                const auto in = [&](double low, double high) {
                    return std::uniform_real_distribution(low, high)(random);
                };
                const Vec3 at = {in(-40, 53), in(-6, 53), in(2, 73)};
                const auto got = reader.at(at);
                const Light light = volume.sample(at);
                // Halves round what lies between wide voxels: 2^-11 of 20.
                ASSERT_NEAR(got[0], light.flux.x, 0.015) << n;
                ASSERT_NEAR(got[4], light.irradiance.x, 0.015) << n;
                ASSERT_NEAR(got[6], light.irradiance.z, 0.015) << n;
            }
        }
    }
    // The check sees light that is not what its blocks say.
    NvdbSpec lie = test::twoLevels(spec, [](int, int, int) { return true; });
    lie.values = test::swirl;
    const Volume volume = test::loaded(lie);
    const auto bytes = packVolume(volume);
    ASSERT_TRUE(bytes.ok());
    double worst = 0;
    for (int n = 0; n < 100; ++n) {
        const Vec3 at = {0.37 * n, 11.3, 20.7};
        worst = std::max(worst, std::fabs(Reader(*bytes).at(at)[4] - volume.sample(at).irradiance.x));
    }
    EXPECT_GT(worst, 1);
}

TEST(VolumeBytes, BlocksThatAreNoneAreRefused) {
    NvdbSpec spec;
    spec.values = test::swirl;
    for (const char* text : {"0,0,0,1,1,1", "0,0,0,1,1,1:", "0,0,0,0,1,1:f", "0,0,0,9,9,9:f", "0,0,0,1,1,1:x",
                             "999999999,0,0,1,1,1:f", "0,0,0,99999999,99999999,99999999:f", "light"}) {
        spec.json = std::string("{\"coarse_blocks\": \"") + text + "\"}";
        const auto bytes = test::makeNvdb(spec);
        const auto read = readVolume(bytes.data(), bytes.size());
        ASSERT_FALSE(read.ok()) << text;
        EXPECT_EQ(read.error().code, ErrorCode::Format);
        EXPECT_NE(read.error().message.find("coarse_blocks"), std::string::npos);
    }
    spec.json = "{\"coarse_blocks\": \"0,0,0,1,1,1:1\"}";
    EXPECT_EQ(packVolume(test::loaded(spec))->info.coarse_bricks, 1u);
}

// Where light repeats, the far side of the last block is the first one's near side, whichever of the two is wide.
TEST(VolumeBytes, TwoLevelsOfLightThatRepeats) {
    NvdbSpec spec;
    spec.min = {-32, 16, 5};
    spec.max = {31, 63, 60};
    spec.values = test::swirl;
    spec.world_from_index = {0.5, 0, 0, 0, 0.25, 0, 0, 0, 0.125};
    for (const bool coloured : {false, true}) {
        spec.coloured = coloured;
        NvdbSpec two =
            test::twoLevels(spec, [](int x, int y, int z) { return (x + 2 * y + z) % 3 != 0; }, {true, true, false});
        two.json.insert(two.json.size() - 1, ", \"period\": [32, 12, 0]");
        const Volume volume = test::loaded(two);
        for (const Layout layout : {Layout::Atlas, Layout::Buffer}) {
            UploadOptions options;
            options.layout = layout;
            const auto bytes = packVolume(volume, options);
            ASSERT_TRUE(bytes.ok()) << bytes.error().message;
            EXPECT_GT(bytes->info.coarse_bricks, 10U);
            const Reader reader(*bytes);
            std::mt19937 random(9);
            for (int n = 0; n < 6000; ++n) {
                const auto in = [&](double low, double high) {
                    return std::uniform_real_distribution(low, high)(random);
                };
                // Every third is at a seam, along x, y or both.
                Vec3 at = {in(-50, 50), in(-10, 30), in(0.5, 8)};
                if (n % 3 == 0) at.x = in(-16.6, -15.9) + 32 * (n % 4);
                if (n % 9 == 0) at.y = in(3.7, 4.1) + 12 * (n % 2);
                const auto got = reader.at(at);
                const Light light = volume.sample(at), again = volume.sample({at.x + 64, at.y - 12, at.z});
                ASSERT_NEAR(got[0], light.flux.x, 0.015) << n;
                ASSERT_NEAR(got[4], light.irradiance.x, 0.015) << n;
                ASSERT_NEAR(got[6], light.irradiance.z, 0.015) << n;
                ASSERT_NEAR(again.irradiance.x, light.irradiance.x, 1e-6) << n;
            }
        }
    }
    // Blocks across the place where a period begins are not taken for wide, whatever a file says.
    spec.min = {-30, 16, 5}, spec.max = {33, 63, 60};
    spec.json = R"({"period": [32, 12, 0], "coarse_blocks": "-2,1,1,5,3,2:fffffff3"})";
    const auto bytes = packVolume(test::loaded(spec));
    ASSERT_TRUE(bytes.ok());
    EXPECT_EQ(bytes->info.coarse_bricks, 3U * 3 * 2);
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
