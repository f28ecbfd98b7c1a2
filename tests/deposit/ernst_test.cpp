// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/ernst_deposit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "bake/deposit/ernst_fans.h"

namespace photic {
namespace {

// Six triangles around a vertex that stands `height` above its rim, turned and tilted; rays come from `source`.
struct Fan {
    glm::dvec3 middle, rim[6];
    std::vector<FanTube> tubes;
};
Fan fanAt(double height, const glm::dvec3& source) {
    const glm::dvec3 x = glm::normalize(glm::dvec3(0.9, 0.2, -0.3)),
                     z = glm::normalize(glm::cross(x, glm::dvec3(0.1, 1, 0.2))), y = glm::cross(z, x);
    Fan fan;
    fan.middle = height * z;
    for (int i = 0; i < 6; ++i) {
        const double turn = std::numbers::pi / 3 * (i + 0.1 * (i % 2));
        fan.rim[i] = (1 + 0.2 * (i % 3)) * (std::cos(turn) * x + std::sin(turn) * y);
    }
    for (int i = 0; i < 6; ++i) {
        FanTube tube;
        const glm::dvec3 corner[] = {fan.middle, fan.rim[i], fan.rim[(i + 1) % 6]};
        for (int k = 0; k < 3; ++k) tube.ray[k] = {corner[k], (0.5 + 0.2 * k) * (corner[k] - source)};
        tube.power = 1 + i;
        fan.tubes.push_back(tube);
    }
    return fan;
}

double triangleArea(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    return 0.5 * glm::length(glm::cross(b - a, c - a));
}

TEST(FlattenedFan, AFlatFanKeepsItsAreas) {
    const glm::dvec3 source(-3, -2, -9);
    const Fan fan = fanAt(0, source);
    const glm::dvec3 normal = glm::normalize(glm::cross(fan.rim[0] - fan.middle, fan.rim[1] - fan.middle)) *
                              (glm::dot(glm::cross(fan.rim[0], fan.rim[1]), -source) > 0 ? 1.0 : -1.0);
    double area = 0;
    for (int i = 0; i < 6; ++i) area += triangleArea(fan.middle, fan.rim[i], fan.rim[(i + 1) % 6]);
    const FanArea flat = flattenedFan(fan.tubes, fan.rim[2], normal);
    EXPECT_NEAR(std::fabs(flat.a), area, 1e-12);
    EXPECT_NEAR(flat.power, 21, 1e-12);
    // Parallel light has the same area at all depths.
    std::vector<FanTube> parallel = fan.tubes;
    for (FanTube& tube : parallel)
        for (FanRay& ray : tube.ray) ray.along = -source;
    const FanArea even = flattenedFan(parallel, fan.middle, normal);
    EXPECT_NEAR(std::fabs(even.a), area, 1e-12);
    EXPECT_NEAR(even.b, 0, 1e-12);
    EXPECT_NEAR(even.c, 0, 1e-12);
}

// From a point all light through the rim, wherever the vertex between stands, crosses planes that are parallel to a
// triangle's in figures that grow as the square of their distances.
TEST(FlattenedFan, LightOfAPointIsAConeWhateverTheFansShape) {
    const glm::dvec3 source(-3, -2, -9);
    const Fan fan = fanAt(0.4, source);
    double in_their_own_planes = 0, most_apart = 0;
    for (const FanTube& tube : fan.tubes)
        in_their_own_planes += triangleArea(tube.ray[0].start, tube.ray[1].start, tube.ray[2].start);
    for (const FanTube& tube : fan.tubes) {
        const glm::dvec3 origin = tube.ray[0].start;
        glm::dvec3 normal = glm::normalize(glm::cross(tube.ray[1].start - origin, tube.ray[2].start - origin));
        if (glm::dot(normal, origin - source) < 0) normal = -normal;
        const double distance = glm::dot(normal, origin - source);
        glm::dvec3 area(0);
        for (int i = 0; i < 6; ++i) {
            const auto inPlane = [&](const glm::dvec3& p) {
                return source + (p - source) * (distance / glm::dot(normal, p - source));
            };
            area += 0.5 * glm::cross(inPlane(fan.rim[i]) - origin, inPlane(fan.rim[(i + 1) % 6]) - origin);
        }
        const FanArea found = flattenedFan(fan.tubes, origin, normal);
        EXPECT_NEAR(found.a, glm::dot(area, normal), 1e-12);
        most_apart = std::max(most_apart, std::fabs(std::fabs(found.a) - in_their_own_planes));
        for (const double alpha : {0.5, 2.0, 7.0})
            EXPECT_NEAR(found.at(alpha), found.a * std::pow(1 + alpha / distance, 2), 1e-11) << alpha;
        EXPECT_NEAR(found.power, 21, 1e-12);
    }
    EXPECT_GT(most_apart, 0.02 * in_their_own_planes) << "flattening does something";
}

TEST(FlattenedFan, LeavesOutWhatHasNoPlaceInThePlane) {
    Fan fan = fanAt(0, {-3, -2, -9});
    const glm::dvec3 normal =
        -glm::cross(fan.rim[0], fan.rim[1]) *
        (glm::dot(glm::cross(fan.rim[0], fan.rim[1]), fan.tubes[0].ray[0].along) > 0 ? -1.0 : 1.0);
    const FanArea whole = flattenedFan(fan.tubes, fan.middle, normal);
    fan.tubes[2].ray[1].along = fan.rim[0];                  // along the plane
    fan.tubes[4].ray[2].along = -fan.tubes[4].ray[2].along;  // through it from behind
    const FanArea left = flattenedFan(fan.tubes, fan.middle, normal);
    EXPECT_NEAR(whole.power - left.power, 3 + 5, 1e-12);
    const double out =
        triangleArea(fan.middle, fan.rim[2], fan.rim[3]) + triangleArea(fan.middle, fan.rim[4], fan.rim[5]);
    EXPECT_NEAR(std::fabs(whole.a - left.a) * glm::length(normal), out, 1e-12);
}

// Light of a point, one watt a steradian, through a rough sheet of triangles below it.
TubeSet roughSheet(const glm::dvec3& source, int cells, double cell, double roughness) {
    TubeSet set;
    const double low = -0.5 * cells * cell;
    const auto vertex = [&](int i, int j) {
        return glm::dvec3(low + cell * i, low + cell * j, -6 + roughness * std::sin(1.7 * i + 0.9 * j * j));
    };
    for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
            set.blocks.push_back({BlockTopology::fromTriangles(4, {{{0, 1, 2}}, {{1, 3, 2}}}),
                                  static_cast<std::uint32_t>(set.corners.size()),
                                  static_cast<std::uint32_t>(set.tubes.size())});
            const glm::dvec3 corner[] = {vertex(i, j), vertex(i + 1, j), vertex(i, j + 1), vertex(i + 1, j + 1)};
            for (const glm::dvec3& p : corner) {
                const glm::dvec3 d = p - source;
                set.corners.push_back({p.x, p.y, p.z, d.x / d.z, d.y / d.z, -1e30});
            }
            for (const auto& [a, b, c] : {std::array{0, 1, 2}, std::array{1, 3, 2}}) {
                const glm::dvec3 u = glm::normalize(corner[a] - source), v = glm::normalize(corner[b] - source),
                                 w = glm::normalize(corner[c] - source);
                // [Van Oosterom and Strackee 1983] solid angle of a triangle
                const double angle = 2 * std::atan2(std::fabs(glm::dot(u, glm::cross(v, w))),
                                                    1 + glm::dot(u, v) + glm::dot(v, w) + glm::dot(w, u));
                const glm::dvec3 way = glm::normalize(u + v + w);
                TubeConstants tube{};
                tube.power[0] = static_cast<float>(angle);
                tube.length = static_cast<float>(1 / std::fabs(way.z));
                for (int k = 0; k < 3; ++k) tube.travel[k] = static_cast<float>(way[k] / std::fabs(way.z));
                set.tubes.push_back(tube);
            }
        }
    return set;
}

LightField emptyBox() {
    GridFrame frame;
    frame.min = {-8, -8, -30}, frame.max = {8, 8, -10};
    return LightField(std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame)), {1, false});
}

