// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/track_deposit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

namespace photic {
namespace {

/// 21 x 13 x 18 voxels, sheared, off the leaves' borders.
GridFrame shearedFrame() {
    GridFrame frame;
    frame.setWorldFromIndex(glm::dmat3(0.1, 0, 0, 0, 0.07, 0, 0.04, -0.03, 0.09));
    frame.origin_world = {0.3, -0.2, 5};
    frame.min = {-5, 3, -9}, frame.max = {15, 15, 8};
    return frame;
}

Track randomTrack(std::mt19937_64& random, const GridFrame& frame) {
    std::uniform_real_distribution<double> unit(0, 1);
    std::normal_distribution<double> normal;
    Track t;
    t.direction = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    const glm::dvec3 aim = frame.worldFromIndex(
        glm::dvec3(frame.min) + glm::dvec3(frame.size()) * glm::dvec3(unit(random), unit(random), unit(random)));
    t.origin = aim - 2.0 * unit(random) * t.direction;
    t.power = {1 + unit(random), 2 * unit(random), 0.5};
    t.begin = 0.3 * unit(random), t.end = 3 * unit(random);
    return t;
}

/// The integral of power x transmittance along the track inside one voxel, clipped by itself against its six sides.
double inVoxel(const GridFrame& frame, const Track& t, const glm::ivec3& v, int channel) {
    const glm::dvec3 o = frame.indexFromWorld(t.origin), d = frame.indexFromWorld(t.origin + t.direction) - o;
    double from = t.begin, to = t.end;
    for (int a = 0; a < 3; ++a) {
        const double t0 = (v[a] - 0.5 - o[a]) / d[a], t1 = (v[a] + 0.5 - o[a]) / d[a];
        from = std::max(from, std::min(t0, t1)), to = std::min(to, std::max(t0, t1));
    }
    if (from >= to) return 0;
    const double s = t.extinction[channel];
    return t.power[channel] * (s > 0 ? (std::exp(-s * from) - std::exp(-s * to)) / s : to - from);
}

template <class Real>
void agreesWithVoxelClipping(FieldChannels channels, const glm::dvec3& extinction, double tolerance) {
    const GridFrame frame = shearedFrame();
    const NeededVoxels needed = NeededVoxels::everything(frame);
    TrackAccumulator<Real> field(needed, channels);
    std::mt19937_64 random(3);
    std::vector<Track> tracks;
    double path = 0;
    for (int k = 0; k < 300; ++k) {
        tracks.push_back(randomTrack(random, frame));
        tracks.back().extinction = extinction;
        path += field.deposit(tracks.back()).path;
    }
    double total = 0;
    for (int x = frame.min.x; x <= frame.max.x; ++x)
        for (int y = frame.min.y; y <= frame.max.y; ++y)
            for (int z = frame.min.z; z <= frame.max.z; ++z) {
                const glm::ivec3 v(x, y, z);
                double expected[6] = {};
                for (const Track& t : tracks) {
                    double mean = 0;
                    for (int c = 0; c < channels.irradiance; ++c) {
                        const double e = inVoxel(frame, t, v, c);
                        expected[c] += e, mean += e / channels.irradiance;
                    }
                    total += mean;
                    for (int a = 0; a < 3; ++a) expected[channels.irradiance + a] += mean * t.direction[a];
                }
                const int slot = needed.slotOf(v), stride = channels.count();
                for (int c = 0; c < stride; ++c) {
                    const double found =
                        field.sums(slot) ? double(field.sums(slot)[NeededVoxels::offsetInLeaf(v) * stride + c]) : 0;
                    ASSERT_NEAR(found, expected[c], tolerance) << x << ' ' << y << ' ' << z << " channel " << c;
                }
            }
    EXPECT_NEAR(path, total, 1e-10 * total);
}

TEST(TrackDeposit, AgreesWithClippingEveryVoxel) {
    agreesWithVoxelClipping<double>({1, true}, {0, 0, 0}, 1e-12);
    agreesWithVoxelClipping<double>({1, true}, {0.7, 0.7, 0.7}, 1e-12);
    agreesWithVoxelClipping<double>({3, true}, {0.7, 0.0, 5.0}, 1e-12);
    agreesWithVoxelClipping<double>({3, false}, {0, 0, 0}, 1e-12);
    agreesWithVoxelClipping<float>({1, true}, {0.7, 0.7, 0.7}, 1e-6);
    agreesWithVoxelClipping<float>({1, false}, {0, 0, 0}, 1e-6);
}

// Hundreds of optical depths to a voxel: what is left is 0 or hardly more, never rounding, which may be negative.
TEST(TrackDeposit, OpaqueMediaLeaveNothingNegative) {
    agreesWithVoxelClipping<double>({1, true}, glm::dvec3(450), 1e-14);
    const GridFrame frame = shearedFrame();
    const NeededVoxels needed = NeededVoxels::everything(frame);
    TrackAccumulator<float> field(needed, {1, true});
    std::mt19937_64 random(5);
    for (int k = 0; k < 2000; ++k) {
        Track t = randomTrack(random, frame);
        t.extinction = glm::dvec3(std::pow(10.0, 2 + k % 5));
        field.deposit(t);
    }
    for (int slot = 0; slot < needed.leafCount(); ++slot)
        for (int i = 0; field.sums(slot) && i < LightField::kLeafVoxels; ++i)
            ASSERT_GE(field.sums(slot)[4 * i], 0) << slot << ' ' << i;
}

TEST(TrackDeposit, TracksAlongAnAxisStayInTheirColumn) {
    GridFrame frame;
    frame.min = {0, 0, 0}, frame.max = {9, 9, 19};
    const NeededVoxels needed = NeededVoxels::everything(frame);
    for (const double sense : {-1.0, 1.0}) {
        TrackAccumulator<double> field(needed, {1, true});
        Track t;
        t.origin = {3, 4, sense < 0 ? 30 : -10}, t.direction = {0, 0, sense}, t.power = glm::dvec3(2), t.end = 100;
        const DepositedTrack d = field.deposit(t);
        EXPECT_TRUE(d.touched);
        EXPECT_DOUBLE_EQ(d.path, 40);
        for (int z = 0; z < 20; ++z) {
            const int slot = needed.slotOf({3, 4, z}), offset = NeededVoxels::offsetInLeaf({3, 4, z});
            EXPECT_NEAR(field.sums(slot)[4 * offset], 2, 1e-12);
            EXPECT_NEAR(field.sums(slot)[4 * offset + 3], 2 * sense, 1e-12);
            EXPECT_EQ(field.counts(slot)[offset], 1u);
        }
        field.clear(needed.slotOf({3, 4, 0}));
        EXPECT_EQ(field.sums(needed.slotOf({3, 4, 0}))[4 * NeededVoxels::offsetInLeaf({3, 4, 0})], 0);
        EXPECT_EQ(field.counts(needed.slotOf({3, 4, 0}))[NeededVoxels::offsetInLeaf({3, 4, 0})], 0u);
        t.origin.x = 40;
        EXPECT_FALSE(field.deposit(t).touched);
    }
}

TEST(TrackDeposit, OnlyNeededVoxelsAreCounted) {
    const GridFrame frame = shearedFrame();
    NeededVoxels some = NeededVoxels::none(frame);
    for (int x = frame.min.x; x <= frame.max.x; ++x)
        for (int y = frame.min.y; y <= frame.max.y; ++y)
            for (int z = frame.min.z; z <= frame.max.z; ++z)
                if ((x * 7 + y * 3 + z * 5) % 4 == 0) some.add({x, y, z});
    some.finish();
    const NeededVoxels all = NeededVoxels::everything(frame);
    TrackAccumulator<double> sparse(some, {1, true}), full(all, {1, true});
    std::mt19937_64 random(4);
    double path = 0, sum = 0;
    for (int k = 0; k < 200; ++k) {
        Track t = randomTrack(random, frame);
        t.extinction = glm::dvec3(0.4);
        path += sparse.deposit(t).path;
        full.deposit(t);
    }
    for (int x = frame.min.x; x <= frame.max.x; ++x)
        for (int y = frame.min.y; y <= frame.max.y; ++y)
            for (int z = frame.min.z; z <= frame.max.z; ++z) {
                const glm::ivec3 v(x, y, z);
                const int offset = NeededVoxels::offsetInLeaf(v), slot = some.slotOf(v);
                const double* leaf = slot >= 0 ? sparse.sums(slot) : nullptr;
                const double* exact = full.sums(all.slotOf(v));
                const double expected = some.contains(v) && exact ? exact[4 * offset] : 0;
                EXPECT_NEAR(leaf ? leaf[4 * offset] : 0, expected, 1e-12);
                sum += expected;
            }
    EXPECT_NEAR(path, sum, 1e-10 * sum);
    EXPECT_GT(sum, 0);
}

}  // namespace
}  // namespace photic
