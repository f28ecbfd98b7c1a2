// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/voxelise.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <glm/vec2.hpp>
#include <memory>
#include <span>

#include "bake/deposit/constant_tile.h"
#include "bake/deposit/gauss_points.h"
#include "bake/deposit/kept_tiles.h"
#include "bake/deposit/slabs.h"
#include "bake/threads/parallel_for.h"
#include "bake/tubes/bent_rows.h"

namespace photic {
namespace {

// Where a block's tubes lie in a slab: columns and rows from the frame's first, which single precision holds however
// far from the origin the frame is; upper ends exclusive in the sense of floats.
struct Bounds {
    float min_u = 1, max_u = -1, min_v = 1, max_v = -1;
    bool empty() const { return min_u > max_u; }
};

// Tubes are straight, so the hull of both faces of the slab bounds them between.
Bounds boundsInSlab(const TubeSet& set, const TubeBlock& block, const Slab& slab, const glm::ivec2& first_column) {
    const double low = slab.first - 0.5, high = slab.first + slab.active - 0.5;
    const double entry = set.sense > 0 ? low : high, exit = set.sense > 0 ? high : low;
    double first_start = 1e300, last_end = -1e300;
    Bounds b{3e38f, -3e38f, 3e38f, -3e38f};
    for (int i = 0; i < block.topology->vertex_count; ++i) {
        const CornerRay& c = set.corners[block.first_corner + static_cast<std::uint32_t>(i)];
        first_start = std::min(first_start, set.sense * c.w);
        last_end = std::max(last_end, static_cast<double>(set.sense) * c.w_end);
        for (const double w : {low, high}) {
            const float u = static_cast<float>(c.u - first_column.x + c.du_dw * (w - c.w)),
                        v = static_cast<float>(c.v - first_column.y + c.dv_dw * (w - c.w));
            b.min_u = std::min(b.min_u, u), b.max_u = std::max(b.max_u, u);
            b.min_v = std::min(b.min_v, v), b.max_v = std::max(b.max_v, v);
        }
    }
    if (first_start >= set.sense * exit || last_end <= set.sense * entry) return {};
    return b;
}

// Where rays are in each layer, along one axis: within half a slope of its middle.
struct Reach {
    float low[BentRows::kLanes], high[BentRows::kLanes];
    Reach() { std::fill(low, low + BentRows::kLanes, 3e38f), std::fill(high, high + BentRows::kLanes, -3e38f); }
};
void addReach(const float* place, const float* slope, Reach& reach) {
    for (int l = 0; l < BentRows::kLanes; ++l) {
        const float half = 0.5f * std::fabs(slope[l]), low = place[l] - half, high = place[l] + half;
        reach.low[l] = low < reach.low[l] ? low : reach.low[l];
        reach.high[l] = high > reach.high[l] ? high : reach.high[l];
    }
}

// The same of bent tubes, whose rows are of this slab.
Bounds bentBoundsInSlab(const TubeSet& set, const BentRows& bent, const TubeBlock& block, const Slab& slab,
                        const glm::ivec2& first_column) {
    const double low = slab.first - 0.5, high = slab.first + slab.active - 0.5;
    const double entry = set.sense > 0 ? low : high, exit = set.sense > 0 ? high : low;
    double first_start = 1e300, last_end = -1e300;
    Bounds b{3e38f, -3e38f, 3e38f, -3e38f};
    const float from_u = static_cast<float>(bent.first_column[0] - first_column.x),
                from_v = static_cast<float>(bent.first_column[1] - first_column.y);
    Reach u, v;
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(block.topology->vertex_count); ++i) {
        const CornerRay& c = set.corners[block.first_corner + i];
        first_start = std::min(first_start, set.sense * c.w);
        last_end = std::max(last_end, static_cast<double>(set.sense) * c.w_end);
        const float* rows = bent.of(block.first_corner + i);
        addReach(rows + BentRows::kU * BentRows::kLanes, rows + BentRows::kSlopeU * BentRows::kLanes, u);
        addReach(rows + BentRows::kV * BentRows::kLanes, rows + BentRows::kSlopeV * BentRows::kLanes, v);
    }
    for (int l = 0; l < slab.active; ++l) {
        b.min_u = std::min(b.min_u, u.low[l] + from_u), b.max_u = std::max(b.max_u, u.high[l] + from_u);
        b.min_v = std::min(b.min_v, v.low[l] + from_v), b.max_v = std::max(b.max_v, v.high[l] + from_v);
    }
    if (first_start >= set.sense * exit || last_end <= set.sense * entry) return {};
    return b;
}

class Voxeliser {
public:
    Voxeliser(const TubeSet& set, LightField& field, const VoxeliseOptions& options)
        : set_(set),
          field_(field),
          options_(options),
          axes_(axesFor(set.axis)),
          points_(options.quadrature > 0 ? std::vector<int>(set.blocks.size(), options.quadrature)
                                         : pointsOfBlocks(set, options.has_edges)),
          scale_(static_cast<float>(1.0 / field.frame().voxelVolume())) {}