LightField laid(const std::vector<TubeSet>& sets) {
    LightField field = emptyBox();
    Monitor quiet;
    const ErnstFans fans(sets);
    for (std::size_t s = 0; s < sets.size(); ++s) depositErnst(sets[s], fans, s, field, quiet);
    return field;
}

// The worst voxel of the layers from `first` down, of 1 over the square of its distance.
double worstAgainstAPoint(const LightField& field, const glm::dvec3& source) {
    double worst = 0;
    const GridFrame& frame = field.frame();
    for (int k = frame.min.z; k <= frame.max.z; ++k)
        for (int j = frame.min.y; j <= frame.max.y; ++j)
            for (int i = frame.min.x; i <= frame.max.x; ++i) {
                const glm::dvec3 way = glm::dvec3(i, j, k) - source;
                worst = std::max(worst, std::fabs(field.irradiance({i, j, k}) * glm::dot(way, way) - 1));
            }
    return worst;
}

TEST(ErnstDeposit, LightOfAPointThroughARoughSheetFallsOffAsItsSquare) {
    const glm::dvec3 source(0.3, -0.2, 10);
    EXPECT_LT(worstAgainstAPoint(laid({roughSheet(source, 24, 0.9, 0.3)}), source), 0.06);
    // Finer triangles are nearer to it.
    EXPECT_LT(worstAgainstAPoint(laid({roughSheet(source, 48, 0.45, 0.15)}), source), 0.025);
}

TEST(ErnstDeposit, FansGoAcrossSetsAndThreadsDoNotMatter) {
    const glm::dvec3 source(0.3, -0.2, 10);
    const TubeSet whole = roughSheet(source, 24, 0.9, 0.3);
    std::vector<TubeSet> parts(2, whole);
    parts[0].blocks.clear(), parts[1].blocks.clear();
    for (std::size_t b = 0; b < whole.blocks.size(); ++b) parts[b * 7 / 5 % 2].blocks.push_back(whole.blocks[b]);
    const LightField one = laid({whole}), two = laid(parts);
    for (int k = -30; k <= -10; ++k)
        for (int i = -8; i <= 8; ++i)
            EXPECT_NEAR(two.irradiance({i, k % 8, k}), one.irradiance({i, k % 8, k}), 1e-9) << i << " " << k;
}

}  // namespace
}  // namespace photic
