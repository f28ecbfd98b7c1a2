// SPDX-License-Identifier: Apache-2.0
#include "bake/field/disc_blur.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <vector>

#include "bake/field/leaf_stencil.h"
#include "bake/report/error.h"
#include "bake/simd/dispatch.h"
#include "bake/threads/parallel_for.h"

namespace photic {

PHOTIC_PER_SET(void convolveLeaf(const LeafStencil& stencil, const float* tile, float* out))

namespace {

constexpr double kSmallest = 0.02;  // [voxels] changes a voxel by less than 1e-4 of its neighbours' difference
constexpr int kLargest = 64;        // [voxels]
constexpr int kLanes = LeafStencil::kLayers;

// Share of an evenly bright disc of radius `radius` that lies left of x.
double semicircleBelow(double x, double radius) {
    const double t = std::clamp(x / radius, -1.0, 1.0);
    return 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / std::numbers::pi;
}

// Second moment of a disc whose light is moved to the middles of the voxels that it falls in.
double momentOnVoxels(double radius) {
    double sum = 0;
    for (int k = 1; k <= static_cast<int>(std::ceil(radius)); ++k)
        sum += 2.0 * k * k * (semicircleBelow(k + 0.5, radius) - semicircleBelow(k - 0.5, radius));
    return sum;
}

// The radius for which that is radius^2 / 4, the disc's own. It grows with the radius: bisection.
double radiusForMoment(double radius) {
    const double target = 0.25 * radius * radius;
    double low = 0.5, high = radius + 1;  // up to 1/2 all light stays in one voxel
    for (int i = 0; i < 60; ++i) (momentOnVoxels(0.5 * (low + high)) < target ? low : high) = 0.5 * (low + high);
    return 0.5 * (low + high);
}

/// The disc on a layer as chords along y.
struct Ellipse {
    double wide_x;       ///< half, along x
    double slope, half;  ///< of the middle of a chord, and of its greatest length, along y
    bool wide;           ///< along x; else it is a line
};

/// Spreads the part of the disc that lies in the column of voxels at `i` over them: in strips of x = wide_x sin(t),
/// each of which has a share of 2/pi cos^2(t) dt, spread evenly over its chord.
/// @param column  the column's middle voxel
void spreadColumn(const Ellipse& e, int i, int radius, double* column) {
    constexpr int kStrips = 48;  // a voxel
    const double t0 = std::asin(std::clamp((i - 0.5) / e.wide_x, -1.0, 1.0)),
                 t1 = std::asin(std::clamp((i + 0.5) / e.wide_x, -1.0, 1.0));
    const double share =
        e.wide ? semicircleBelow(i + 0.5, e.wide_x) - semicircleBelow(i - 0.5, e.wide_x) : (i == 0 ? 1.0 : 0.0);
    if (share <= 0) return;
    double total = 0;
    for (int s = 0; s < kStrips; ++s) {
        const double t = t0 + (t1 - t0) * (s + 0.5) / kStrips;
        total += std::cos(t) * std::cos(t);
    }
    for (int s = 0; s < kStrips; ++s) {
        const double t = t0 + (t1 - t0) * (s + 0.5) / kStrips, cos_t = std::cos(t);
        const double strip = share * cos_t * cos_t / total;
        const double middle = e.slope * e.wide_x * std::sin(t), reach_of_chord = std::max(e.half * cos_t, 1e-9);
        const double y0 = middle - reach_of_chord, y1 = middle + reach_of_chord;
        for (int j = static_cast<int>(std::floor(y0 + 0.5)); j <= static_cast<int>(std::floor(y1 + 0.5)); ++j) {
            const double overlap = std::min(y1, j + 0.5) - std::max(y0, j - 0.5);
            column[std::clamp(j, -radius, radius)] += strip * std::max(overlap, 0.0) / (2 * reach_of_chord);
        }
    }
}

/// The same on both sides to the last bit, and a sum of 1.
void evenOut(std::vector<double>& weights) {
    const std::size_t size = weights.size();
    double sum = 0;
    for (std::size_t i = 0; i < size / 2; ++i) {
        const double mean = 0.5 * (weights[i] + weights[size - 1 - i]);
        weights[i] = weights[size - 1 - i] = mean;
        sum += 2 * mean;
    }
    sum += weights[size / 2];
    for (double& w : weights) w /= sum;
}

}  // namespace

DiscStencil discStencil(const LayerKernel& kernel) {
    const glm::dmat2& a = kernel.disc_from_unit;
    // How far the ellipse reaches along x and along y.
    const double reach_x = std::hypot(a[0].x, a[1].x), reach_y = std::hypot(a[0].y, a[1].y);
    const double reach = std::max(reach_x, reach_y);
    if (!(reach <= kLargest))
        throw Error(ErrorCode::Input,
                    fmt::format("the light's disc covers {:.3g} voxels either way at its widest, more than {}; use a "
                                "smaller angular_diameter or larger voxels",
                                reach, kLargest));
    DiscStencil stencil;
    if (reach < kSmallest) return stencil;

    // Widened or narrowed along x and y for the right second moments; then C = M M^T describes the ellipse.
    const double wide_x = radiusForMoment(std::max(reach_x, 1e-9)), wide_y = radiusForMoment(std::max(reach_y, 1e-9));
    const double stretch_x = reach_x > 0 ? wide_x / reach_x : 1, stretch_y = reach_y > 0 ? wide_y / reach_y : 1;
    const double c_xy = stretch_x * stretch_y * (a[0].x * a[0].y + a[1].x * a[1].y);
    const double c_yy = reach_y > 0 ? wide_y * wide_y : 0;
    const double slope = c_xy / (wide_x * wide_x), half = std::sqrt(std::max(c_yy - slope * c_xy, 0.0));

    stencil.radius = std::max(1, static_cast<int>(std::ceil(std::max(wide_x, wide_y) - 0.5)));
    const int width = 2 * stencil.radius + 1;
    stencil.weights.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(width), 0.0);
    const Ellipse ellipse{wide_x, slope, half, reach_x > 0};
    for (int i = -stencil.radius; i <= stencil.radius; ++i)
        spreadColumn(ellipse, i, stencil.radius,
                     stencil.weights.data() + (i + stencil.radius) * width + stencil.radius);
    evenOut(stencil.weights);
    return stencil;
}

