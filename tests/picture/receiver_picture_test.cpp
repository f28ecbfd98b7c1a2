// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/receiver_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "bake/report/error.h"
#include "tests/picture/volumes.h"

namespace photic {
namespace {

using test::cubicFrame;
using test::makeVolume;

LightVolume numbered() {
    return makeVolume(cubicFrame(0.5, {0, 0, 0}, {3, 4, 5}), 1, [](const glm::ivec3& v) {
        return std::vector<double>{v.x + 10.0 * v.y + 100.0 * v.z, 0, 0, 0};
    });
}

Scene poolScene() {
    Scene scene;
    scene.file = "pool.toml";
    scene.domain.min = {-1, -2, -1.5};
    scene.domain.max = {1, 2, 0.1};
    scene.objects.push_back({"floor", "", Plane{{0, 0, -1.25}, {0, 0, 1}}, Role::Receiver});
    scene.objects.push_back({"east", "", Plane{{1, 0, 0}, {-1, 0, 0}}, Role::Receiver});
    scene.objects.push_back({"ramp", "", Plane{{0, 0, -0.7}, glm::normalize(glm::dvec3(0, -1, 2))}, Role::Movable});
    scene.objects.push_back({"lid", "", Plane{{0, 0, 0}, {0, 0, 1}}, Role::Blocker});
    scene.objects.push_back({"far", "", Plane{{0, 0, -9}, {0, 0, 1}}, Role::Receiver});
    return scene;
}

TEST(SlicePicture, ShowsXToTheRightAndYOrZUp) {
    const LightVolume volume = numbered();
    const Image floor = slicePicture(volume, 2, 3);
    ASSERT_EQ(floor.width, 4);
    ASSERT_EQ(floor.height, 5);
    EXPECT_EQ(floor.at(0, 4, 0), 300.0F);
    EXPECT_EQ(floor.at(3, 0, 0), 343.0F);
    const Image front = slicePicture(volume, 1, 2);
    ASSERT_EQ(front.width, 4);
    ASSERT_EQ(front.height, 6);
    EXPECT_EQ(front.at(1, 0, 0), 521.0F);
    const Image side = slicePicture(volume, 0, 2);
    ASSERT_EQ(side.width, 5);
    ASSERT_EQ(side.height, 6);
    EXPECT_EQ(side.at(4, 5, 0), 42.0F);
    EXPECT_EQ(slicePicture(volume, 2, 77).at(0, 0, 0), 0.0F);
}

TEST(XrayPicture, IsTheMeanAlongTheAxis) {
    const LightVolume volume = numbered();
    EXPECT_FLOAT_EQ(xrayPicture(volume, 2).at(1, 4 - 3, 0), 1 + 30 + 250);
    EXPECT_FLOAT_EQ(xrayPicture(volume, 1).at(2, 5, 0), 2 + 20);
    EXPECT_FLOAT_EQ(xrayPicture(volume, 0).at(4, 5 - 2, 0), 1.5F + 40 + 200);
}

TEST(ReceiverFrame, FitsTheDomainUpright) {
    const Scene scene = poolScene();
    const PictureFrame floor = receiverFrame(scene, "floor", 400);
    EXPECT_EQ(floor.width, 200);
    EXPECT_EQ(floor.height, 400);
    EXPECT_NEAR(glm::length(floor.origin - glm::dvec3(-1, -2, -1.25)), 0, 1e-12);
    EXPECT_NEAR(glm::length(floor.across - glm::dvec3(2, 0, 0)), 0, 1e-12);
    EXPECT_NEAR(glm::length(floor.up - glm::dvec3(0, 4, 0)), 0, 1e-12);

    // The east wall, seen from the west: north is on the left, the sky is up.
    const PictureFrame east = receiverFrame(scene, "east", 400);
    EXPECT_NEAR(glm::length(east.origin - glm::dvec3(1, 2, -1.5)), 0, 1e-12);
    EXPECT_NEAR(glm::length(east.across - glm::dvec3(0, -4, 0)), 0, 1e-12);
    EXPECT_NEAR(glm::length(east.up - glm::dvec3(0, 0, 1.6)), 0, 1e-12);
    EXPECT_EQ(east.height, 160);

    // A slope of 1/2 that meets the box's sides at y = +-1.6 (top and bottom limit it): 3.2 m of y, times sqrt(5)/2.
    const PictureFrame ramp = receiverFrame(scene, "ramp", 100);
    EXPECT_NEAR(glm::length(ramp.up), 3.2 * std::sqrt(1.25), 1e-12);
    EXPECT_NEAR(glm::length(ramp.across), 2.0, 1e-12);
    EXPECT_NEAR(glm::dot(ramp.up, ramp.normal), 0, 1e-12);
    EXPECT_NEAR(glm::dot(glm::cross(ramp.across, ramp.up), ramp.normal),
                glm::length(ramp.across) * glm::length(ramp.up), 1e-12);
}

TEST(ReceiverFrame, NamesWhatThereIs) {
    const Scene scene = poolScene();
    for (const char* wrong : {"flor", "lid"}) {
        try {
            receiverFrame(scene, wrong, 64);
            FAIL() << wrong;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Input);
            EXPECT_NE(std::string(error.what()).find("floor, east, ramp"), std::string::npos) << error.what();
        }
    }
    EXPECT_THROW(receiverFrame(scene, "far", 64), Error);
    EXPECT_EQ(planarReceivers(scene), (std::vector<std::string>{"floor", "east", "ramp", "far"}));
}

TEST(ReceiverPicture, PutsLightWhereItFalls) {
    // Light rises towards +x on a floor between two layers of voxels.
    const GridFrame frame = cubicFrame(0.125, {-8, -16, -12}, {7, 15, 0});
    const LightVolume volume = makeVolume(frame, 1, [&](const glm::ivec3& v) {
        const double e = 2 + frame.worldFromIndex(glm::dvec3(v)).x;
        return std::vector<double>{e, 0, 0, -e};
    });
    const Image picture = receiverPicture(volume, receiverFrame(poolScene(), "floor", 64));
    ASSERT_EQ(picture.width, 32);
    ASSERT_EQ(picture.height, 64);
    ASSERT_EQ(picture.channels, 1);
    for (int x = 2; x < 30; ++x)
        EXPECT_NEAR(static_cast<double>(picture.at(x, 20, 0)), 2 - 1 + (x + 0.5) / 16, 1e-5) << x;
}

TEST(ReceiverPicture, ErrorFallsWithTheSquareOfTheVoxel) {
    // A smooth field: the look-up is of second order, so its error falls by four with each halving.
    const auto truth = [](const glm::dvec3& p) { return 3 + std::sin(4 * p.x) * std::cos(3 * p.y); };
    double last = 0;
    for (int resolution : {16, 32, 64}) {
        const GridFrame frame =
            cubicFrame(2.0 / resolution, glm::ivec3(-resolution / 2 - 1, -resolution - 1, -resolution),
                       {resolution / 2, resolution, -resolution / 2});
        const LightVolume volume = makeVolume(frame, 1, [&](const glm::ivec3& v) {
            const double e = truth(frame.worldFromIndex(glm::dvec3(v)));
            return std::vector<double>{e, 0, 0, -e};
        });
        const PictureFrame floor = receiverFrame(poolScene(), "floor", 100);
        const Image picture = receiverPicture(volume, floor);
        double sum = 0;
        for (int y = 0; y < picture.height; ++y) {
            for (int x = 0; x < picture.width; ++x) {
                const glm::dvec3 p =
                    floor.origin + (x + 0.5) / floor.width * floor.across + (1 - (y + 0.5) / floor.height) * floor.up;
                sum += std::fabs(static_cast<double>(picture.at(x, y, 0)) - truth(p));
            }
        }
        if (last > 0) {
            EXPECT_NEAR(std::log2(last / sum), 2.0, 0.15) << resolution;
        }
        last = sum;
    }
}

}  // namespace
}  // namespace photic
