// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/brick_plan.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>

#include "runtime/src/guarded.h"
#include "runtime/src/volume_builder.h"

namespace photic::runtime {
namespace {

constexpr int kFarthest = 255;  // what the top byte of an entry holds

/// The bricks that a page's nine voxels along one axis lie in: two, or more where the light repeats inside.
struct BricksAlong {
    BricksAlong(const VolumeData& data, int page, int axis) {
        for (int i = 0; i < BrickPlan::kSide; ++i) {
            const int brick = data.wrapped(8 * page + i, axis) >> 3;
            if (count == 0 || numbers[static_cast<std::size_t>(count - 1)] != brick) {
                numbers[static_cast<std::size_t>(count++)] = brick;
            }
        }
    }
    std::array<int, BrickPlan::kSide> numbers{};
    int count = 0;
};

/// Whether any voxel that the page reads lies in a brick.
bool touchesBricks(const VolumeData& data, const Int3& page) {
    const BricksAlong x(data, page[0], 0), y(data, page[1], 1), z(data, page[2], 2);
    for (int k = 0; k < z.count; ++k) {
        for (int j = 0; j < y.count; ++j) {
            for (int i = 0; i < x.count; ++i) {
                const auto at = [](const BricksAlong& b, int n) { return b.numbers[static_cast<std::size_t>(n)]; };
                if (data.page(at(x, i), at(y, j), at(z, k)) != 0) return true;
            }
        }
    }
    return false;
}

/// Turns entries of dark pages into how many steps it is to the nearest page that is not: two sweeps of a chessboard
/// distance. Beyond the ends of an axis that repeats, all counts as lit.
void addDistances(const VolumeData& data, BrickPlan& plan) {
    const int nx = plan.page_count[0], ny = plan.page_count[1], nz = plan.page_count[2];
    const auto at = [&](int x, int y, int z) {
        return (static_cast<std::size_t>(z) * static_cast<std::size_t>(ny) + static_cast<std::size_t>(y)) *
                   static_cast<std::size_t>(nx) +
               static_cast<std::size_t>(x);
    };
    std::vector<std::uint8_t> distance(plan.entries.size());
    for (std::size_t i = 0; i < distance.size(); ++i) distance[i] = plan.entries[i] == 0 ? kFarthest : 0;
    const auto neighbour = [&](int x, int y, int z) -> int {
        const bool inside = x >= 0 && x < nx && y >= 0 && y < ny && z >= 0 && z < nz;
        if (inside) return distance[at(x, y, z)];
        const bool repeats = (data.period[0] != 0 && (x < 0 || x >= nx)) ||
                             (data.period[1] != 0 && (y < 0 || y >= ny)) || (data.period[2] != 0 && (z < 0 || z >= nz));
        return repeats ? 0 : kFarthest;
    };
    // Of the 27 pages around one, itself the 13th, a sweep looks at those that it has passed.
    const auto relax = [&](int x, int y, int z, int first, int last) {
        std::uint8_t& d = distance[at(x, y, z)];
        if (d == 0) return;
        int least = d;
        for (int n = first; n < last; ++n) {
            least = std::min(least, 1 + neighbour(x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1));
        }
        d = static_cast<std::uint8_t>(std::min(least, kFarthest));
    };
    for (int z = 0; z < nz; ++z) {
        for (int y = 0; y < ny; ++y) {
            for (int x = 0; x < nx; ++x) relax(x, y, z, 0, 13);
        }
    }
    for (int z = nz - 1; z >= 0; --z) {
        for (int y = ny - 1; y >= 0; --y) {
            for (int x = nx - 1; x >= 0; --x) relax(x, y, z, 14, 27);
        }
    }
    for (std::size_t i = 0; i < distance.size(); ++i) {
        plan.entries[i] |= std::uint32_t{distance[i]} << BrickPlan::kDistanceShift;
    }
}

}  // namespace

double BrickPlan::fill() const {
    std::size_t own = 0;
    for (const std::uint32_t entry : entries) own += (entry & kNumberMask) != 0;
    return entries.empty() ? 0 : static_cast<double>(own) / static_cast<double>(entries.size());
}

BrickPlan planBricks(const VolumeData& data, std::uint64_t largest_table) {
    BrickPlan plan;
    if (data.lit_voxels == 0) {
        plan.page_count = {1, 1, 1};
        plan.entries.assign(1, std::uint32_t{kFarthest} << BrickPlan::kDistanceShift);
        return plan;
    }
    std::uint64_t pages = 1;
    for (std::size_t a = 0; a < 3; ++a) {
        // The cell before the first lit voxel reads that voxel too.
        plan.cell_min[a] = data.period[a] != 0 ? data.lit_min[a] : data.lit_min[a] - 1;
        plan.cell_max[a] = data.period[a] != 0 ? data.lit_min[a] + data.period[a] - 1 : data.lit_max[a];
        plan.page_min[a] = floorDivide(plan.cell_min[a], 8);
        if (!data.coarse.marks.empty()) plan.page_min[a] = 2 * floorDivide(plan.page_min[a], 2);  // where blocks begin
        plan.page_count[a] = floorDivide(plan.cell_max[a], 8) - plan.page_min[a] + 1;
        pages *= static_cast<std::uint64_t>(plan.page_count[a]);
        const std::uint64_t most =
            std::min<std::uint64_t>(BrickPlan::kNumberMask, largest_table / sizeof(std::uint32_t));
        if (pages > most) {
            fail(ErrorCode::Limit, "the box of voxels is " + std::to_string(pages) + " blocks of 8^3 or more, and " +
                                       std::to_string(most) + " fit the table; raise the budget, or split the volume");
        }
    }
    plan.entries.assign(static_cast<std::size_t>(pages), 0);

    std::array<Half4, BrickPlan::kVoxels> light, rgb{};
    std::map<std::array<Half4, 2>, std::uint32_t> constants;
    std::map<Int3, std::uint32_t> blocks;  // coarse ones, and their entries
    std::size_t page = 0;
    for (int z = 0; z < plan.page_count[2]; ++z) {
        for (int y = 0; y < plan.page_count[1]; ++y) {
            for (int x = 0; x < plan.page_count[0]; ++x, ++page) {
                const Int3 p = {plan.page_min[0] + x, plan.page_min[1] + y, plan.page_min[2] + z};
                if (!touchesBricks(data, p)) continue;
                fillBrick(data, p, light.data(), data.coloured ? rgb.data() : nullptr);
                const bool constant = std::equal(light.begin() + 1, light.end(), light.begin()) &&
                                      std::equal(rgb.begin() + 1, rgb.end(), rgb.begin());
                if (constant && light[0] == Half4{} && rgb[0] == Half4{}) continue;
                const Int3 block = {floorDivide(p[0], 2), floorDivide(p[1], 2), floorDivide(p[2], 2)};
                if (data.coarse.has(block)) {
                    const auto [known, added] = blocks.try_emplace(block, plan.brickCount() | BrickPlan::kCoarse);
                    plan.entries[page] = known->second;
                    if (!added) continue;
                    plan.bricks.push_back({{2 * block[0], 2 * block[1], 2 * block[2]}, 2});
                    ++plan.coarse;
                    continue;
                }
                if (constant) {
                    const auto [known, added] = constants.try_emplace({light[0], rgb[0]}, plan.brickCount());
                    plan.entries[page] = known->second;
                    if (!added) continue;
                } else {
                    plan.entries[page] = plan.brickCount();
                }
                plan.bricks.push_back({p});
            }
        }
    }
    addDistances(data, plan);
    return plan;
}

void fillBrick(const VolumeData& data, const Int3& page, Half4* light, Half4* rgb) {
    constexpr int kSide = BrickPlan::kSide;
    fillBox(data, {8 * page[0], 8 * page[1], 8 * page[2]}, {kSide, kSide, kSide}, light, rgb);
}

void fillBox(const VolumeData& data, const Int3& min, const Int3& size, Half4* light, Half4* rgb, Repeats repeats) {
    const auto place = [&](int v, int axis) { return repeats == Repeats::Followed ? data.wrapped(v, axis) : v; };
    for (int z = 0; z < size[2]; ++z) {
        const int vz = place(min[2] + z, 2);
        for (int y = 0; y < size[1]; ++y) {
            const int vy = place(min[1] + y, 1);
            const auto row = static_cast<std::size_t>((vz & 7) * 64 + (vy & 7) * 8);
            for (int x = 0; x < size[0];) {
                // As far as this brick's row goes in one piece.
                const int vx = place(min[0] + x, 0);
                int run = std::min(8 - (vx & 7), size[0] - x);
                if (data.period[0] != 0 && repeats == Repeats::Followed)
                    run = std::min(run, data.lit_min[0] + data.period[0] - vx);
                const std::size_t brick = data.page(vx >> 3, vy >> 3, vz >> 3);
                const std::size_t slot = brick * VolumeData::kVoxels + row + static_cast<std::size_t>(vx & 7);
                if (light) light = std::copy_n(data.light.data() + slot, run, light);
                for (int i = 0; rgb && i < run; ++i, ++rgb) {
                    const auto& colour = data.rgb[slot + static_cast<std::size_t>(i)];
                    *rgb = {colour[0], colour[1], colour[2], 0};
                }
                x += run;
            }
        }
    }
}

namespace {

/// Voxels a side that a brick of the coarser volume is made from.
constexpr int kFine = 16;

/// The transform of the coarser grid: its voxel i covers 2 i and 2 i + 1, whose middle is at 2 i + 1/2.
VoxelTransform halfTransform(const VoxelTransform& fine) {
    VoxelTransform transform = fine;
    const Double3 half = multiply(fine.world_from_index, {0.5, 0.5, 0.5});
    for (std::size_t a = 0; a < 3; ++a) transform.origin_world[a] += half[a];
    for (double& v : transform.world_from_index) v *= 2;
    for (double& v : transform.index_from_world) v /= 2;
    return transform;
}

/// The bricks of the coarser grid that hold some of the finer one's, in order.
std::vector<Int3> coarseOrigins(const VolumeData& data) {
    std::vector<Int3> origins;
    const auto coarse = [](int brick) { return 8 * floorDivide(brick, 2); };
    std::size_t page = 0;
    for (int z = 0; z < data.brick_count[2]; ++z) {
        for (int y = 0; y < data.brick_count[1]; ++y) {
            for (int x = 0; x < data.brick_count[0]; ++x, ++page) {
                if (data.pages[page] == 0) continue;
                origins.push_back(
                    {coarse(data.brick_min[0] + x), coarse(data.brick_min[1] + y), coarse(data.brick_min[2] + z)});
            }
        }
    }
    std::sort(origins.begin(), origins.end());
    origins.erase(std::unique(origins.begin(), origins.end()), origins.end());
    return origins;
}

/// The mean of the eight fine voxels of voxel `v` of a brick.
float meanOfEight(const std::vector<Half4>& fine, int v, std::size_t component) {
    float sum = 0;
    for (int n = 0; n < 8; ++n) {
        const int x = 2 * (v & 7) + (n & 1), y = 2 * (v >> 3 & 7) + (n >> 1 & 1), z = 2 * (v >> 6) + (n >> 2);
        sum += floatOfHalf(fine[static_cast<std::size_t>((z * kFine + y) * kFine + x)][component]);
    }
    return sum / 8;
}

}  // namespace

Volume halfResolution(const VolumeData& data) {
    for (std::size_t a = 0; a < 3; ++a) {
        if (data.period[a] != 0 && (data.period[a] % 2 != 0 || data.lit_min[a] % 2 != 0)) {
            fail(ErrorCode::Limit, "the light repeats every " + std::to_string(data.period[a]) + " voxels from voxel " +
                                       std::to_string(data.lit_min[a]) +
                                       " on, and only even numbers can be made coarser; raise the budget");
        }
    }
    VolumeBuilder builder(halfTransform(data.transform), ~std::uint64_t{0});
    Metadata metadata = data.metadata;
    metadata.coarse_blocks.clear();
    builder.setMetadata(metadata);
    const std::vector<Int3> origins = coarseOrigins(data);
    for (const Int3& origin : origins) builder.addBrick(origin);
    builder.allocate(data.coloured);
    if (data.has_direction) builder.beginChannels(Channels::FluxAndIrradiance);

    std::vector<Half4> light(kFine * kFine * kFine), rgb(data.coloured ? light.size() : 0);
    std::vector<float> values(VolumeData::kVoxels * 4), colours(VolumeData::kVoxels * 3);
    for (const Int3& origin : origins) {
        fillBox(data, {2 * origin[0], 2 * origin[1], 2 * origin[2]}, {kFine, kFine, kFine}, light.data(),
                data.coloured ? rgb.data() : nullptr, Repeats::Ignored);
        for (int v = 0; v < VolumeData::kVoxels; ++v) {
            const auto at = static_cast<std::size_t>(v);
            for (std::size_t c = 0; c < 4; ++c) values[4 * at + c] = meanOfEight(light, v, c);
            for (std::size_t c = 0; data.coloured && c < 3; ++c) colours[3 * at + c] = meanOfEight(rgb, v, c);
        }
        builder.setBrick(origin, Channels::FluxAndIrradiance, values.data());
        if (data.coloured) builder.setBrick(origin, Channels::Rgb, colours.data());
    }
    return builder.finish();
}

}  // namespace photic::runtime