namespace {

LeafStencil leafStencil(int z_origin, int z_min, int z_max, const std::function<LayerKernel(int)>& kernel_of_layer) {
    std::array<DiscStencil, kLanes> layers;
    LeafStencil out;
    for (int k = 0; k < kLanes; ++k) {
        if (z_origin + k < z_min || z_origin + k > z_max) continue;
        layers[static_cast<std::size_t>(k)] = discStencil(kernel_of_layer(z_origin + k));
        out.radius = std::max(out.radius, layers[static_cast<std::size_t>(k)].radius);
    }
    for (int dx = -out.radius; dx <= out.radius; ++dx)
        for (int dy = -out.radius; dy <= out.radius; ++dy) {
            LeafStencil::Tap tap{dx, dy, {}};
            bool any = false;
            for (int k = 0; k < kLanes; ++k) {
                tap.weight[k] = static_cast<float>(layers[static_cast<std::size_t>(k)].at(dx, dy));
                any |= tap.weight[k] > 0;
            }
            if (any) out.taps.push_back(tap);
        }
    return out;
}

// Leaves of one leaf layer, with copies of those that hold light.
struct LeafLayer {
    std::vector<int> slots;
    std::vector<float> before;           // channels x 512 for each lit leaf, in slot order
    std::vector<std::int32_t> lit;       // per entry of `slots`: its place in `before`, or -1
    std::vector<std::uint8_t> constant;  // per entry of `slots`: it was Constant
};

// What the 8 + 2 radius columns around a leaf hold, cut from the nine or more leaves that they lie in.
class TileReader {
public:
    TileReader(const LightField& field, const LeafLayer& layer, const std::vector<std::int32_t>& place_of_slot,
               int radius)
        : field_(field), layer_(layer), place_of_slot_(place_of_slot), radius_(radius), side_(8 + 2 * radius) {
        tile_.resize(static_cast<std::size_t>(side_ * side_ * kLanes));
    }
    /// False when the blur changes nothing: no leaf around holds light, or all hold the same constant.
    /// `all_needed`: every voxel of the tile is.
    bool locate(const glm::ivec3& origin, bool& all_needed) {
        const int reach = (radius_ + 7) / 8;
        slots_.clear();
        bool light = false;
        all_needed = true;
        for (int x = -reach; x <= reach; ++x)
            for (int y = -reach; y <= reach; ++y) {
                const int slot = field_.needed().slotOf(origin + glm::ivec3(8 * x, 8 * y, 0));
                slots_.push_back({8 * x, 8 * y, slot});
                light |= slot >= 0 && litPlace(slot) >= 0;
                all_needed &= slot >= 0 && field_.needed().leafFull(slot);
            }
        return light && !(all_needed && sameConstant());
    }
    const float* channel(int c, int channels) {
        return gather([&](int slot, int column, float* to) {
            const std::int32_t place = slot >= 0 ? litPlace(slot) : -1;
            if (place < 0)
                std::fill_n(to, kLanes, 0.0f);
            else
                std::memcpy(
                    to,
                    layer_.before.data() +
                        (std::size_t(place) * std::size_t(channels) + std::size_t(c)) * LightField::kLeafVoxels +
                        column * kLanes,
                    kLanes * sizeof(float));
        });
    }
    const float* needed() {
        return gather([&](int slot, int column, float* to) {
            for (int k = 0; k < kLanes; ++k)
                to[k] =
                    slot >= 0 && NeededVoxels::maskBit(field_.needed().mask(slot), column * kLanes + k) ? 1.0f : 0.0f;
        });
    }

private:
    std::int32_t litPlace(int slot) const {
        return layer_.lit[static_cast<std::size_t>(place_of_slot_[static_cast<std::size_t>(slot)])];
    }
    bool sameConstant() const {
        const auto channels = static_cast<std::size_t>(field_.channels().count());
        const auto first = [&](int slot, std::size_t c) {
            return layer_.before[(static_cast<std::size_t>(litPlace(slot)) * channels + c) * LightField::kLeafVoxels];
        };
        for (const auto& leaf : slots_) {
            if (!layer_.constant[static_cast<std::size_t>(place_of_slot_[static_cast<std::size_t>(leaf.slot)])])
                return false;
            for (std::size_t c = 0; c < channels; ++c)
                if (first(leaf.slot, c) != first(slots_.front().slot, c)) return false;
        }
        return true;
    }
    template <class Column>
    const float* gather(Column column) {
        for (const auto& leaf : slots_)
            for (int x = 0; x < 8; ++x) {
                const int tx = leaf.x + x + radius_;
                if (tx < 0 || tx >= side_) continue;
                for (int y = std::max(0, -radius_ - leaf.y); y < std::min(8, side_ - radius_ - leaf.y); ++y)
                    column(leaf.slot, x * 8 + y, tile_.data() + (tx * side_ + leaf.y + y + radius_) * kLanes);
            }
        return tile_.data();
    }
    struct Neighbour {
        int x, y, slot;
    };
    const LightField& field_;
    const LeafLayer& layer_;
    const std::vector<std::int32_t>& place_of_slot_;
    int radius_, side_;
    std::vector<Neighbour> slots_;
    std::vector<float> tile_;
};

/// How the leaves of one layer are blurred.
struct LayerBlur {
    const LeafStencil& stencil;
    BeyondNeeded beyond;
    ConvolveLeaf convolve;
};

void blurLeaf(LightField& field, int slot, const LayerBlur& blur, TileReader& tiles) {
    bool all_needed = true;
    if (!tiles.locate(field.needed().leafOrigin(slot), all_needed)) return;
    const int channels = field.channels().count();
    alignas(64) float known[LightField::kLeafVoxels];
    const bool rescale = blur.beyond == BeyondNeeded::Alike && !all_needed;
    if (rescale) blur.convolve(blur.stencil, tiles.needed(), known);
    bool was_empty = false;
    float* leaf = field.makeDenseUninitialised(slot, was_empty);
    for (int c = 0; c < channels; ++c) {
        float* out = leaf + c * LightField::kLeafVoxels;
        blur.convolve(blur.stencil, tiles.channel(c, channels), out);
        if (rescale)
            for (int i = 0; i < LightField::kLeafVoxels; ++i) out[i] = known[i] > 0 ? out[i] / known[i] : 0.0f;
    }
    if (field.needed().leafFull(slot)) return;
    const auto& mask = field.needed().mask(slot);
    for (int c = 0; c < channels; ++c)
        for (int i = 0; i < LightField::kLeafVoxels; ++i)
            if (!NeededVoxels::maskBit(mask, i)) leaf[c * LightField::kLeafVoxels + i] = 0;
}

/// Leaves that a thread takes at once.
constexpr std::int64_t kLeavesAtOnce = 16;

/// Copies the light of a leaf, 0 where no voxel is needed.
void copyLight(const LightField& field, int slot, float* to) {
    const auto channels = static_cast<std::size_t>(field.channels().count());
    const auto& mask = field.needed().mask(slot);
    for (std::size_t c = 0; c < channels; ++c, to += LightField::kLeafVoxels) {
        if (field.state(slot) == LeafState::Dense)
            std::memcpy(to, field.dense(slot) + c * LightField::kLeafVoxels, sizeof(float) * LightField::kLeafVoxels);
        else
            std::fill_n(to, LightField::kLeafVoxels, field.constant(slot)[c]);
        if (field.needed().leafFull(slot)) continue;
        for (int v = 0; v < LightField::kLeafVoxels; ++v)
            if (!NeededVoxels::maskBit(mask, v)) to[v] = 0;
    }
}

/// Fills `layer` from the leaves `slots`.
void copyLayer(const LightField& field, std::vector<int> slots, LeafLayer& layer) {
    layer.slots = std::move(slots);
    layer.lit.assign(layer.slots.size(), -1);
    layer.constant.assign(layer.slots.size(), 0);
    std::int32_t lit = 0;
    for (std::size_t i = 0; i < layer.slots.size(); ++i) {
        if (field.state(layer.slots[i]) != LeafState::Empty) layer.lit[i] = lit++;
        layer.constant[i] = field.state(layer.slots[i]) == LeafState::Constant;
    }
    const std::size_t leaf_floats = static_cast<std::size_t>(field.channels().count()) * LightField::kLeafVoxels;
    layer.before.resize(static_cast<std::size_t>(lit) * leaf_floats);
    const auto count = static_cast<std::int64_t>(layer.slots.size());
    parallelFor((count + kLeavesAtOnce - 1) / kLeavesAtOnce, [&](std::int64_t block) {
        for (auto i = static_cast<std::size_t>(block * kLeavesAtOnce);
             i < static_cast<std::size_t>(std::min(count, (block + 1) * kLeavesAtOnce)); ++i)
            if (layer.lit[i] >= 0)
                copyLight(field, layer.slots[i],
                          layer.before.data() + static_cast<std::size_t>(layer.lit[i]) * leaf_floats);
    });
}

double irradianceSum(const LightField& field) {
    double sum = 0;
    for (int c = 0; c < field.channels().irradiance; ++c) sum += field.sum(c);
    return sum;
}

}  // namespace