    void run(DepositTotals& totals, Monitor& monitor) {
        const auto groups =
            planSlabs(field_.needed(), set_.axis, TileSums::kColumns, widestLanes(options_.instruction_set));
        findBounds(groups);
        if (options_.kept) block_keys_ = keysOf(set_);
        std::vector<std::pair<std::uint32_t, std::uint32_t>> tasks;  // group, tile
        for (std::uint32_t g = 0; g < groups.size(); ++g)
            for (std::uint32_t t = 0; t < groups[g].tiles.size(); ++t) tasks.emplace_back(g, t);
        std::vector<DepositTotals> parts(tasks.size());
        std::atomic<std::int64_t> done{0};
        parallelFor(static_cast<std::int64_t>(tasks.size()), [&](std::int64_t i) {
            const auto index = static_cast<std::size_t>(i);
            monitor.checkCancelled();
            const auto [group, tile] = tasks[index];
            for (std::size_t s = 0; s < groups[group].slabs.size(); ++s)
                sumTile(groups[group], groups[group].tiles[tile], groups[group].slabs[s], bounds_[group][s],
                        parts[index]);
            const std::int64_t finished = ++done;
            if ((finished & 31) == 0)
                monitor.progress("deposit", static_cast<double>(finished) / static_cast<double>(tasks.size()));
        });
        addParts(parts, totals);
    }

    // One slab of a group, of bent tubes.
    void runSlab(const BentRows& bent, const SlabGroup& group, std::size_t slab, DepositTotals& totals,
                 Monitor& monitor) {
        bent_ = &bent;
        std::vector<Bounds> bounds(set_.blocks.size());
        parallelFor(static_cast<std::int64_t>(bounds.size()), [&](std::int64_t b) {
            const auto block = static_cast<std::size_t>(b);
            bounds[block] = bentBoundsInSlab(set_, *bent_, set_.blocks[block], group.slabs[slab], firstColumn());
        });
        std::vector<DepositTotals> parts(group.tiles.size());
        parallelFor(static_cast<std::int64_t>(group.tiles.size()), [&](std::int64_t t) {
            monitor.checkCancelled();
            const auto tile = static_cast<std::size_t>(t);
            sumTile(group, group.tiles[tile], group.slabs[slab], bounds, parts[tile]);
        });
        addParts(parts, totals);
    }

private:
    static void addParts(const std::vector<DepositTotals>& parts, DepositTotals& totals) {
        for (const DepositTotals& part : parts) {
            totals.expected += part.expected;
            totals.degenerate += part.degenerate;
            totals.constant_leaves += part.constant_leaves;
        }
    }

