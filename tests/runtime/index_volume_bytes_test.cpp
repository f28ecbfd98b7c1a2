// SPDX-License-Identifier: Apache-2.0
// The bytes of index volumes that games upload themselves, read back as docs/index_volumes.md says and by nothing else.
#include "photic/index_volume_bytes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "bake/file/index_volume_file.h"
#include "bake/graded/spline_index.h"
#include "runtime/src/half_float.h"

namespace photic::runtime {
namespace {

/// An object that disperses, absorbs, glows and is matte, all differing from node to node, on a leaning grid; in one
/// corner all is even.
IndexVolumeObject object(const glm::ivec3& count, int channels, bool dressed) {
    IndexVolumeObject out;
    out.name = "object";
    out.count = count;
    out.world_from_node = {{0.1, 0.01, 0}, {-0.02, 0.11, 0.03}, {0, 0.02, 0.09}};
    out.origin_world = {3, -2, 1};
    out.box_low = glm::vec3(1), out.box_high = glm::vec3(count) - 2.0F;
    const auto even = [&](int x, int y, int z) { return x < 12 && y < 12 && z < 12; };
    for (int c = 0; c < channels; ++c) {
        std::vector<float> spline;
        for (int z = 0; z < count.z; ++z)
            for (int y = 0; y < count.y; ++y)
                for (int x = 0; x < count.x; ++x)
                    spline.push_back(
                        even(x, y, z) ? 0.0F : 0.3F + 0.01F * static_cast<float>((7 * x + 5 * y + 3 * z + c) % 11));
        out.spline.push_back(spline);
    }
    if (!dressed) return out;
    out.scattering = {0.5, 1, 2};
    out.roughness = 0.5;
    for (int z = 0; z < count.z; ++z)
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x) {
                const bool dark = even(x, y, z);
                const auto i = static_cast<float>((x + 2 * y + 3 * z) % 5);
                out.attenuation.push_back(dark ? glm::vec4(0) : glm::vec4(i, 2 * i, 1, 0.2F * i));
                out.glow.push_back(dark ? glm::vec4(0) : glm::vec4(i, 0, 1, 0.5F));
                out.faces.push_back(x == 14 ? 255 : 0);
                out.coat.emplace_back(0.2F * i, 0.5F, 1.0F);
            }
    return out;
}

/// A look-up in the bytes, as the page has it.
class Reader {
public:
    Reader(const IndexVolumeBytes& bytes, const std::vector<unsigned char>& block) : b_(bytes), p_(block.data()) {}

    template <class T>
    T get(std::size_t at) const {
        T value;
        std::memcpy(&value, p_ + at, sizeof(T));
        return value;
    }
    std::size_t objectAt(int object) const { return 208 + 160 * static_cast<std::size_t>(object); }
    std::array<double, 3> node(int object, const Vec3& world) const {
        const double place[3] = {world.x - get<float>(0), world.y - get<float>(4), world.z - get<float>(8)};
        std::array<double, 3> out{};
        for (std::size_t row = 0; row < 3; ++row) {
            out[row] = get<float>(objectAt(object) + 16 * row + 12);
            for (std::size_t c = 0; c < 3; ++c) out[row] += get<float>(objectAt(object) + 16 * row + 4 * c) * place[c];
        }
        return out;
    }
    bool holds(int object, const std::array<double, 3>& n) const {
        for (std::size_t a = 0; a < 3; ++a)
            if (n[a] < get<float>(objectAt(object) + 48 + 4 * a) || n[a] > get<float>(objectAt(object) + 64 + 4 * a))
                return false;
        return true;
    }
    int whole(int object, std::size_t at) const { return get<std::int32_t>(objectAt(object) + at); }