double blurLayers(LightField& field, const std::function<LayerKernel(int k)>& kernel_of_layer, BeyondNeeded beyond) {
    const double before = irradianceSum(field);
    const NeededVoxels& needed = field.needed();
    const ConvolveLeaf convolve = PHOTIC_CHOOSE(bestInstructionSet(), convolveLeaf);
    std::map<int, std::vector<int>> slots_of_layer;
    std::vector<std::int32_t> place_of_slot(static_cast<std::size_t>(needed.leafCount()));
    for (int slot = 0; slot < needed.leafCount(); ++slot) {
        auto& slots = slots_of_layer[needed.leafOrigin(slot).z];
        place_of_slot[static_cast<std::size_t>(slot)] = static_cast<std::int32_t>(slots.size());
        slots.push_back(slot);
    }
    // All stencils first: the eight layers of each leaf layer.
    std::vector<int> origins;
    for (const auto& [z, slots] : slots_of_layer) origins.push_back(z);
    std::vector<LeafStencil> stencils(origins.size());
    parallelFor(static_cast<std::int64_t>(origins.size()), [&](std::int64_t i) {
        stencils[static_cast<std::size_t>(i)] = leafStencil(origins[static_cast<std::size_t>(i)], field.frame().min.z,
                                                            field.frame().max.z, kernel_of_layer);
    });

    LeafLayer layer;
    for (std::size_t l = 0; l < origins.size(); ++l) {
        if (stencils[l].radius == 0) continue;
        copyLayer(field, std::move(slots_of_layer[origins[l]]), layer);
        const LayerBlur blur{stencils[l], beyond, convolve};
        const auto count = static_cast<std::int64_t>(layer.slots.size());
        parallelFor((count + kLeavesAtOnce - 1) / kLeavesAtOnce, [&](std::int64_t block) {
            TileReader tiles(field, layer, place_of_slot, stencils[l].radius);
            for (auto i = block * kLeavesAtOnce; i < std::min(count, (block + 1) * kLeavesAtOnce); ++i)
                blurLeaf(field, layer.slots[static_cast<std::size_t>(i)], blur, tiles);
        });
    }
    const double after = irradianceSum(field);
    return before > 0 ? after / before - 1 : 0.0;
}

}  // namespace photic
