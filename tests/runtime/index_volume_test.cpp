// SPDX-License-Identifier: Apache-2.0
// Files of index volumes: what the baker writes is what is read and looked up; damaged ones are refused, or harmless.
#include "photic/index_volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/matrix.hpp>
#include <memory>
#include <random>

#include "bake/file/index_volume_file.h"
#include "bake/graded/spline_index.h"
#include "runtime/format/index_volume_format.h"
#include "runtime/src/half_float.h"

namespace photic::runtime {
namespace {

/// n^2 / 2 of a smooth blob, by place in nodes.
double blob(const glm::dvec3& p) { return 0.5 + 0.4 * std::exp(-glm::dot(p - 6.0, p - 6.0) / 14); }

IndexVolumeObject leaningObject() {
    IndexVolumeObject object;
    object.name = "leaning";
    object.count = {13, 12, 14};
    object.world_from_node = {{0.1, 0.01, 0}, {-0.02, 0.11, 0.03}, {0, 0.02, 0.09}};
    object.origin_world = {3, -2, 1};
    const SplineIndex spline({glm::dvec3(0), glm::dvec3(1), object.count}, blob, SplineFit::Through);
    std::vector<float> coefficients;
    for (int i = 0; i < 13 * 12 * 14; ++i) coefficients.push_back(spline.coefficients()[i] - 0.5F);
    object.spline = {coefficients};
    object.box_low = glm::vec3(1), object.box_high = {11, 10, 12};
    object.scattering = {0.5, 1, 2};
    object.anisotropy = 0.75;
    for (int i = 0; i < 13 * 12 * 14; ++i) {
        object.attenuation.emplace_back(i % 5, i % 7, i % 3, 0.25F * float(i % 5));
        object.glow.emplace_back(i % 4, 0, 1, 0.5);
        object.faces.push_back(i % 2 ? 255 : 0);
    }
    return object;
}

std::string fileOf(const std::vector<IndexVolumeObject>& objects) { return indexVolumeBytes(objects); }

Result<std::vector<IndexVolume>> readCopy(const std::string& bytes, std::size_t size) {
    // A block of just this size, so that a sanitizer sees the first byte beyond.
    const std::unique_ptr<char[]> copy(new char[size]);
    std::copy_n(bytes.begin(), size, copy.get());
    LoadOptions modest;
    modest.largest_memory = 1 << 22;
    return readIndexVolumes(copy.get(), size, modest);
}

TEST(IndexVolumes, AreReadAsTheyWereWritten) {
    const IndexVolumeObject object = leaningObject();
    const std::string bytes = fileOf({object, object});
    const auto volumes = readIndexVolumes(bytes.data(), bytes.size());
    ASSERT_TRUE(volumes.ok()) << volumes.error().message;
    ASSERT_EQ(volumes->size(), 2U);
    const IndexVolume& volume = (*volumes)[1];
    EXPECT_EQ(volume.name(), "leaning");
    EXPECT_EQ(volume.nodes(), (std::array<int, 3>{13, 12, 14}));
    EXPECT_TRUE(volume.attenuates() && volume.shines());
    EXPECT_FALSE(volume.disperses() || volume.sharpSides());
    const Vec3 node = volume.node(2, 3, 4);
    EXPECT_NEAR(node.x, 3 + 0.2 - 0.06, 1e-12);
    EXPECT_NEAR(node.z, 1 + 0.09 + 0.36, 1e-12);
    const auto here = volume.attenuation(node);
    const int i = (4 * 12 + 3) * 13 + 2;
    EXPECT_NEAR(here.absorption.y, i % 7, 1e-9);
    EXPECT_NEAR(here.scattering.z, 2 * 0.25 * (i % 5), 1e-9);
    EXPECT_NEAR(here.emission.x, i % 4, 1e-9);
    EXPECT_NEAR(here.anisotropy, 0.5, 1e-9);
    EXPECT_EQ(here.face, i % 2 == 1);
}

TEST(IndexVolumes, LookUpsAreTheBakersSplineWithItsOwnGradient) {
    const IndexVolumeObject object = leaningObject();
    const std::string bytes = fileOf({object});
    const auto volumes = readIndexVolumes(bytes.data(), bytes.size());
    ASSERT_TRUE(volumes.ok());
    const IndexVolume& volume = volumes->front();
    const SplineIndex spline({glm::dvec3(0), glm::dvec3(1), object.count}, blob, SplineFit::Through);
    const glm::dmat3 covector = glm::transpose(glm::inverse(object.world_from_node));
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(1, 10);
    for (int i = 0; i < 500; ++i) {
        const glm::dvec3 at(place(random), place(random), place(random));
        const Vec3 world = volume.node(at.x, at.y, at.z);
        const Refraction here = volume.at(world);
        const IndexSample truth = spline.at(at);
        const glm::dvec3 gradient = covector * truth.gradient;
        // The file's coefficients are those less 1/2, rounded once more.
        EXPECT_NEAR(here.half_square, truth.half_square, 1e-7);
        EXPECT_NEAR(here.gradient.x, gradient.x, 3e-6);
        EXPECT_NEAR(here.gradient.y, gradient.y, 3e-6);
        EXPECT_NEAR(here.gradient.z, gradient.z, 3e-6);
        // And the gradient is that of the values.
        constexpr double kStep = 1e-6;
        const double slope = (volume.at({world.x + kStep, world.y, world.z}).half_square -
                              volume.at({world.x - kStep, world.y, world.z}).half_square) /
                             (2 * kStep);
        EXPECT_NEAR(here.gradient.x, slope, 1e-6);
    }
    EXPECT_EQ(volume.at({100, 0, 0}).half_square, 0.5);
    EXPECT_EQ(volume.at({std::nan(""), 0, 0}).half_square, 0.5);
    EXPECT_EQ(IndexVolume().at({0, 0, 0}).half_square, 0.5);
}

TEST(IndexVolumes, ChannelsAreApart) {
    IndexVolumeObject object = leaningObject();
    object.spline.push_back(object.spline[0]);
    object.spline.push_back(object.spline[0]);
    for (float& e : object.spline[1]) e *= 2;
    const std::string bytes = fileOf({object});
    const auto volumes = readIndexVolumes(bytes.data(), bytes.size());
    ASSERT_TRUE(volumes.ok());
    EXPECT_TRUE(volumes->front().disperses());
    const Vec3 world = volumes->front().node(6, 6, 6);
    EXPECT_NEAR(volumes->front().at(world, 1).half_square - 0.5, 2 * (volumes->front().at(world, 0).half_square - 0.5),
                1e-9);
    EXPECT_EQ(volumes->front().at(world, 2).half_square, volumes->front().at(world, 0).half_square);
}

/// With faces that reflect: a file of version 2.
IndexVolumeObject coatedObject() {
    IndexVolumeObject object = leaningObject();
    object.albedo = {0.25, 0.5, 1}, object.roughness = 0.75;
    for (int i = 0; i < 13 * 12 * 14; ++i) object.coat.emplace_back((i % 6) / 5.0f, 0, 1);
    return object;
}

TEST(IndexVolumes, KnowHowFacesReflect) {
    IndexVolumeObject plain = leaningObject();
    EXPECT_EQ(fileOf({plain})[8], 1) << "readers of the first version know all that is in it";
    plain.albedo = {0.25, 0.5, 1};
    const std::string bytes = fileOf({coatedObject(), plain, leaningObject()});
    EXPECT_EQ(bytes[8], 2);
    const auto volumes = readIndexVolumes(bytes.data(), bytes.size());
    ASSERT_TRUE(volumes.ok()) << volumes.error().message;
    EXPECT_TRUE((*volumes)[0].reflects() && (*volumes)[1].reflects());
    EXPECT_FALSE((*volumes)[2].reflects());
    // Between two nodes in x, whose reds are 2/5 and 3/5.
    const int i = (4 * 12 + 3) * 13 + 2;
    ASSERT_EQ(i % 6, 5);
    const FaceReflection coated = (*volumes)[0].faceReflection((*volumes)[0].node(3.5, 3, 4));
    EXPECT_NEAR(coated.albedo.x, 0.1, 1e-3);
    EXPECT_NEAR(coated.albedo.z, 1, 1e-9);
    EXPECT_NEAR(coated.roughness, 0.75, 1e-9);
    const FaceReflection even = (*volumes)[1].faceReflection((*volumes)[1].node(5, 5, 5));
    EXPECT_NEAR(even.albedo.y, 0.5, 1e-9);
    EXPECT_EQ(even.roughness, 0);
    EXPECT_EQ((*volumes)[1].faceReflection({1000, 0, 0}).albedo.y, 0);
    // And the rest is as it was.
    EXPECT_NEAR((*volumes)[0].attenuation((*volumes)[0].node(2, 3, 4)).absorption.y, i % 7, 1e-9);
}

TEST(IndexVolumes, EveryTruncatedLengthIsRefused) {
    for (IndexVolumeObject object : {leaningObject(), coatedObject()}) {
        object.glow.clear();
        const std::string bytes = fileOf({object});
        ASSERT_TRUE(readCopy(bytes, bytes.size()).ok());
        for (std::size_t size = 0; size < bytes.size(); size += size < 2000 ? 1 : 37) {
            const auto volumes = readCopy(bytes, size);
            ASSERT_FALSE(volumes.ok()) << size;
            ASSERT_EQ(volumes.error().code, ErrorCode::Format) << volumes.error().message;
        }
    }
}

TEST(IndexVolumes, MutationsDoNoHarm) {
    const std::string first = fileOf({leaningObject()}), second = fileOf({coatedObject()});
    std::mt19937_64 random(11);
    int loaded = 0, refused = 0;
    for (int n = 0; n < 3000; ++n) {
        const std::string& file = n % 2 ? first : second;
        std::string damaged = file;
        for (std::uint64_t k = 0; k < 1 + random() % 3; ++k) {
            const std::size_t at = random() % 3 ? random() % 352 : random() % file.size();
            static constexpr std::uint64_t kNasty[] = {0, 1, 0x80, 0xffffffff, 0x7f800000, ~0ULL, 1ULL << 63, 4096};
            const std::uint64_t value = random() % 2 ? random() : kNasty[random() % std::size(kNasty)];
            std::memcpy(damaged.data() + at, &value, std::min<std::size_t>(1U << random() % 4, file.size() - at));
        }
        const auto volumes = readCopy(damaged, damaged.size());
        if (!volumes) {
            ++refused;
            EXPECT_FALSE(volumes.error().message.empty());
            continue;
        }
        ++loaded;
        for (const IndexVolume& volume : *volumes) {
            const auto count = volume.nodes();
            for (const double t : {-0.1, 0.0, 0.3, 0.77, 1.0, 1.1}) {
                const Refraction here = volume.at(volume.node(t * count[0], t * count[1], t * count[2]));
                EXPECT_TRUE(std::isfinite(here.half_square) && here.half_square > 0);
                const double albedo =
                    volume.faceReflection(volume.node(t * count[0], t * count[1], t * count[2])).albedo.x;
                EXPECT_TRUE(albedo >= 0 && albedo <= 1);
                EXPECT_GE(volume.attenuation(volume.node(t * count[0], t * count[1], t * count[2])).absorption.x, 0);
            }
        }
    }
    EXPECT_GT(loaded, 100);
    EXPECT_GT(refused, 100);
}

struct Damage {
    const char *name, *word;
    void (*apply)(std::string&);
    bool coated = false;
};
template <class T>
void put(std::string& bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof(T));
}
constexpr std::size_t kObject = format::kIndexFileHeader;

class IndexDamages : public testing::TestWithParam<Damage> {};

TEST_P(IndexDamages, IsRefusedInWords) {
    std::string file = fileOf({GetParam().coated ? coatedObject() : leaningObject()});
    GetParam().apply(file);
    const auto volumes = readCopy(file, file.size());
    ASSERT_FALSE(volumes.ok());
    EXPECT_NE(volumes.error().message.find(GetParam().word), std::string::npos) << volumes.error().message;
}

INSTANTIATE_TEST_SUITE_P(
    All, IndexDamages,
    testing::Values(
        Damage{"magic", "no file of index volumes", [](std::string& f) { f[0] = 'X'; }},
        Damage{"version", "only 1 to 3 are read", [](std::string& f) { put<std::uint32_t>(f, 8, 4); }},
        Damage{"version_0", "only 1 to 3 are read", [](std::string& f) { put<std::uint32_t>(f, 8, 0); }},
        Damage{"albedo", "albedo", [](std::string& f) { put<float>(f, kObject + 260, 1.5F); }, true},
        Damage{"roughness", "roughness", [](std::string& f) { put<float>(f, kObject + 268, std::nanf("")); }, true},
        Damage{"coat", "its coat", [](std::string& f) { put<std::uint64_t>(f, kObject + 272, 1ULL << 60); }, true},
        Damage{"size", "cut short", [](std::string& f) { f.push_back('x'); }},
        Damage{"objects", "objects", [](std::string& f) { put<std::uint32_t>(f, 12, 0); }},
        Damage{"name", "no end", [](std::string& f) { std::memset(f.data() + kObject, 'a', 64); }},
        Damage{"transform", "not finite", [](std::string& f) { put<double>(f, kObject + 64, std::nan("")); }},
        Damage{"flat", "no inverse",
               [](std::string& f) {
                   for (std::size_t i = 0; i < 4; ++i) put<double>(f, kObject + 64 + 8 * i, 0);
               }},
        Damage{"nodes", "nodes along", [](std::string& f) { put<std::uint32_t>(f, kObject + 160, 3); }},
        Damage{"channels", "channels", [](std::string& f) { put<std::uint32_t>(f, kObject + 172, 2); }},
        Damage{"flags", "later version", [](std::string& f) { put<std::uint32_t>(f, kObject + 176, 2); }},
        Damage{"anisotropy", "anisotropy", [](std::string& f) { put<float>(f, kObject + 192, 1); }},
        Damage{"alignment", "multiple of 16", [](std::string& f) { put<std::uint64_t>(f, kObject + 200, 8); }},
        Damage{"offset", "does not fit", [](std::string& f) { put<std::uint64_t>(f, kObject + 200, 1ULL << 60); }},
        Damage{"none", "no spline", [](std::string& f) { put<std::uint64_t>(f, kObject + 200, 0); }},
        Damage{"box", "empty", [](std::string& f) { put<float>(f, kObject + 232, 11); }},
        Damage{"index", "no index", [](std::string& f) { put<float>(f, kObject + 256 + 400, -3); }}),
    [](const auto& param_info) { return std::string(param_info.param.name); });

TEST(IndexVolumes, MemoryIsBounded) {
    const std::string file = fileOf({leaningObject()});
    LoadOptions small;
    small.largest_memory = 4000;
    const auto volumes = readIndexVolumes(file.data(), file.size(), small);
    ASSERT_FALSE(volumes.ok());
    EXPECT_EQ(volumes.error().code, ErrorCode::Limit);
    EXPECT_EQ(loadIndexVolumes("/nowhere/at_all.ivol").error().code, ErrorCode::File);
}

}  // namespace
}  // namespace photic::runtime
