// SPDX-License-Identifier: Apache-2.0
#include "bake/field/two_levels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "bake/field/coarsen.h"
#include "bake/field/floor_div.h"
#include "bake/field/resample.h"

namespace photic {
namespace {

constexpr int kVoxels = LightField::kLeafVoxels;
constexpr int kNodes = 5;  // wide voxels along a leaf, its far side included

glm::ivec3 blockOf(const glm::ivec3& voxel) {
    glm::ivec3 block;
    for (int a = 0; a < 3; ++a) block[a] = floorDiv(voxel[a], CoarseBlocks::kSide);
    return block;
}

/// The wide voxels.
struct WideLight {
    const LightField& field;
    const RepeatingVoxels& repeats;
    float value(const glm::ivec3& node, int channel) const {
        return field.value(repeats.wrapped(2 * node) / 2, channel);  // exact: even voxels
    }
};

/// One channel of the coarse field, looked up at the 512 voxels of the fine leaf at `origin`.
void lookUpLeaf(const WideLight& coarse, const glm::ivec3& origin, int channel, float* out) {
    std::array<float, kNodes * kNodes * kNodes> nodes;
    const glm::ivec3 first = origin / 2;  // exact: multiples of 8
    std::size_t n = 0;
    for (int x = 0; x < kNodes; ++x)
        for (int y = 0; y < kNodes; ++y)
            for (int z = 0; z < kNodes; ++z) nodes[n++] = coarse.value(first + glm::ivec3(x, y, z), channel);
    const auto node = [&](int x, int y, int z) {
        return nodes[static_cast<std::size_t>((x * kNodes + y) * kNodes + z)];
    };
    for (int i = 0; i < kVoxels; ++i) {
        const int x = i >> 6, y = i >> 3 & 7, z = i & 7;
        float sum = 0;
        // Even voxels stand on a wide one; odd ones in the middle between two.
        for (int corner = 0; corner < 8; ++corner) {
            const int cx = (x + (corner >> 2 & 1)) / 2, cy = (y + (corner >> 1 & 1)) / 2, cz = (z + (corner & 1)) / 2;
            sum += node(cx, cy, cz);
        }
        out[i] = sum / 8;
    }
}

/// Of a leaf: sum over its needed voxels of the difference of the mean irradiance, and of flux where there is one.
double leafCost(const LightField& field, const WideLight& coarse, int slot) {
    const FieldChannels channels = field.channels();
    const glm::ivec3 origin = field.needed().leafOrigin(slot);
    const NeededVoxels::Mask& mask = field.needed().mask(slot);
    std::vector<float> wide(kVoxels);
    double cost = 0;
    for (int c = 0; c < channels.count(); ++c) {
        lookUpLeaf(coarse, origin, c, wide.data());
        double sum = 0;
        for (int i = 0; i < kVoxels; ++i) {
            if (!NeededVoxels::maskBit(mask, i)) continue;
            const float was = field.state(slot) == LeafState::Dense ? field.dense(slot)[c * kVoxels + i]
                              : field.state(slot) == LeafState::Empty
                                  ? 0.0f
                                  : field.constant(slot)[static_cast<std::size_t>(c)];
            sum += std::fabs(double(wide[static_cast<std::size_t>(i)]) - double(was));
        }
        // Half of it is the irradiance's, half the flux's.
        cost += sum / (c < channels.irradiance ? channels.irradiance : 3) / (channels.flux ? 2 : 1);
    }
    return cost;
}

/// Marks in a leaf's mask the voxels where any channel of a coarse look-up is not 0.
NeededVoxels::Mask litMask(const WideLight& coarse, const glm::ivec3& origin) {
    NeededVoxels::Mask mask{};
    std::array<float, kVoxels> wide;
    lookUpLeaf(coarse, origin, 0, wide.data());
    std::array<bool, kVoxels> lit{};
    for (int c = 0;; ++c) {
        for (std::size_t i = 0; i < kVoxels; ++i) lit[i] = lit[i] || wide[i] != 0;
        if (c + 1 >= coarse.field.channels().irradiance) break;
        lookUpLeaf(coarse, origin, c + 1, wide.data());
    }
    for (std::size_t i = 0; i < kVoxels; ++i)
        if (lit[i]) mask[i >> 6] |= std::uint64_t{1} << (i & 63);
    return mask;
}

/// The frame grown by the blocks that are marked.
GridFrame grown(GridFrame frame, const std::vector<glm::ivec3>& blocks) {
    for (const glm::ivec3& block : blocks) {
        frame.min = glm::min(frame.min, CoarseBlocks::kSide * block);
        frame.max = glm::max(frame.max, CoarseBlocks::kSide * (block + 1));
    }
    return frame;
}

/// Whether a voxel is in a marked block or on the far side of one.
bool inMarked(const CoarseBlocks& blocks, const RepeatingVoxels& repeats, const glm::ivec3& voxel) {
    constexpr int kSide = CoarseBlocks::kSide;
    const glm::ivec3 own = blockOf(voxel);
    for (int n = 0; n < 8; ++n) {
        const glm::ivec3 step(n & 1, n >> 1 & 1, n >> 2);
        glm::ivec3 block = own - step;
        bool shares = true;
        for (int a = 0; a < 3; ++a) {
            if (step[a] == 0) continue;
            shares = shares && voxel[a] == kSide * own[a];
            // Before the period's first block lies its last one, if it ends with a whole one.
            const bool begins = repeats.period[a] != 0 && voxel[a] == repeats.first[a];
            if (begins && repeats.period[a] % kSide == 0) block[a] += repeats.period[a] / kSide;
        }
        if (shares && blocks.has(block)) return true;
    }
    return false;
}

/// Whether the look-ups of a block stay within one period, of which the far end is the beginning again.
bool fits(const RepeatingVoxels& repeats, const glm::ivec3& block) {
    constexpr int kSide = CoarseBlocks::kSide;
    for (int a = 0; a < 3; ++a) {
        if (repeats.period[a] == 0) continue;
        if (kSide * block[a] < repeats.first[a]) return false;
        if (kSide * (block[a] + 1) > repeats.first[a] + repeats.period[a]) return false;
    }
    return true;
}

/// The field with what repeats going on for some voxels at both ends of a period.
LightField goneOn(const LightField& field, const RepeatingVoxels& repeats) {
    constexpr int kMargin = 16;  // what wide voxels at the seam depend on, to single precision
    GridFrame frame = field.frame();
    for (int a = 0; a < 3; ++a) {
        if (repeats.period[a] == 0) continue;
        frame.min[a] = std::min(frame.min[a], repeats.first[a] - kMargin);
        frame.max[a] = std::max(frame.max[a], repeats.first[a] + repeats.period[a] + kMargin);
    }
    NeededVoxels needed = NeededVoxels::none(frame);
    for (int x = frame.min.x; x <= frame.max.x; ++x)
        for (int y = frame.min.y; y <= frame.max.y; ++y)
            for (int z = frame.min.z; z <= frame.max.z; ++z)
                if (field.needed().contains(repeats.wrapped({x, y, z}))) needed.add({x, y, z});
    needed.finish();
    LightField out(std::make_shared<const NeededVoxels>(std::move(needed)), field.channels());
    forEachLeaf(out.needed(), [&](int slot) {
        const glm::ivec3 origin = out.needed().leafOrigin(slot);
        float* to = out.makeDense(slot);
        for (int i = 0; i < kVoxels; ++i) {
            if (!NeededVoxels::maskBit(out.needed().mask(slot), i)) continue;
            const glm::ivec3 from = repeats.wrapped(origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7));
            for (int c = 0; c < out.channels().count(); ++c) to[c * kVoxels + i] = field.value(from, c);
        }
    });
    return out;
}

LightField wideLight(const LightField& field, const RepeatingVoxels& repeats, const Monitor& monitor) {
    if (repeats.period == glm::ivec3(0)) return coarsened(field, 2, monitor, CoarseCentres::OnFineOnes);
    return coarsened(goneOn(field, repeats), 2, monitor, CoarseCentres::OnFineOnes);
}

void copyLeaf(const LightField& from, int slot, LightField& to, int to_slot) {
    if (from.state(slot) == LeafState::Empty) return;
    if (from.state(slot) == LeafState::Constant) {
        to.setConstant(to_slot, from.constant(slot));
    } else {
        std::copy_n(from.dense(slot), from.channels().count() * kVoxels, to.makeDense(to_slot));
    }
}

}  // namespace

