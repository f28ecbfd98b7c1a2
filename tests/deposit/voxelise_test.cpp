// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/voxelise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "bake/deposit/slabs.h"
#include "bake/threads/parallel_for.h"
#include "bake/tubes/bent_rows.h"
#include "bake/tubes/tube_builder.h"

namespace photic {
namespace {

std::shared_ptr<const NeededVoxels> box(glm::ivec3 min, glm::ivec3 max) {
    GridFrame frame;
    frame.min = min, frame.max = max;
    return std::make_shared<const NeededVoxels>(NeededVoxels::everything(frame));
}

// A rippled sheet of rays that starts above `top` and folds on its way through the box; cells of `cell` voxels.
TubeSet foldedSheet(int axis, int sense, double cell, glm::dvec2 low, glm::dvec2 high, double start, int channels = 1) {
    TubeSet set;
    set.axis = axis, set.sense = sense, set.channels = channels;
    const int columns = static_cast<int>((high.x - low.x) / cell), rows = static_cast<int>((high.y - low.y) / cell);
    for (int j = 0; j < rows; j += 8)
        for (int i = 0; i < columns; i += 8) {
            const int nx = std::min(8, columns - i), ny = std::min(8, rows - j);
            set.blocks.push_back({regularTopology(nx, ny), static_cast<std::uint32_t>(set.corners.size()),
                                  static_cast<std::uint32_t>(set.tubes.size())});
            for (int y = j; y <= j + ny; ++y)
                for (int x = i; x <= i + nx; ++x) {
                    const glm::dvec2 p = low + cell * glm::dvec2(x, y);
                    CornerRay ray;
                    ray.u = p.x, ray.v = p.y, ray.w = start + 0.7 * std::sin(0.31 * p.x) * std::cos(0.23 * p.y);
                    ray.du_dw = 0.3 + 0.35 * std::sin(0.21 * p.x + 0.4), ray.dv_dw = -0.2 + 0.3 * std::cos(0.17 * p.y);
                    ray.w_end = sense * 1e30;
                    set.corners.push_back(ray);
                }
            for (int t = 0; t < 2 * nx * ny; ++t) {
                TubeConstants tube{};
                for (int k = 0; k < 3; ++k)
                    tube.power[k] =
                        static_cast<float>((1 + 0.3 * k) * (1 + 0.01 * ((t + 7 * i + 3 * j) % 13)) * cell * cell / 2);
                tube.length = 1.2f;
                tube.travel[0] = 0.3f, tube.travel[1] = -0.2f, tube.travel[2] = static_cast<float>(sense);
                set.tubes.push_back(tube);
            }
        }
    set.addSlope(0.3, -0.2, 1);
    return set;
}

double largestDifference(const LightField& a, const LightField& b) {
    double worst = 0;
    const GridFrame& frame = a.frame();
    for (int x = frame.min.x; x <= frame.max.x; ++x)
        for (int y = frame.min.y; y <= frame.max.y; ++y)
            for (int z = frame.min.z; z <= frame.max.z; ++z)
                for (int k = 0; k < a.channels().count(); ++k)
                    worst =
                        std::max(worst, static_cast<double>(std::fabs(a.value({x, y, z}, k) - b.value({x, y, z}, k))));
    return worst;
}

LightField voxelised(const TubeSet& set, const std::shared_ptr<const NeededVoxels>& needed,
                     const VoxeliseOptions& options, DepositTotals& totals, FieldChannels channels = {1, true}) {
    LightField field(needed, channels);
    Monitor monitor;
    voxelise(set, field, options, totals, monitor);
    return field;
}

class VoxeliseKernels : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(VoxeliseKernels, AgreeWithTheScalarOneOnAFoldedSheet) {
    const auto needed = box({-20, -9, -30}, {50, 60, 25});
    for (const int channels : {1, 3}) {
        for (const double cell : {0.4, 1.1, 9.0}) {
            const TubeSet set = foldedSheet(2, -1, cell, {-60, -50}, {90, 100}, 22.3, channels);
            VoxeliseOptions options;
            options.noise_floor = 3e-6;
            DepositTotals totals, scalar_totals;
            options.kernel = DepositKernel::Scalar;
            const LightField expected = voxelised(set, needed, options, scalar_totals, {channels, true});
            options.kernel = DepositKernel::Edges;
            options.instruction_set = GetParam();
            const LightField field = voxelised(set, needed, options, totals, {channels, true});
            double brightest = 0, sum = 0, apart = 0;
            for (int slot = 0; slot < expected.leafCount(); ++slot)
                for (int v = 0; v < LightField::kLeafVoxels && expected.state(slot) == LeafState::Dense; ++v) {
                    const double here = expected.dense(slot)[v];
                    brightest = std::max(brightest, here), sum += here;
                    apart += std::fabs(here - (field.state(slot) == LeafState::Dense ? field.dense(slot)[v] : 0));
                }
            // Corners are known to some 4e-6 voxels, and tubes are summed until they are 1e-3 of their length wide: one
            // voxel at a fold may differ by that much of the brightest, all together far less.
            EXPECT_LT(largestDifference(field, expected), 2e-3 * brightest) << channels << " channels, cell " << cell;
            EXPECT_LT(apart / sum, 1e-5) << channels << " channels, cell " << cell;
            EXPECT_NEAR(field.sum(0) / expected.sum(0), 1, 1e-6);
            if (channels == 1) {
                // Slivers everywhere and dark voxels between them: what rounding leaves there below 0 is cut off, and
                // that adds up.
                EXPECT_NEAR(totals.expected / field.sum(0), 1, 2e-6) << "cell " << cell;
            }
        }
    }
}

// A sheet of one tube a block, cut at some random cross-sections, each of which slants through several layers.
TubeSet cutSheet(const TubeSet& whole, int cuts, std::mt19937& random) {
    TubeSet set = whole;
    set.blocks.clear(), set.corners.clear();
    for (const TubeBlock& block : whole.blocks) {
        const auto vertices = static_cast<std::size_t>(block.topology->vertex_count);
        std::vector<std::vector<double>> at(vertices);
        for (std::size_t v = 0; v < vertices; ++v) {
            for (int i = 0; i < cuts; ++i) at[v].push_back(std::uniform_real_distribution<>(-15, 15)(random));
            std::sort(at[v].begin(), at[v].end(), std::greater<>());  // along the light, which goes down
        }
        for (int i = 0; i <= cuts; ++i) {
            TubeBlock part = block;
            part.first_corner = static_cast<std::uint32_t>(set.corners.size());
            for (std::size_t v = 0; v < vertices; ++v) {
                CornerRay ray = whole.corners[block.first_corner + v];
                const double start = i > 0 ? at[v][static_cast<std::size_t>(i - 1)] : ray.w;
                ray.u += ray.du_dw * (start - ray.w), ray.v += ray.dv_dw * (start - ray.w), ray.w = start;
                if (i < cuts) ray.w_end = at[v][static_cast<std::size_t>(i)];
                set.corners.push_back(ray);
            }
            set.blocks.push_back(part);
        }
    }
    return set;
}

TEST_P(VoxeliseKernels, TubesThatAreCutDepositWhatWholeOnesDo) {
    const auto needed = box({-20, -9, -30}, {50, 60, 25});
    TubeSet whole = foldedSheet(2, -1, 2.3, {-60, -50}, {90, 100}, 22.3);
    for (std::size_t i = 0; i < whole.corners.size(); ++i)
        whole.corners[i].w_end = -22.4 - 0.01 * static_cast<double>(i % 7);
    std::mt19937 random(5);
    for (const DepositKernel kernel : {DepositKernel::Scalar, DepositKernel::Edges})
        for (const int cuts : {1, 2, 7}) {
            VoxeliseOptions options;
            options.kernel = kernel, options.instruction_set = GetParam();
            DepositTotals totals, cut_totals;
            const LightField expected = voxelised(whole, needed, options, totals);
            const LightField field = voxelised(cutSheet(whole, cuts, random), needed, options, cut_totals);
            // Light that a cut moves across the box's sides counts in neither sum: only the sheet that lies inside is
            // compared, by what was to be deposited.
            const double limit = kernel == DepositKernel::Scalar ? 1e-6 : 3e-5;
            EXPECT_NEAR(cut_totals.expected / totals.expected, 1, 1e-3) << cuts << " cuts";
            EXPECT_NEAR(field.sum(0) / cut_totals.expected, 1, limit) << cuts << " cuts";
            EXPECT_NEAR(expected.sum(0) / totals.expected, 1, limit) << cuts << " cuts";
        }
}

// One tube that stays inside the box: here the sums themselves must agree.
TEST_P(VoxeliseKernels, ACutLosesNothing) {
    const auto needed = box({-30, -30, -40}, {30, 30, 40});
    TubeSet whole;
    whole.blocks.push_back({BlockTopology::fromTriangles(3, {{{0, 1, 2}}}), 0, 0});
    whole.corners = {
        {-6, -5, 21.3, 0.2, -0.1, -24.2}, {7, -3, 22.9, -0.3, 0.1, -22.7}, {-2, 8, 20.4, 0.1, -0.3, -27.1}};
    whole.tubes.push_back({{3, 3, 3}, 1.1f, {0.1f, -0.1f, -1.0f}});
    std::mt19937 random(11);
    for (const DepositKernel kernel : {DepositKernel::Scalar, DepositKernel::Edges})
        for (const int cuts : {1, 2, 7}) {
            VoxeliseOptions options;
            options.kernel = kernel, options.instruction_set = GetParam();
            DepositTotals totals;
            const double expected = voxelised(whole, needed, options, totals).sum(0);
            // The open length itself: power x layers between the mean ends x path a layer.
            EXPECT_NEAR(expected / (3 * 1.1 * ((21.3 + 22.9 + 20.4) + (24.2 + 22.7 + 27.1)) / 3), 1,
                        kernel == DepositKernel::Scalar ? 1e-6 : 3e-5);
            for (int times = 0; times < 8; ++times) {
                const double cut = voxelised(cutSheet(whole, cuts, random), needed, options, totals).sum(0);
                EXPECT_NEAR(cut / expected, 1, kernel == DepositKernel::Scalar ? 1e-6 : 3e-5) << cuts << " cuts";
            }
        }
}

TEST_P(VoxeliseKernels, SumTheSameLightAlongEveryAxis) {
    const auto z_box = box({-8, -8, -8}, {40, 47, 30});
    VoxeliseOptions options;
    options.instruction_set = GetParam();
    DepositTotals totals;
    const LightField along_z = voxelised(foldedSheet(2, -1, 0.7, {-40, -30}, {70, 80}, 28.4), z_box, options, totals);
    for (const int axis : {0, 1}) {
        const auto axes = axesFor(axis);
        glm::ivec3 low, high;
        for (std::size_t a = 0; a < 3; ++a) {
            low[axes[a]] = z_box->frame().min[static_cast<int>(a)];
            high[axes[a]] = z_box->frame().max[static_cast<int>(a)];
        }
        const LightField turned =
            voxelised(foldedSheet(axis, -1, 0.7, {-40, -30}, {70, 80}, 28.4), box(low, high), options, totals);
        double worst = 0;
        for (int u = -8; u <= 40; ++u)
            for (int v = -8; v <= 47; ++v)
                for (int w = -8; w <= 30; ++w) {
                    glm::ivec3 at;
                    at[axes[0]] = u, at[axes[1]] = v, at[axes[2]] = w;
                    worst = std::max(worst,
                                     static_cast<double>(std::fabs(along_z.value({u, v, w}, 0) - turned.value(at, 0))));
                }
        EXPECT_EQ(worst, 0) << "axis " << axis;
    }
}

// Tubes much smaller than a voxel whose centroids lie on the seam of two tiles, or beside it by less than single
// precision tells: one of the tiles counts each, in every layer.
TEST_P(VoxeliseKernels, CountATubeOnASeamOfTilesOnce) {
    const auto needed = box({-64, -9, 0}, {150, 60, 15});
    std::mt19937 random(5);
    std::uniform_real_distribution<double> beside(-4e-6, 4e-6), along(2, 58), slope(-0.3, 0.3);
    TubeSet set;
    set.axis = 2, set.sense = 1;
    const auto topology = BlockTopology::fromTriangles(3, {{{0, 1, 2}}});
    double power = 0;
    for (int i = 0; i < 4000; ++i) {
        set.blocks.push_back(
            {topology, static_cast<std::uint32_t>(set.corners.size()), static_cast<std::uint32_t>(set.tubes.size())});
        // In voxels' middles: a seam, between voxels 63 and 64, is at 63.5.
        const glm::dvec2 centre(63.5 + beside(random), along(random));
        const double turn = slope(random);
        for (const glm::dvec2 corner : {glm::dvec2(-0.05, -0.03), glm::dvec2(0.05, -0.03), glm::dvec2(0, 0.06)}) {
            CornerRay ray;
            ray.u = centre.x + corner.x, ray.v = centre.y + corner.y, ray.w = -3;
            ray.dv_dw = 0.1 * turn, ray.w_end = 1e30;
            set.corners.push_back(ray);
        }
        TubeConstants tube{};
        tube.power[0] = 1.0f + 0.25f * static_cast<float>(i % 4), tube.length = 1, tube.travel[2] = 1;
        set.tubes.push_back(tube);
        power += static_cast<double>(tube.power[0]);
    }
    set.addSlope(0, 0, 1);
    for (const DepositKernel kernel : {DepositKernel::Edges, DepositKernel::Scalar}) {
        VoxeliseOptions options;
        options.kernel = kernel, options.instruction_set = GetParam();
        DepositTotals totals;
        const LightField field = voxelised(set, needed, options, totals, {1, false});
        EXPECT_NEAR(totals.expected / (16 * power), 1, 1e-12);
        EXPECT_NEAR(field.sum(0) / power / 16, 1, 1e-5);
    }
}

INSTANTIATE_TEST_SUITE_P(Sets, VoxeliseKernels, ::testing::ValuesIn([] {
                             std::vector<InstructionSet> sets{InstructionSet::Portable};
                             for (const auto set : {InstructionSet::Avx2, InstructionSet::Avx512})
                                 if (set <= bestInstructionSet()) sets.push_back(set);
                             return sets;
                         }()),
                         [](const auto& set) { return name(set.param); });

// At the coordinates of a map, ten million voxels from the origin, where single precision no longer holds a column.
TEST_P(VoxeliseKernels, KeepTheLightAndItsLedgerFarFromTheOrigin) {
    const glm::ivec3 away(10'000'003, 92'995'521, -7);
    const TubeSet near = foldedSheet(2, -1, 0.9, {-60, -60}, {140, 140}, 18.1);
    TubeSet far = near;
    for (CornerRay& ray : far.corners) ray.u += away.x, ray.v += away.y, ray.w += away.z;
    VoxeliseOptions options;
    options.instruction_set = GetParam();
    DepositTotals near_totals, far_totals;
    const LightField a = voxelised(near, box({-10, -10, -40}, {90, 70, 20}), options, near_totals);
    const LightField b =
        voxelised(far, box(glm::ivec3(-10, -10, -40) + away, glm::ivec3(90, 70, 20) + away), options, far_totals);
    EXPECT_NEAR(far_totals.expected / near_totals.expected, 1, 1e-6);
    EXPECT_NEAR(far_totals.expected / b.sum(0), 1, 1e-5);
    double worst = 0, brightest = 0;
    for (int x = -10; x <= 90; ++x)
        for (int y = -10; y <= 70; ++y)
            for (int z = -40; z <= 20; ++z) {
                const float here = a.value({x, y, z}, 0), there = b.value(glm::ivec3(x, y, z) + away, 0);
                worst = std::max(worst, static_cast<double>(std::fabs(here - there)));
                brightest = std::max(brightest, static_cast<double>(here));
            }
    EXPECT_LT(worst, 1e-4 * brightest);
}

TEST(Voxelise, LightTravellingUpIsTheMirrorImageOfLightTravellingDown) {
    VoxeliseOptions options;
    DepositTotals totals;
    TubeSet down = foldedSheet(2, -1, 0.8, {-30, -30}, {60, 60}, 15.2);
    TubeSet up = down;
    up.sense = 1;
    for (CornerRay& ray : up.corners)
        ray.w = -ray.w, ray.du_dw = -ray.du_dw, ray.dv_dw = -ray.dv_dw, ray.w_end = -ray.w_end;
    up.slope_u_power = -up.slope_u_power, up.slope_v_power = -up.slope_v_power;
    const LightField a = voxelised(down, box({0, 0, -20}, {30, 30, 20}), options, totals);
    const LightField b = voxelised(up, box({0, 0, -20}, {30, 30, 20}), options, totals);
    double worst = 0;
    for (int x = 0; x <= 30; ++x)
        for (int y = 0; y <= 30; ++y)
            for (int z = -20; z <= 20; ++z)
                worst = std::max(worst, static_cast<double>(std::fabs(a.value({x, y, z}, 0) - b.value({x, y, -z}, 0))));
    EXPECT_LT(worst, 5e-3);
}

// The rows of straight rays on a slab, and the lengths and directions that their slopes mean.
BentRows rowsOf(const TubeSet& set, const Slab& slab) {
    BentRows bent;
    bent.first_column[0] = 7, bent.first_column[1] = -5, bent.channels = set.channels;
    bent.values.resize(set.corners.size() * bent.rayStride());
    for (std::size_t c = 0; c < set.corners.size(); ++c) {
        bent.rays.push_back(static_cast<std::uint32_t>(c));
        const CornerRay& ray = set.corners[c];
        for (int l = 0; l < BentRows::kLanes; ++l) {
            const double dw = slab.first + l - ray.w;
            const double row[] = {
                ray.u + ray.du_dw * dw - 7, ray.v + ray.dv_dw * dw + 5, ray.du_dw, ray.dv_dw, 1, 1, 1, 1, 1};
            for (std::size_t k = 0; k < bent.rayStride() / BentRows::kLanes; ++k)
                bent.values[c * bent.rayStride() + k * BentRows::kLanes + static_cast<std::size_t>(l)] =
                    static_cast<float>(row[k]);
        }
    }
    return bent;
}

TEST_P(VoxeliseKernels, BentTubesThatHappenToBeStraightAreAsStraightOnes) {
    const auto needed = box({-20, -9, -30}, {50, 60, 25});
    for (const int axis : {2, 0, 1})
        for (const int sense : {1, -1}) {
            TubeSet set = foldedSheet(axis, sense, 1.1, {-60, -50}, {90, 100}, -12.3 * sense, axis == 2 ? 3 : 1);
            // Lengths and directions follow the slopes, as those of bent tubes do.
            for (const TubeBlock& block : set.blocks)
                for (std::size_t t = 0; t < block.topology->triangles.size(); ++t) {
                    TubeConstants& tube = set.tubes[block.first_tube + t];
                    const auto axes = axesFor(axis);
                    double length = 0, u = 0, v = 0;
                    for (const std::uint8_t c : block.topology->triangles[t].corner) {
                        const CornerRay& ray = set.corners[block.first_corner + c];
                        length += std::sqrt(1 + ray.du_dw * ray.du_dw + ray.dv_dw * ray.dv_dw) / 3;
                        u += ray.du_dw / 3, v += ray.dv_dw / 3;
                    }
                    tube.length = static_cast<float>(length);
                    tube.travel[axes[0]] = static_cast<float>(sense * u);
                    tube.travel[axes[1]] = static_cast<float>(sense * v);
                    tube.travel[axes[2]] = static_cast<float>(sense);
                }
            VoxeliseOptions options;
            options.instruction_set = GetParam();
            options.quadrature = 2;
            DepositTotals totals, bent_totals;
            const FieldChannels channels{set.channels, true};
            const LightField straight = voxelised(set, needed, options, totals, channels);
            LightField field(needed, channels);
            Monitor monitor;
            for (const SlabGroup& group : planSlabs(*needed, axis, TileSums::kColumns, widestLanes(GetParam())))
                for (std::size_t s = 0; s < group.slabs.size(); ++s)
                    voxeliseSlab(set, rowsOf(set, group.slabs[s]), group, s, field, options, bent_totals, monitor);
            double brightest = 0;
            for (int slot = 0; slot < straight.leafCount(); ++slot)
                for (int v = 0; v < LightField::kLeafVoxels && straight.state(slot) == LeafState::Dense; ++v)
                    brightest = std::max(brightest, double(straight.dense(slot)[v]));
            EXPECT_LT(largestDifference(straight, field), 2e-3 * brightest) << axis << sense;
            EXPECT_NEAR(field.sum(0) / straight.sum(0), 1, 1e-5) << axis << sense;
            EXPECT_NEAR(bent_totals.expected / totals.expected, 1, 1e-5) << axis << sense;
        }
}

TEST(Voxelise, ThreadsChangeNoBit) {
    const auto needed = box({-10, -10, -40}, {150, 90, 20});
    const TubeSet set = foldedSheet(2, -1, 0.9, {-60, -60}, {200, 140}, 18.1);
    VoxeliseOptions options;
    DepositTotals one_totals, two_totals;
    setThreadCount(1);
    const LightField one = voxelised(set, needed, options, one_totals);
    setThreadCount(3);
    const LightField three = voxelised(set, needed, options, two_totals);
    setThreadCount(0);
    EXPECT_EQ(largestDifference(one, three), 0);
    EXPECT_EQ(one_totals.expected, two_totals.expected);
}

TEST(Voxelise, NeedingLessChangesNothingWhereItIsNeeded) {
    const auto whole = box({-10, -10, -40}, {90, 90, 20});
    const TubeSet set = foldedSheet(2, -1, 0.9, {-60, -60}, {140, 140}, 18.1);
    VoxeliseOptions options;
    DepositTotals all_totals, some_totals;
    const LightField all = voxelised(set, whole, options, all_totals);
    NeededVoxels some = NeededVoxels::none(whole->frame());
    for (int x = -10; x <= 90; ++x)
        for (int y = -10; y <= 90; ++y) some.addColumn(x, y, -22, -19);
    for (int y = 3; y < 40; ++y)
        for (int z = -40; z <= 10; ++z) some.add({17, y, z});
    some.finish();
    const LightField band = voxelised(set, std::make_shared<const NeededVoxels>(some), options, some_totals);
    double worst = 0, sum = 0;
    for (int x = -10; x <= 90; ++x)
        for (int y = -10; y <= 90; ++y)
            for (int z = -40; z <= 20; ++z) {
                if (!some.contains({x, y, z})) {
                    ASSERT_EQ(band.value({x, y, z}, 0), 0);
                    continue;
                }
                sum += band.value({x, y, z}, 0);
                worst =
                    std::max(worst, static_cast<double>(std::fabs(band.value({x, y, z}, 0) - all.value({x, y, z}, 0))));
            }
    EXPECT_LT(worst, 5e-3);
    EXPECT_NEAR(some_totals.expected / sum, 1, 2e-6);
}

TEST(Voxelise, FlatLightIsConstantWithoutBeingSummed) {
    TubeSet set = foldedSheet(2, -1, 400, {-200, -200}, {200, 200}, 100.0);
    for (CornerRay& ray : set.corners) ray.w = 100, ray.du_dw = 0.3, ray.dv_dw = -0.2;
    for (TubeConstants& tube : set.tubes) tube.power[0] = 160000.0f / 2;
    const auto needed = box({-16, -16, -16}, {63, 63, 31});
    VoxeliseOptions options;
    DepositTotals totals;
    const LightField field = voxelised(set, needed, options, totals);
    EXPECT_EQ(totals.constant_leaves, needed->leafCount());
    EXPECT_NEAR(field.value({3, 4, 5}, 0), 1.2, 1e-5);
    EXPECT_NEAR(field.value({-16, 63, 31}, 3), -1, 1e-5);
    EXPECT_NEAR(totals.expected / field.sum(0), 1, 1e-6);
}

TEST(Voxelise, AttenuatesByBeerAndLambertAveragedOverTheLayer) {
    TubeSet set = foldedSheet(2, -1, 5, {-60, -60}, {100, 100}, 20.0);
    for (CornerRay& ray : set.corners) ray.w = 20.25, ray.du_dw = ray.dv_dw = 0;
    for (TubeConstants& tube : set.tubes) tube.power[0] = 12.5f, tube.length = 1;
    for (TubeBlock& block : set.blocks) block.extinction = {0.3, 0, 0};
    VoxeliseOptions options;
    DepositTotals totals;
    const LightField field = voxelised(set, box({0, 0, -16}, {15, 15, 24}), options, totals);
    for (int z = -16; z <= 20; ++z) {
        const double top = std::min(20.25, z + 0.5), depth = 20.25 - top, length = top - (z - 0.5);
        const double expected = std::exp(-0.3 * depth) * -std::expm1(-0.3 * length) / 0.3;
        EXPECT_NEAR(field.value({7, 7, z}, 0) / expected, 1, 2e-6) << "z " << z;
    }
    EXPECT_EQ(field.value({7, 7, 21}, 0), 0);
}

TEST(Voxelise, SlantingLightIsEvaluatedAtMorePoints) {
    TubeSet set;
    EXPECT_EQ(pointsAcrossLayer(set), 1);
    const auto points = [](double du, double dv) {
        TubeSet one;
        one.addSlope(du, dv, 2);
        return pointsAcrossLayer(one);
    };
    EXPECT_EQ(points(0.4, -0.5), 1);
    EXPECT_EQ(points(0.5, 0.5), 2);
    EXPECT_EQ(points(-0.8, 0.6), 2);
    EXPECT_EQ(points(-0.8, 0.7), 4);
    // Off a ring of mirrors light goes all ways: it slants, though in the mean it falls straight.
    for (const double turn : {0.0, 1.0, 2.0, 3.0})
        set.addSlope(1.2 * std::cos(turn * std::numbers::pi / 2), 1.2 * std::sin(turn * std::numbers::pi / 2), 1);
    EXPECT_NEAR(set.meanSlopeU(), 0, 1e-12);
    EXPECT_EQ(pointsAcrossLayer(set), 4);
}

TEST(Voxelise, MoreGaussPointsConvergeToTheSameSum) {
    const auto needed = box({0, 0, -30}, {40, 40, 15});
    const TubeSet set = foldedSheet(2, -1, 0.5, {-60, -60}, {90, 90}, 12.0);
    VoxeliseOptions options;
    DepositTotals totals;
    const LightField one = voxelised(set, needed, options, totals);
    options.quadrature = 2;
    const LightField two = voxelised(set, needed, options, totals);
    options.quadrature = 4;
    const LightField four = voxelised(set, needed, options, totals);
    const auto distance = [&](const LightField& a, const LightField& b) {
        double sum = 0;
        for (int x = 0; x <= 40; ++x)
            for (int y = 0; y <= 40; ++y)
                for (int z = -30; z <= 15; ++z) sum += std::fabs(a.value({x, y, z}, 0) - b.value({x, y, z}, 0));
        return sum;
    };
    EXPECT_LT(distance(two, four), 0.5 * distance(one, four));
}

}  // namespace
}  // namespace photic