    /// (n^2 - 1) / 2, by the spline.
    double excess(int object, const std::array<double, 3>& n, int channel) const {
        std::array<std::array<double, 4>, 3> w{};
        std::array<int, 3> cell{};
        for (std::size_t a = 0; a < 3; ++a) {
            cell[a] = static_cast<int>(std::floor(n[a]));
            const double t = n[a] - cell[a], u = 1 - t;
            w[a] = {u * u * u / 6, (4 - 6 * t * t + 3 * t * t * t) / 6, (4 - 6 * u * u + 3 * u * u * u) / 6,
                    t * t * t / 6};
        }
        double sum = 0;
        for (int k = 0; k < 64; ++k) {
            const std::array<int, 3> step{k % 4, k / 4 % 4, k / 16};
            std::size_t at[3];
            double weight = 1;
            for (std::size_t a = 0; a < 3; ++a) {
                const int corner = whole(object, 128 + 4 * a) + (a == 2 ? channel * whole(object, 140) : 0);
                at[a] = static_cast<std::size_t>(corner + cell[a] - 1 + step[a]);
                weight *= w[a][static_cast<std::size_t>(step[a])];
            }
            sum += weight * texel<float>(b_.spline, at, 4, 0);
        }
        return sum;
    }
    /// One component of a filtered texture.
    double filtered(const TextureBytes& texture, int object, const std::array<double, 3>& n, std::size_t c) const {
        double sum = 0;
        for (int k = 0; k < 8; ++k) {
            double weight = 1;
            std::size_t at[3];
            for (std::size_t a = 0; a < 3; ++a) {
                const int step = k >> a & 1;
                const double t = n[a] - std::floor(n[a]);
                weight *= step != 0 ? t : 1 - t;
                at[a] =
                    static_cast<std::size_t>(whole(object, 128 + 4 * a) + static_cast<int>(std::floor(n[a])) + step);
            }
            if (texture.format == TexelFormat::Rgba16Float)
                sum += weight * static_cast<double>(floatOfHalf(texel<Half>(texture, at, 8, 2 * c)));
            else
                sum +=
                    weight * texel<std::uint8_t>(texture, at, texture.format == TexelFormat::Rgba8 ? 4 : 1, c) / 255.0;
        }
        return sum;
    }
    int reach(int object, const std::array<int, 3>& block) const {
        std::size_t at[3];
        for (std::size_t a = 0; a < 3; ++a) at[a] = static_cast<std::size_t>(whole(object, 144 + 4 * a) + block[a]);
        return texel<std::uint8_t>(b_.blocks, at, 1, 0);
    }

private:
    template <class T>
    T texel(const TextureBytes& t, const std::size_t (&at)[3], std::size_t size, std::size_t offset) const {
        const std::size_t place = ((at[2] * t.size[1] + at[1]) * t.size[0] + at[0]) * size + offset;
        T value{};
        if (place + sizeof(T) > t.texels.size()) {
            ADD_FAILURE() << "beyond the texture's end";
            return value;
        }
        std::memcpy(&value, t.texels.data() + place, sizeof(T));
        return value;
    }
    const IndexVolumeBytes& b_;
    const unsigned char* p_;
};

std::vector<IndexVolume> volumesOf(const std::vector<IndexVolumeObject>& objects) {
    const std::string bytes = indexVolumeBytes(objects);
    auto read = readIndexVolumes(bytes.data(), bytes.size());
    EXPECT_TRUE(read.ok());
    return read.ok() ? *read : std::vector<IndexVolume>{};
}

TEST(IndexVolumeBytes, ReadBackAsThePageSays) {
    const auto volumes = volumesOf({object({18, 20, 23}, 1, false), object({17, 26, 19}, 3, true)});
    const auto bytes = packIndexVolumes(volumes);
    ASSERT_TRUE(bytes.ok()) << bytes.error().message;
    EXPECT_EQ(bytes->faces.format, TexelFormat::Rgba8);
    EXPECT_EQ(bytes->info.bytes, bytes->spline.texels.size() + bytes->gradients.texels.size() +
                                     bytes->attenuation.texels.size() + bytes->glow.texels.size() +
                                     bytes->faces.texels.size() + bytes->blocks.texels.size() +
                                     bytes->shapes.texels.size());
    const float origin[3] = {3.5F, -1.25F, 2};
    BentRayOptions options;
    options.step = 0.5F, options.steps = 77, options.branches = 3, options.skipping = BentSkipping::None;
    const auto block = packBentParameters(origin, *bytes, {{0}, {1}}, options);
    ASSERT_TRUE(block.ok()) << block.error().message;
    ASSERT_EQ(block->size(), 3024U);
    const Reader reader(*bytes, *block);
    EXPECT_EQ(reader.get<std::int32_t>(16), 2);
    EXPECT_EQ(reader.get<std::int32_t>(20), 77);
    EXPECT_EQ(reader.get<std::int32_t>(24), 3);
    EXPECT_EQ(reader.get<std::int32_t>(28), 0);
    EXPECT_EQ(reader.get<float>(32), 0.5F);
    for (std::size_t a = 0; a < 3; ++a)
        EXPECT_EQ(reader.get<float>(48 + 4 * a), 1.0F / static_cast<float>(bytes->gradients.size[a]));
    std::mt19937 random(5);
    for (int o = 0; o < 2; ++o) {
        const IndexVolume& volume = volumes[static_cast<std::size_t>(o)];
        const auto nodes = volume.nodes();
        int inside = 0;
        for (int n = 0; n < 3000; ++n) {
            std::array<double, 3> at{};
            for (std::size_t a = 0; a < 3; ++a) at[a] = std::uniform_real_distribution(0.0, nodes[a] - 1.0)(random);
            const Vec3 world = volume.node(at[0], at[1], at[2]);
            const auto node = reader.node(o, world);
            for (std::size_t a = 0; a < 3; ++a) ASSERT_NEAR(node[a], at[a], 1e-4);
            if (!reader.holds(o, node)) continue;
            ++inside;
            for (int c = 0; c < (o == 1 ? 3 : 1); ++c)
                ASSERT_NEAR(reader.excess(o, node, c), volume.at(world, c).half_square - 0.5, 1e-5);
            if (o == 0) continue;
            EXPECT_EQ(reader.whole(o, 124), 15);
            const Attenuation here = volume.attenuation(world);
            ASSERT_NEAR(reader.filtered(bytes->attenuation, o, node, 1), here.absorption.y, 2e-2);
            ASSERT_NEAR(
                reader.filtered(bytes->attenuation, o, node, 3) * reader.get<float>(reader.objectAt(o) + 80 + 8),
                here.scattering.z, 1e-2);
            ASSERT_NEAR(reader.filtered(bytes->glow, o, node, 0), here.emission.x, 1e-2);
            ASSERT_NEAR(reader.filtered(bytes->glow, o, node, 3), here.anisotropy, 1e-2);
            ASSERT_NEAR(reader.filtered(bytes->faces, o, node, 1), volume.faceReflection(world).albedo.x, 1e-2);
        }
        EXPECT_GT(inside, 1000);
        // Even blocks, and how far what is like them reaches; what changes has none.
        EXPECT_GE(reader.reach(o, {0, 0, 0}), 2);
        EXPECT_EQ(reader.reach(o, {6, 6, 6}), 0);
        EXPECT_EQ(reader.reach(o, {4, 4, 4}), 1);  // the last of which all is even: nodes 7 to 11 count
        EXPECT_EQ(reader.reach(o, {3, 4, 4}), 1);
        EXPECT_EQ(reader.reach(o, {3, 3, 3}), 2);
    }
    EXPECT_EQ(reader.get<float>(reader.objectAt(1) + 96 + 12), 0.25F);  // alpha is the roughness' square
    EXPECT_EQ(reader.whole(0, 156), 2);                                 // they stand in one place
}

TEST(IndexVolumeBytes, WithoutSenseAreRefused) {
    EXPECT_EQ(packIndexVolumes({}).error().code, ErrorCode::Usage);
    const auto volumes = volumesOf({object({18, 20, 23}, 1, false)});
    EXPECT_EQ(packIndexVolumes(volumes, 16).error().code, ErrorCode::Limit);
    const auto bytes = packIndexVolumes(volumes);
    ASSERT_TRUE(bytes.ok());
    EXPECT_EQ(bytes->glow.texels.size(), 8U);  // nothing glows
    EXPECT_EQ(bytes->faces.format, TexelFormat::R8);
    const float origin[3] = {0, 0, 0};
    EXPECT_EQ(packBentParameters(origin, *bytes, {{1}}).error().code, ErrorCode::Usage);
    EXPECT_EQ(packBentParameters(origin, *bytes, {}).error().code, ErrorCode::Usage);
    EXPECT_EQ(packBentParameters(origin, IndexVolumeBytes{}, {{0}}).error().code, ErrorCode::Usage);
    BentRayOptions options;
    options.step = 0;
    EXPECT_EQ(packBentParameters(origin, *bytes, {{0}}, options).error().code, ErrorCode::Usage);
}

}  // namespace
}  // namespace photic::runtime
