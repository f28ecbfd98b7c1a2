// SPDX-License-Identifier: Apache-2.0
#include "bake/file/l1_textures.h"

#include <Imath/half.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <vector>

#include "bake/file/output_set.h"
#include "tests/file/file_test_support.h"

namespace photic {
namespace {

/// Normals spread evenly over the sphere (Fibonacci's lattice).
std::vector<glm::dvec3> normals(int count) {
    std::vector<glm::dvec3> out;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2.0 * i + 1) / count, side = std::sqrt(1 - z * z), turn = 2.399963229728653 * i;
        out.emplace_back(side * std::cos(turn), side * std::sin(turn), z);
    }
    return out;
}

TEST(L1, IsTheLeastSquaresOfWhatFacesGetOfOneDirection) {
    const glm::dvec3 travel = glm::normalize(glm::dvec3(0.4, -0.2, -0.9));
    const double phi = 3;
    const L1Irradiance l1 = l1Irradiance(float(phi), glm::vec3(phi * travel));
    const auto all = normals(20000);
    double mean = 0, squares = 0;
    glm::dvec3 moment{0};
    for (const glm::dvec3& n : all) {
        const double exact = std::max(0.0, -glm::dot(n, phi * travel));
        const double approximate = l1.l0 + n.x * l1.l1[0] + n.y * l1.l1[1] + n.z * l1.l1[2];
        mean += exact - approximate, moment += (exact - approximate) * n, squares += std::pow(exact - approximate, 2);
    }
    const double count = double(all.size());
    // The residue has neither mean nor first moment: no other L0 and L1 are nearer. It is sqrt(1/48) of the light.
    EXPECT_NEAR(mean / count, 0, 1e-4 * phi);
    EXPECT_LT(glm::length(moment) / count, 1e-4 * phi);
    EXPECT_NEAR(std::sqrt(squares / count), phi / std::sqrt(48.0), 1e-3 * phi);
    // By hand: a face across the light gets three quarters, one along it a quarter.
    const auto at = [&](const glm::dvec3& n) { return l1.l0 + n.x * l1.l1[0] + n.y * l1.l1[1] + n.z * l1.l1[2]; };
    EXPECT_NEAR(at(-travel), 0.75 * phi, 1e-6);
    EXPECT_NEAR(at(glm::normalize(glm::cross(travel, glm::dvec3(1, 0, 0)))), 0.25 * phi, 1e-6);
}

TEST(L1, LightFromAllSidesIsExact) {
    // phi of light from everywhere lights each face to phi / 4.
    const L1Irradiance l1 = l1Irradiance(8, glm::vec3(0));
    EXPECT_EQ(l1.l0, 2);
    EXPECT_EQ(l1.l1, (std::array<float, 3>{0, 0, 0}));
}

TEST(L1, TexturesAreTurnedToUnitysAxes) {
    const TemporaryFolder folder;
    const glm::ivec3 lit(1, 2, 3);
    const GridFrame frame = straightFrame({0, 0, 0}, {3, 4, 5}, 0.1);
    const LightVolume volume = testVolume(frame, true, [&](const glm::ivec3& v) { return v == lit; });
    OutputSet outputs;
    const DenseWritten written =
        writeL1Textures(outputs, folder / "light.dds", volume, TextureFormat::Dds, VoxelBox{{0, 0, 0}, {3, 4, 5}});
    outputs.commit();
    ASSERT_EQ(written.files.size(), 4u);
    const auto json = nlohmann::json::parse(bytesOf(folder / "light.dds.json"));
    EXPECT_EQ(json["texture_size"], (nlohmann::json{4, 6, 5}));
    EXPECT_EQ(json["up_axis"], "Y");
    constexpr std::size_t kHeader = 148, kTexel = 1 + 4 * (3 + 6 * 2);  // at (1, 3, 2) of Unity's (x, y, z)
    std::array<std::array<float, 4>, 3> values{};
    for (std::size_t i = 0; i < 3; ++i) {
        std::string texels = bytesOf(written.files[i]).substr(kHeader);
        ASSERT_EQ(texels.size(), 4u * 5 * 6 * 8);
        for (std::size_t c = 0; c < 4; ++c) {
            std::uint16_t half = 0;
            std::memcpy(&half, texels.data() + 8 * kTexel + 2 * c, 2);
            values[i][c] = imath_half_to_float(half);
        }
        texels.erase(8 * kTexel, 8);
        EXPECT_EQ(texels.find_first_not_of('\0'), std::string::npos) << "all others are dark";
    }
    // What faces get is the formula's, in any direction; Unity's (x, y, z) is (x, z, y) here.
    const TestLight light = testLight(frame.worldFromIndex(lit));
    const double channels[] = {light.red, light.green, light.blue};
    for (const glm::dvec3& n : normals(9)) {
        for (std::size_t c = 0; c < 3; ++c) {
            const double formula = channels[c] / 1000 * (0.25 - 0.5 * glm::dot(n, light.direction));
            const double read = double(values[0][c]) + n.x * double(values[1][c]) + n.y * double(values[c][3]) +
                                n.z * double(values[2][c]);
            EXPECT_NEAR(read, formula, 2e-3 * channels[c] / 1000);
        }
    }
    // The voxel's centre is where Unity's axes have it.
    const auto& m = json["world_from_texture"];
    const double uvw[] = {1.5 / 4, 3.5 / 6, 2.5 / 5};
    const glm::dvec3 centre = frame.worldFromIndex(lit), unity(centre.x, centre.z, centre.y);
    for (int row = 0; row < 3; ++row) {
        const auto& r = m[static_cast<std::size_t>(row)];
        EXPECT_NEAR(r[0].get<double>() * uvw[0] + r[1].get<double>() * uvw[1] + r[2].get<double>() * uvw[2] +
                        r[3].get<double>(),
                    unity[row], 1e-9);
    }
}

TEST(L1, LobesAddUp) {
    const TemporaryFolder folder;
    const GridFrame frame = straightFrame({0, 0, 0}, {3, 3, 3}, 0.1);
    LightVolume volume = testVolume(frame, false);
    const auto texels = [&](const std::string& name) {
        OutputSet outputs;
        writeL1Textures(outputs, folder / name, volume, TextureFormat::Ktx2, VoxelBox{{0, 0, 0}, {3, 3, 3}});
        outputs.commit();
        const std::string bytes = bytesOf(l1Paths(folder / name)[1]);
        std::vector<float> values;
        for (std::size_t at = bytes.size() - std::size_t{4 * 4 * 4 * 8}; at < bytes.size(); at += 2) {
            std::uint16_t half = 0;
            std::memcpy(&half, bytes.data() + at, 2);
            values.push_back(imath_half_to_float(half));
        }
        return values;
    };
    const std::vector<float> one = texels("one.ktx2");
    // A second lobe of the same light doubles what faces get.
    volume.second.emplace(testVolume(frame, false).field);
    const std::vector<float> two = texels("two.ktx2");
    ASSERT_EQ(one.size(), two.size());
    for (std::size_t i = 0; i < one.size(); ++i) EXPECT_NEAR(two[i], 2 * one[i], 1e-3f) << i;
}

}  // namespace
}  // namespace photic