glm::ivec3 RepeatingVoxels::wrapped(const glm::ivec3& voxel) const {
    glm::ivec3 out = voxel;
    for (int a = 0; a < 3; ++a)
        if (period[a] != 0) out[a] -= period[a] * floorDiv(voxel[a] - first[a], period[a]);
    return out;
}

TwoLevels::TwoLevels(const LightField& field, const LightField* second, const Monitor& monitor,
                     const RepeatingVoxels& repeats)
    : field_(field), second_(second), repeats_(repeats), coarse_(wideLight(field, repeats, monitor)) {
    if (second) coarse_second_ = wideLight(*second, repeats, monitor);
    // Leaves of light and their cost, for each block.
    std::map<std::tuple<int, int, int>, std::pair<int, double>> sums;
    const auto add = [&](const LightField& lobe, const LightField& coarse) {
        std::vector<double> costs(static_cast<std::size_t>(lobe.leafCount()), 0);
        forEachLeaf(lobe.needed(), [&](int slot) {
            if (lobe.state(slot) != LeafState::Empty)
                costs[static_cast<std::size_t>(slot)] = leafCost(lobe, {coarse, repeats_}, slot);
        });
        monitor.checkCancelled();
        for (int slot = 0; slot < lobe.leafCount(); ++slot) {
            if (lobe.state(slot) == LeafState::Empty) continue;
            const glm::ivec3 block = blockOf(lobe.needed().leafOrigin(slot));
            auto& [leaves, cost] = sums[{block.x, block.y, block.z}];
            ++leaves, cost += costs[static_cast<std::size_t>(slot)];
        }
    };
    add(field, coarse_);
    if (second) add(*second, *coarse_second_);
    for (const auto& [at, sum] : sums) {
        const glm::ivec3 block(std::get<0>(at), std::get<1>(at), std::get<2>(at));
        if (sum.first < 2 || !fits(repeats_, block)) continue;
        blocks_.push_back({block, sum.second / (sum.first - 1)});
    }
    std::stable_sort(blocks_.begin(), blocks_.end(), [](const Block& a, const Block& b) { return a.cost < b.cost; });
}