    void findBounds(const std::vector<SlabGroup>& groups) {
        bounds_.resize(groups.size());
        parallelFor(static_cast<std::int64_t>(groups.size()), [&](std::int64_t i) {
            const auto g = static_cast<std::size_t>(i);
            if (groups[g].tiles.empty()) return;
            for (const Slab& slab : groups[g].slabs) {
                auto& row = bounds_[g].emplace_back(set_.blocks.size());
                for (std::size_t b = 0; b < set_.blocks.size(); ++b)
                    row[b] = boundsInSlab(set_, set_.blocks[b], slab, firstColumn());
            }
        });
    }

    glm::ivec2 firstColumn() const { return {field_.frame().min[axes_[0]], field_.frame().min[axes_[1]]}; }

    TileSums layOut(const SlabGroup& group, const SlabGroup::Tile& tile, const Slab& slab) const {
        TileSums sums;
        const GridFrame& frame = field_.frame();
        sums.lanes = slab.lanes, sums.active_lanes = slab.active, sums.first_w = slab.first;
        sums.channels = field_.channels().count(), sums.bent = bent_;
        int least[2] = {0, 0}, most[2] = {0, 0};
        for (int l = 0; l < slab.lanes; ++l) {
            // Past 32 voxels over a slab the buffer would leave the cache: let the tubes drift through it instead.
            const double along = l - 0.5 * (slab.lanes - 1);
            sums.shift_u[l] = static_cast<int>(std::lround(std::clamp(set_.meanSlopeU() * along, -16.0, 16.0)));
            sums.shift_v[l] = static_cast<int>(std::lround(std::clamp(set_.meanSlopeV() * along, -16.0, 16.0)));
            least[0] = std::min(least[0], sums.shift_u[l]), most[0] = std::max(most[0], sums.shift_u[l]);
            least[1] = std::min(least[1], sums.shift_v[l]), most[1] = std::max(most[1], sums.shift_v[l]);
        }
        sums.tile_min_u = std::max(tile.u, frame.min[axes_[0]]),
        sums.tile_min_v = std::max(tile.v, frame.min[axes_[1]]);
        sums.tile_max_u = std::min(tile.u + TileSums::kColumns, frame.max[axes_[0]] + 1);
        sums.tile_max_v = std::min(tile.v + TileSums::kColumns, frame.max[axes_[1]] + 1);
        // The buffer covers whole leaves; the voxels of the last ones outside the frame are dropped when they are
        // stored.
        const int end_u = tile.u + ((sums.tile_max_u - tile.u + 7) & ~7),
                  end_v = tile.v + ((sums.tile_max_v - tile.v + 7) & ~7);
        sums.u0 = tile.u - most[0], sums.columns = end_u - tile.u + most[0] - least[0];
        sums.v0 = tile.v - most[1], sums.rows = end_v - tile.v + most[1] - least[1];
        sums.rect_min_u = group.rectangle ? frame.min[axes_[0]] : sums.tile_min_u;
        sums.rect_min_v = group.rectangle ? frame.min[axes_[1]] : sums.tile_min_v;
        sums.rect_max_u = group.rectangle ? frame.max[axes_[0]] + 1 : sums.tile_max_u;
        sums.rect_max_v = group.rectangle ? frame.max[axes_[1]] + 1 : sums.tile_max_v;
        return sums;
    }

