// SPDX-License-Identifier: Apache-2.0
#include "bake/deposit/strongest_arrival.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "bake/deposit/clip_triangle.h"
#include "bake/deposit/edge_kernel.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr double kOthersCount = 0.01;  // of a voxel's light

/// A box of cells of the launched front.
struct CellBox {
    glm::ivec2 low{0}, high{0};
    bool touches(const CellBox& b) const {
        return low.x <= b.high.x + 1 && b.low.x <= high.x + 1 && low.y <= b.high.y + 1 && b.low.y <= high.y + 1;
    }
    void add(const CellBox& b) {
        low = {std::min(low.x, b.low.x), std::min(low.y, b.low.y)};
        high = {std::max(high.x, b.high.x), std::max(high.y, b.high.y)};
    }
};

/// Numbers that are joined until all that hang together have one.
class Groups {
public:
    explicit Groups(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
    std::uint32_t of(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    /// The lower number stands for both.
    void join(std::uint32_t a, std::uint32_t b) {
        a = of(a), b = of(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

private:
    std::vector<std::uint32_t> parent_;
};

}  // namespace

void ArrivalSums::add(const ArrivalSums& o) {
    lit += o.lit, several += o.several, strongest_shares += o.strongest_shares, all += o.all, strongest += o.strongest;
    all_squares += o.all_squares, left_out_squares += o.left_out_squares;
}

/// A tube on one plane of a layer.
struct StrongestArrival::Landed {
    double x[3], y[3];  // [voxels] from the frame's first column and row
    double mean = 0;    // [W m], of the channels
    float amounts[6];   // [W m]
    glm::ivec2 cell{0};
    std::int32_t flipped = 0;
};

/// The part of a tube that lies in a voxel.
struct StrongestArrival::Piece {
    std::uint32_t column = 0;  // of the layer, row by row
    std::int32_t flipped = 0;
    glm::ivec2 cell{0};
    std::uint32_t landed = 0;  // in Layer::landed
    float share = 0;
    auto order() const { return std::tie(column, flipped, cell.y, cell.x, landed); }
};

/// All parts of an arrival in a voxel.
struct StrongestArrival::Arriving {
    std::uint32_t column = 0;
    std::int32_t flipped = 0;
    CellBox cells;
    double mean = 0;  // [W m], of the channels
    double amounts[6] = {};
};

/// What is in a voxel so far.
struct StrongestArrival::Kept {
    CellBox cells;
    std::uint32_t light = 0, front = 0;  // light 0: nothing is here yet
    std::int32_t flipped = 0;
    float mean = 0, total = 0;  // [W m]
};

/// What lands in one layer, sorted into strips of rows that lie in the same leaves of voxels: each is worked on by
/// itself, which bounds the pieces at hand.
struct StrongestArrival::Layer {
    int columns = 0;
    std::vector<RowRange> strips;
    std::vector<Landed> landed;
    std::vector<std::uint32_t> sorted;  // numbers of landed tubes, strip by strip
    std::vector<std::size_t> begins;    // of each strip in them, and their end
    double expected = 0;
};

StrongestArrival::StrongestArrival(std::shared_ptr<const NeededVoxels> needed, FieldChannels channels)
    : field_(std::move(needed), channels), kept_(static_cast<std::size_t>(field_.leafCount())) {}
StrongestArrival::~StrongestArrival() = default;
StrongestArrival::StrongestArrival(StrongestArrival&&) noexcept = default;

void StrongestArrival::land(std::span<const BentTubes> tubes, const Slab& slab, int lane,
                            std::span<const LayerPoint> points, Layer& out) const {
    const GridFrame& frame = field_.frame();
    const auto axes = axesFor(tubes.front().set.axis);
    out.columns = frame.max[axes[0]] - frame.min[axes[0]] + 1;
    const int first_row = frame.min[axes[1]], rows = frame.max[axes[1]] - first_row + 1;
    for (int row = 0; row < rows; ++row) {
        if (row == 0 || (first_row + row) % 8 == 0) out.strips.push_back({row, row});
        out.strips.back().end = row + 1;
    }
    struct Part {
        const BentTubes* of;
        const TubeBlock* block;
        std::vector<Landed> landed;
        double expected = 0;
    };
    std::vector<Part> parts;
    for (const BentTubes& of : tubes)
        for (const TubeBlock& block : of.set.blocks) parts.push_back({&of, &block, {}, 0});
    parallelFor(static_cast<std::int64_t>(parts.size()), [&](std::int64_t n) {
        Part& part = parts[static_cast<std::size_t>(n)];
        const BentTubes& of = *part.of;
        const double shift_u = of.bent.first_column[0] - frame.min[axes[0]] + 0.5,
                     shift_v = of.bent.first_column[1] - first_row + 0.5;
        forEachTube(of.set, *part.block, [&](const BentTube& tube) {
            for (const LayerPoint& point : points) {
                TubeOnLayer at;
                if (!crossLayer(of, tube, slab.first, lane, point, field_.channels(), at) || !(at.mean > 0)) continue;
                Landed landed{};
                for (int i = 0; i < 3; ++i) landed.x[i] = at.u[i] + shift_u, landed.y[i] = at.v[i] + shift_v;
                const double inside = fractionInside(landed.x, landed.y, out.columns, rows);
                if (!(inside > 0)) continue;
                landed.mean = at.mean;
                std::copy_n(at.amounts, field_.channels().count(), landed.amounts);
                landed.cell = of.cells[tube.number];
                landed.flipped = at.area2 * of.set.sense < 0 ? 1 : 0;
                part.landed.push_back(landed);
                part.expected += at.mean * inside;
            }
        });
    });
    for (const Part& part : parts) {
        out.landed.insert(out.landed.end(), part.landed.begin(), part.landed.end());
        out.expected += part.expected;
    }
    // Into strips, in the tubes' order.
    const auto stripsOf = [&](const Landed& landed) {
        const auto [least, most] = std::minmax({landed.y[0], landed.y[1], landed.y[2]});
        const auto strip = [&](double y) {
            const int row = static_cast<int>(std::clamp(std::floor(y), 0.0, rows - 1.0));
            return static_cast<std::size_t>(((first_row + row) >> 3) - (first_row >> 3));
        };
        return std::pair(strip(least), strip(most));
    };
    out.begins.assign(out.strips.size() + 1, 0);
    for (const Landed& landed : out.landed) {
        const auto [first, last] = stripsOf(landed);
        for (std::size_t s = first; s <= last; ++s) ++out.begins[s + 1];
    }
    std::partial_sum(out.begins.begin(), out.begins.end(), out.begins.begin());
    out.sorted.resize(out.begins.back());
    std::vector<std::size_t> next(out.begins.begin(), out.begins.end() - 1);
    for (std::uint32_t n = 0; n < out.landed.size(); ++n) {
        const auto [first, last] = stripsOf(out.landed[n]);
        for (std::size_t s = first; s <= last; ++s) out.sorted[next[s]++] = n;
    }
}

/// Pieces in the rows of a strip.
std::vector<StrongestArrival::Piece> StrongestArrival::gather(const Layer& layer, std::size_t strip) const {
    std::vector<Piece> pieces;
    for (std::size_t i = layer.begins[strip]; i < layer.begins[strip + 1]; ++i) {
        const Landed& landed = layer.landed[layer.sorted[i]];
        shareAmongCells(landed.x, landed.y, layer.columns, layer.strips[strip], [&](int row, int column, double share) {
            pieces.push_back({static_cast<std::uint32_t>(row * layer.columns + column), landed.flipped, landed.cell,
                              layer.sorted[i], static_cast<float>(share)});
        });
    }
    return pieces;
}

/// Joins the pieces that hang together in each voxel.
std::vector<StrongestArrival::Arriving> StrongestArrival::join(const Layer& layer, std::vector<Piece> pieces) const {
    std::vector<Arriving> arrivals;
    std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.order() < b.order(); });
    const auto precedes = [](const Piece& a, const glm::ivec2& cell) {
        return a.cell.y != cell.y ? a.cell.y < cell.y : a.cell.x < cell.x;
    };
    const int channels = field_.channels().count();
    for (std::size_t from = 0, to = 0; from < pieces.size(); from = to) {
        while (to < pieces.size() && pieces[to].column == pieces[from].column &&
               pieces[to].flipped == pieces[from].flipped)
            ++to;
        const auto first = pieces.begin() + static_cast<std::ptrdiff_t>(from),
                   last = pieces.begin() + static_cast<std::ptrdiff_t>(to);
        Groups groups(to - from);
        const auto joinWith = [&](std::uint32_t i, const glm::ivec2& cell) {
            const auto found = std::lower_bound(first, last, cell, precedes);
            if (found != last && found->cell == cell) groups.join(i, static_cast<std::uint32_t>(found - first));
        };
        for (std::uint32_t i = 0; i < to - from; ++i) {
            const glm::ivec2 cell = first[i].cell;
            if (i > 0 && first[i - 1].cell == cell) {
                groups.join(i - 1, i);
                continue;
            }
            for (const glm::ivec2& step : {glm::ivec2(-1, 0), {-1, -1}, {0, -1}, {1, -1}}) joinWith(i, cell + step);
        }
        std::vector<std::int64_t> arrival_of(to - from, -1);
        for (std::uint32_t i = 0; i < to - from; ++i) {
            const Piece& piece = first[i];
            std::int64_t& number = arrival_of[groups.of(i)];
            if (number < 0) {
                number = static_cast<std::int64_t>(arrivals.size());
                arrivals.push_back({piece.column, piece.flipped, {piece.cell, piece.cell}, 0, {}});
            }
            Arriving& arrival = arrivals[static_cast<std::size_t>(number)];
            const Landed& landed = layer.landed[piece.landed];
            arrival.cells.add({piece.cell, piece.cell});
            arrival.mean += double(piece.share) * landed.mean;
            for (int k = 0; k < channels; ++k) arrival.amounts[k] += double(piece.share) * double(landed.amounts[k]);
        }
    }
    return arrivals;
}

/// Keeps the strongest of each voxel.
void StrongestArrival::keep(const std::vector<Arriving>& arrivals, int axis, int w, double& left_out,
                            double& unneeded) {
    const NeededVoxels& needed = field_.needed();
    const GridFrame& frame = field_.frame();
    const auto axes = axesFor(axis);
    const auto columns = static_cast<std::uint32_t>(frame.max[axes[0]] - frame.min[axes[0]] + 1);
    const double per_volume = 1 / frame.voxelVolume();
    for (const Arriving& arrival : arrivals) {
        glm::ivec3 voxel;
        voxel[axes[0]] = frame.min[axes[0]] + static_cast<int>(arrival.column % columns);
        voxel[axes[1]] = frame.min[axes[1]] + static_cast<int>(arrival.column / columns);
        voxel[axes[2]] = w;
        const int slot = needed.slotOf(voxel), offset = NeededVoxels::offsetInLeaf(voxel);
        if (slot < 0 || !NeededVoxels::maskBit(needed.mask(slot), offset)) {
            unneeded += arrival.mean;
            continue;
        }
        auto& leaf = kept_[static_cast<std::size_t>(slot)];
        if (!leaf) leaf = std::make_unique<std::vector<Kept>>(LightField::kLeafVoxels);
        Kept& kept = (*leaf)[static_cast<std::size_t>(offset)];
        float* light = field_.makeDense(slot) + offset;
        const auto mean = static_cast<float>(arrival.mean);
        kept.total += mean;
        // The same sheet, that another front of this light brought as far as another part of the voxel.
        const bool same = kept.light == light_ && kept.front != front_ && kept.flipped == arrival.flipped &&
                          kept.cells.touches(arrival.cells);
        if (same) {
            kept.cells.add(arrival.cells), kept.mean += mean;
            for (int k = 0; k < field_.channels().count(); ++k)
                light[k * LightField::kLeafVoxels] += static_cast<float>(arrival.amounts[k] * per_volume);
        } else if (mean > kept.mean) {
            left_out += double(kept.mean);
            kept = {arrival.cells, light_, front_, arrival.flipped, mean, kept.total};
            for (int k = 0; k < field_.channels().count(); ++k)
                light[k * LightField::kLeafVoxels] = static_cast<float>(arrival.amounts[k] * per_volume);
        } else {
            left_out += arrival.mean;
        }
    }
}

void StrongestArrival::lay(std::span<const BentTubes> tubes, const Slab& slab, int points, DepositTotals& totals) {
    if (tubes.empty()) return;
    const std::vector<LayerPoint> rule = gaussPoints(points);
    for (int lane = 0; lane < slab.active; ++lane) {
        Layer layer;
        land(tubes, slab, lane, rule, layer);
        std::vector<double> left_out(layer.strips.size(), 0.0), unneeded(layer.strips.size(), 0.0);
        parallelFor(static_cast<std::int64_t>(layer.strips.size()), [&](std::int64_t n) {
            const auto strip = static_cast<std::size_t>(n);
            keep(join(layer, gather(layer, strip)), tubes.front().set.axis, slab.first + lane, left_out[strip],
                 unneeded[strip]);
        });
        totals.expected += layer.expected - std::accumulate(unneeded.begin(), unneeded.end(), 0.0);
        left_out_ += std::accumulate(left_out.begin(), left_out.end(), 0.0);
    }
}

ArrivalSums StrongestArrival::sums(double dark) const {
    const double per_volume = 1 / field_.frame().voxelVolume();
    std::vector<ArrivalSums> parts(kept_.size());
    parallelFor(static_cast<std::int64_t>(kept_.size()), [&](std::int64_t slot) {
        const auto& leaf = kept_[static_cast<std::size_t>(slot)];
        if (!leaf) return;
        ArrivalSums& part = parts[static_cast<std::size_t>(slot)];
        for (const Kept& kept : *leaf) {
            const double all = double(kept.total) * per_volume, strongest = double(kept.mean) * per_volume;
            if (!(all > dark)) continue;
            const double others = std::max(0.0, all - strongest);
            ++part.lit, part.all += all, part.strongest += strongest;
            part.all_squares += all * all, part.left_out_squares += others * others;
            if (others >= kOthersCount * all) ++part.several, part.strongest_shares += strongest / all;
        }
    });
    ArrivalSums sums;
    for (const ArrivalSums& part : parts) sums.add(part);
    return sums;
}

}  // namespace photic