TwoLevels::Made TwoLevels::with(int count) const {
    std::vector<glm::ivec3> chosen;
    for (int i = 0; i < std::min(count, blockCount()); ++i) chosen.push_back(blocks_[static_cast<std::size_t>(i)].at);
    CoarseBlocks blocks;
    if (!chosen.empty()) {
        glm::ivec3 low = chosen.front(), high = chosen.front();
        for (const glm::ivec3& block : chosen) low = glm::min(low, block), high = glm::max(high, block);
        blocks = CoarseBlocks(low, high);
        for (const glm::ivec3& block : chosen) blocks.mark(block);
    }
    NeededVoxels needed = NeededVoxels::none(grown(field_.frame(), chosen));
    for (int slot = 0; slot < field_.leafCount(); ++slot)
        needed.addLeaf(field_.needed().leafOrigin(slot), field_.needed().mask(slot));
    // What the wide voxels reach beyond the given ones, far sides included.
    for (const glm::ivec3& block : chosen) {
        for (int n = 0; n < 27; ++n) {
            const glm::ivec3 step(n % 3, n / 3 % 3, n / 9);
            const glm::ivec3 origin = repeats_.wrapped(CoarseBlocks::kSide * block + 8 * step);
            NeededVoxels::Mask mask = litMask({coarse_, repeats_}, origin);
            if (coarse_second_) {
                const NeededVoxels::Mask other = litMask({*coarse_second_, repeats_}, origin);
                for (std::size_t w = 0; w < mask.size(); ++w) mask[w] |= other[w];
            }
            for (std::size_t i = 0; i < kVoxels; ++i) {
                const glm::ivec3 voxel(i >> 6, i >> 3 & 7, i & 7);
                for (int a = 0; a < 3; ++a)
                    if (step[a] == 2 && voxel[a] != 0) mask[i >> 6] &= ~(std::uint64_t{1} << (i & 63));
            }
            needed.addLeaf(origin, mask);
        }
    }
    needed.finish();

    const auto shared = std::make_shared<const NeededVoxels>(std::move(needed));
    const auto made = [&](const LightField& field, const LightField& coarse) {
        LightField out(shared, field.channels());
        forEachLeaf(out.needed(), [&](int slot) {
            const glm::ivec3 origin = out.needed().leafOrigin(slot);
            const int from = field.needed().slotOf(origin);
            if (from >= 0) copyLeaf(field, from, out, slot);
            std::array<bool, kVoxels> wide_here;
            bool any = false;
            for (std::size_t i = 0; i < kVoxels; ++i) {
                wide_here[i] = inMarked(blocks, repeats_, origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7));
                any = any || wide_here[i];
            }
            if (!any) return;
            const bool was_dark = out.state(slot) == LeafState::Empty;
            float* to = out.makeDense(slot);
            std::array<float, kVoxels> wide;
            bool lit = !was_dark;
            for (int c = 0; c < out.channels().count(); ++c) {
                lookUpLeaf({coarse, repeats_}, origin, c, wide.data());
                for (std::size_t i = 0; i < kVoxels; ++i) {
                    if (!wide_here[i]) continue;
                    to[static_cast<std::size_t>(c) * kVoxels + i] = wide[i];
                    lit = lit || wide[i] != 0;
                }
            }
            if (!lit) out.setEmpty(slot);  // of a second lobe most are
        });
        return out;
    };
    Made out{made(field_, coarse_), std::nullopt, {}};
    if (second_) out.second = made(*second_, *coarse_second_);
    out.blocks = std::move(blocks);
    return out;
}

}  // namespace photic