    void sumTile(const SlabGroup& group, const SlabGroup::Tile& tile, const Slab& slab,
                 const std::vector<Bounds>& bounds, DepositTotals& totals) {
        TileSums sums = layOut(group, tile, slab);
        thread_local std::vector<std::uint32_t> blocks;
        blocks.clear();
        // In the rectangle's outermost tiles, tubes that reach the frame only from outside are owned here too.
        const float low_u = static_cast<float>(tile.u - firstColumn().x) - 0.5f,
                    low_v = static_cast<float>(tile.v - firstColumn().y) - 0.5f;
        const float high_u = low_u + TileSums::kColumns, high_v = low_v + TileSums::kColumns;
        for (std::uint32_t b = 0; b < bounds.size(); ++b) {
            const Bounds& at = bounds[b];
            if (!at.empty() && at.max_u >= low_u && at.min_u <= high_u && at.max_v >= low_v && at.min_v <= high_v)
                blocks.push_back(b);
        }
        if (blocks.empty()) return;
        // Blocks of as many points together, in the order in which they came.
        std::stable_sort(blocks.begin(), blocks.end(),
                         [&](std::uint32_t a, std::uint32_t b) { return points_[a] < points_[b]; });
        if (options_.quadrature <= 1 && !bent_ && fillConstant(sums, tile, slab, blocks, totals)) return;
        if (block_keys_.empty()) {
            sumBlocks(sums, tile, slab, blocks, totals, nullptr);
            return;
        }
        const TileKey key = keyOf(sums, tile, slab, blocks);
        const KeptTiles::Found found = options_.kept->find(key);
        if (found.light) {
            layKept(*found.light, totals);
            return;
        }
        TileLight light;
        sumBlocks(sums, tile, slab, blocks, totals, found.wanted ? &light : nullptr);
        if (found.wanted) options_.kept->keep(key, std::move(light));
    }

    // All that a tile's light depends on, but for the grid and its needed voxels.
    TileKey keyOf(const TileSums& sums, const SlabGroup::Tile& tile, const Slab& slab,
                  const std::vector<std::uint32_t>& blocks) const {
        TileHash hash;
        for (const int number :
             {set_.axis, set_.sense, set_.channels, field_.channels().irradiance, int{field_.channels().flux},
              static_cast<int>(options_.kernel), static_cast<int>(options_.instruction_set), tile.u, tile.v, slab.first,
              slab.active, slab.lanes, sums.rect_min_u, sums.rect_min_v, sums.rect_max_u, sums.rect_max_v})
            hash.add(number);
        hash.add(options_.noise_floor);
        hash.add(sums.shift_u, sizeof(sums.shift_u)), hash.add(sums.shift_v, sizeof(sums.shift_v));
        for (const std::uint32_t b : blocks)
            hash.add(block_keys_[b].first), hash.add(block_keys_[b].second), hash.add(points_[b]);
        return hash.key();
    }

    void layKept(const TileLight& light, DepositTotals& totals) {
        const std::size_t values = static_cast<std::size_t>(field_.channels().count()) * LightField::kLeafVoxels;
        for (std::size_t i = 0; i < light.slots.size(); ++i) addToLeaf(light.slots[i], &light.values[i * values]);
        totals.expected += light.expected;
        totals.degenerate += light.degenerate;
    }

    /// @param kept  takes what is laid, where it is kept
    void sumBlocks(TileSums& sums, const SlabGroup::Tile& tile, const Slab& slab,
                   const std::vector<std::uint32_t>& blocks, DepositTotals& all_totals, TileLight* kept) {
        // One element more than the last cell's neighbour, so that every edge may write to the cell after its last.
        const std::size_t floats =
            static_cast<std::size_t>(sums.rows) * static_cast<std::size_t>(sums.rowStride()) + 64;
        thread_local std::vector<float> storage;
        if (storage.size() < floats + 16) storage.resize(floats + 16);
        auto address = reinterpret_cast<std::uintptr_t>(storage.data());
        sums.sums = reinterpret_cast<float*>((address + 63) & ~std::uintptr_t{63});
        std::memset(sums.sums, 0, floats * sizeof(float));

        const int irradiance = field_.channels().irradiance;
        const TileKernels kernels =
            tileKernels(options_.instruction_set, sums.lanes, irradiance, field_.channels().flux);
        for (auto first = blocks.begin(); first != blocks.end();) {
            const int points = points_[*first];
            const auto end = std::find_if(first, blocks.end(), [&](std::uint32_t b) { return points_[b] != points; });
            for (const auto& [offset, weight] : gaussPoints(points)) {
                sums.layer_offset = offset, sums.layer_weight = static_cast<float>(weight);
                const int count = static_cast<int>(end - first);
                if (options_.kernel == DepositKernel::Scalar) {
                    sums.running = false;
                    scalarKernel(set_, &*first, count, sums);
                } else {
                    kernels.edges(set_, &*first, count, sums);
                }
            }
            first = end;
        }
        if (sums.running) kernels.sum(sums);
        // Of the tile first, so that a tile that is kept counts to the same last digit.
        DepositTotals totals;
        totals.expected = sums.expected, totals.degenerate = sums.degenerate;
        storeLeaves(sums, tile, slab, kernels, totals, kept);
        all_totals.expected += totals.expected, all_totals.degenerate += totals.degenerate;
        if (kept) kept->expected = totals.expected, kept->degenerate = totals.degenerate;
    }

    bool fillConstant(const TileSums& sums, const SlabGroup::Tile& tile, const Slab& slab,
                      const std::vector<std::uint32_t>& blocks, DepositTotals& totals) {
        float values[6];
        if (!constantTile(set_, blocks, sums, values)) return false;
        const int channels = sums.channels;
        for (int k = 0; k < channels; ++k) values[k] *= scale_;
        double irradiance = 0;
        for (int k = 0; k < field_.channels().irradiance; ++k) irradiance += values[k] / field_.channels().irradiance;
        forEachLeaf(tile, sums, slab, [&](int slot, int, int, int leaf_w) {
            if (slot < 0) return;
            const bool whole = leaf_w >= slab.first && leaf_w + 8 <= slab.first + slab.active;
            if (whole && field_.needed().leafFull(slot) && field_.state(slot) == LeafState::Empty) {
                field_.setConstant(slot, {values, static_cast<std::size_t>(channels)});
                ++totals.constant_leaves;
                totals.expected += irradiance * field_.frame().voxelVolume() * LightField::kLeafVoxels;
                return;
            }
            float* out = field_.makeDense(slot);
            const NeededVoxels::Mask& mask = field_.needed().mask(slot);
            for (int i = 0; i < LightField::kLeafVoxels; ++i) {
                const int w = leaf_w + (set_.axis == 0 ? i >> 6 : set_.axis == 1 ? i >> 3 & 7 : i & 7);
                if (w < slab.first || w >= slab.first + slab.active || !NeededVoxels::maskBit(mask, i)) continue;
                for (int k = 0; k < channels; ++k) out[k * LightField::kLeafVoxels + i] += values[k];
                totals.expected += irradiance * field_.frame().voxelVolume();
            }
        });
        return true;
    }

    // Calls body(slot, u, v, w) for each leaf of the tile and slab, with the leaf's first voxel; slot -1: nobody needs
    // it.
    template <class Body>
    void forEachLeaf(const SlabGroup::Tile& tile, const TileSums& sums, const Slab& slab, const Body& body) const {
        for (int u = tile.u; u < sums.tile_max_u; u += 8)
            for (int v = tile.v; v < sums.tile_max_v; v += 8)
                for (int w = slab.first & ~7; w < slab.first + slab.active; w += 8) {
                    glm::ivec3 voxel;
                    voxel[axes_[0]] = u, voxel[axes_[1]] = v, voxel[axes_[2]] = w;
                    body(field_.needed().slotOf(voxel), u, v, w);
                }
    }

    void storeLeaves(const TileSums& sums, const SlabGroup::Tile& tile, const Slab& slab, const TileKernels& kernels,
                     DepositTotals& totals, TileLight* kept) {
        const int channels = sums.channels, irradiance = field_.channels().irradiance;
        alignas(64) float values[6 * LightField::kLeafVoxels];
        const float floor = static_cast<float>(options_.noise_floor * irradiance);
        forEachLeaf(tile, sums, slab, [&](int slot, int u, int v, int w) {
            const int lane = w - slab.first;
            const bool any = set_.axis == 2 ? kernels.leaf(sums, u, v, lane, irradiance, scale_, floor, values)
                                            : copyLeafSlowly(sums, u, v, lane, slab.active, floor, values);
            if (!any) return;
            if (slot < 0 || !field_.needed().leafFull(slot)) dropUnneeded(slot, glm::ivec3(u, v, w), values, totals);
            if (slot < 0) return;
            addToLeaf(slot, values);
            if (!kept) return;
            kept->slots.push_back(slot);
            kept->values.insert(kept->values.end(), values, values + channels * LightField::kLeafVoxels);
        });
    }

    void addToLeaf(int slot, const float* values) {
        const int count = field_.channels().count() * LightField::kLeafVoxels;
        bool was_empty = false;
        float* out = field_.makeDenseUninitialised(slot, was_empty);
        if (was_empty)
            std::memcpy(out, values, static_cast<std::size_t>(count) * sizeof(float));
        else
            for (int i = 0; i < count; ++i) out[i] += values[i];
    }

    // As LeafKernel, for the other axes.
    bool copyLeafSlowly(const TileSums& sums, int u, int v, int first_lane, int active, float floor, float* out) const {
        const int shift[3] = {6, 3, 0};
        const int irradiance = field_.channels().irradiance;
        bool any = false;
        std::memset(out, 0, static_cast<std::size_t>(sums.channels) * LightField::kLeafVoxels * sizeof(float));
        for (int l = std::max(0, -first_lane); l < std::min(8, active - first_lane); ++l) {
            const int lane = first_lane + l;
            for (int y = 0; y < 8; ++y) {
                const float* cell =
                    sums.sums + static_cast<std::ptrdiff_t>(v + y - sums.v0 - sums.shift_v[lane]) * sums.rowStride() +
                    static_cast<std::ptrdiff_t>(u - sums.u0 - sums.shift_u[lane]) * sums.cellStride() + lane;
                for (int x = 0; x < 8; ++x, cell += sums.cellStride()) {
                    float lit = 0;
                    for (int k = 0; k < irradiance; ++k) lit += cell[k * sums.lanes] * scale_;
                    if (!(lit > floor)) continue;
                    any = true;
                    const int at = x << shift[axes_[0]] | y << shift[axes_[1]] | l << shift[axes_[2]];
                    for (int k = 0; k < sums.channels; ++k)
                        out[k * LightField::kLeafVoxels + at] = cell[k * sums.lanes] * scale_;
                    if (sums.channels == irradiance) continue;
                    // Rounding must not make flux longer than the mean irradiance.
                    float* flux = out + irradiance * LightField::kLeafVoxels + at;
                    const float length =
                        std::hypot(flux[0], flux[LightField::kLeafVoxels], flux[2 * LightField::kLeafVoxels]);
                    if (length <= lit / static_cast<float>(irradiance)) continue;
                    for (int k = 0; k < 3; ++k)
                        flux[k * LightField::kLeafVoxels] *= lit / static_cast<float>(irradiance) / length;
                }
            }
        }
        return any;
    }

    // Light in voxels of the tile that nobody needs is taken off the ledger's expected side. What lies outside the
    // frame was never expected.
    void dropUnneeded(int slot, const glm::ivec3& leaf, float* values, DepositTotals& totals) const {
        const GridFrame& frame = field_.frame();
        const int channels = field_.channels().count(), irradiance = field_.channels().irradiance;
        double dropped = 0;
        for (int i = 0; i < LightField::kLeafVoxels; ++i) {
            if (slot >= 0 && NeededVoxels::maskBit(field_.needed().mask(slot), i)) continue;
            glm::ivec3 origin;
            for (int a = 0; a < 3; ++a) origin[axes_[static_cast<std::size_t>(a)]] = leaf[a];
            const glm::ivec3 voxel = origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
            bool inside = true;
            for (int a = 0; a < 3; ++a) inside = inside && voxel[a] >= frame.min[a] && voxel[a] <= frame.max[a];
            for (int k = 0; k < channels; ++k) {
                float& value = values[k * LightField::kLeafVoxels + i];
                if (inside && k < irradiance) dropped += static_cast<double>(value) / irradiance;
                value = 0;
            }
        }
        totals.expected -= dropped * frame.voxelVolume();
    }

    const TubeSet& set_;
    const BentRows* bent_ = nullptr;
    LightField& field_;
    const VoxeliseOptions& options_;
    std::array<int, 3> axes_;
    std::vector<int> points_;  // of each block
    float scale_;
    std::vector<std::vector<std::vector<Bounds>>> bounds_;  // group, slab, block
    std::vector<TileKey> block_keys_;                       // where tiles are kept
};

}  // namespace

int pointsAcrossLayer(double slope, bool has_edges) {
    const double one = has_edges ? 0.1 : 0.65, two = has_edges ? 0.3 : 1;
    return slope <= one ? 1 : slope <= two ? 2 : 4;
}

int pointsAcrossLayer(const TubeSet& tubes, bool has_edges) { return pointsAcrossLayer(tubes.rmsSlope(), has_edges); }

int pointsAcrossFacets(double slope) {
    // What a half plane of light is off by at a slope of one, root mean square over its places and directions: it goes
    // with the slope's square.
    struct Rule {
        int points;
        double error;
    };
    constexpr Rule kRules[] = {{1, 6.5e-2}, {2, 5.5e-3}, {4, 1.0e-3}, {6, 3.7e-4}, {8, 2.0e-4}};
    constexpr double kAllowed = 5e-4;
    for (const auto& [points, error] : kRules)
        if (error * slope * slope <= kAllowed) return points;
    return 12;
}

std::vector<int> pointsOfBlocks(const TubeSet& set, bool has_edges) {
    // What a point misplaces goes with the square of the slope, and counts by the light that is there. One instead of
    // two points saves little and misplaces more than all the rest: in an aquarium, whose light is thousands of faint
    // histories, it was 1.95 % off instead of 1.64.
    const int whole = pointsAcrossLayer(set, has_edges);
    std::vector<int> out(set.blocks.size());
    for (std::size_t b = 0; b < out.size(); ++b) {
        const TubeBlock& block = set.blocks[b];
        const double slope = std::sqrt(static_cast<double>(block.share)) * set.rmsSlope();
        out[b] = std::max(pointsAcrossLayer(slope, has_edges), std::min(2, whole));
        if (!block.faceted) continue;
        double squares = 0, power = 0;
        for (std::size_t t = 0; t < block.topology->triangles.size(); ++t) {
            const float* watts = set.tubes[block.first_tube + t].power;
            const double of_tube = set.channels == 3 ? watts[0] + watts[1] + watts[2] : watts[0];
            power += 3 * of_tube;
            for (const std::uint8_t corner : block.topology->triangles[t].corner) {
                const CornerRay& ray = set.corners[block.first_corner + corner];
                squares += of_tube * (ray.du_dw * ray.du_dw + ray.dv_dw * ray.dv_dw);
            }
        }
        if (power > 0) out[b] = pointsAcrossFacets(std::sqrt(squares / power));
    }
    return out;
}

void voxelise(const TubeSet& tubes, LightField& field, const VoxeliseOptions& options, DepositTotals& totals,
              Monitor& monitor) {
    if (tubes.empty()) return;
    Voxeliser(tubes, field, options).run(totals, monitor);
}

void voxeliseSlab(const TubeSet& tubes, const BentRows& bent, const SlabGroup& group, std::size_t slab,
                  LightField& field, const VoxeliseOptions& options, DepositTotals& totals, Monitor& monitor) {
    if (tubes.empty()) return;
    Voxeliser(tubes, field, options).runSlab(bent, group, slab, totals, monitor);
}

}  // namespace photic
