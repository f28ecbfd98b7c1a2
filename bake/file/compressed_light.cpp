// SPDX-License-Identifier: Apache-2.0
#include "bake/file/compressed_light.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>

#include "bake/field/floor_div.h"
#include "bake/file/brick_pages.h"
#include "bake/file/runtime_size.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"
#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

constexpr int kVoxels = LightField::kLeafVoxels, kSide = 9, kPitch = 12;
using Rgb = std::array<float, 3>;

/// Flux, and the irradiance of three channels, of one voxel in units of the reference.
struct VoxelLight {
    glm::dvec3 flux{0};
    Rgb colour{};
};

/// One lobe's light at the voxels that are active; dark elsewhere.
class Lobe {
public:
    Lobe(LightField& field, const std::vector<ActiveLeaf>& leaves, double reference)
        : field_(field), masks_(static_cast<std::size_t>(field.leafCount()), nullptr), scale_(1 / reference) {
        for (const ActiveLeaf& leaf : leaves)
            if (leaf.slot >= 0) masks_[static_cast<std::size_t>(leaf.slot)] = &leaf.mask;
    }
    LightField& field() { return field_; }
    const NeededVoxels::Mask* mask(int slot) const { return masks_[static_cast<std::size_t>(slot)]; }
    double scale() const { return scale_; }

    VoxelLight inLeaf(int slot, int i) const {
        VoxelLight light;
        if (field_.state(slot) == LeafState::Empty) return light;
        const bool dense = field_.state(slot) == LeafState::Dense;
        const auto channel = [&](int c) {
            const float v = dense ? field_.dense(slot)[c * kVoxels + i] : field_.constant(slot)[std::size_t(c)];
            return std::clamp(double(v) * scale_, -double(format::kLargest), double(format::kLargest));
        };
        const int colours = field_.channels().irradiance;
        for (int c = 0; c < 3; ++c) {
            light.colour[static_cast<std::size_t>(c)] = static_cast<float>(channel(colours == 3 ? c : 0));
            light.flux[c] = channel(colours + c);
        }
        return light;
    }
    void set(int slot, int i, const VoxelLight& light) {
        float* to = field_.dense(slot) + i;
        const int colours = field_.channels().irradiance;
        for (int c = 0; c < colours; ++c)
            to[c * kVoxels] = static_cast<float>(double(light.colour[static_cast<std::size_t>(c)]) / scale_);
        for (int c = 0; c < 3; ++c) to[(colours + c) * kVoxels] = static_cast<float>(light.flux[c] / scale_);
    }

private:
    LightField& field_;
    std::vector<const NeededVoxels::Mask*> masks_;
    double scale_;
};

/// Looks voxels up one after the other, most of them in the leaf of the one before.
class LobeReader {
public:
    explicit LobeReader(const Lobe& lobe, const NeededVoxels& needed) : lobe_(lobe), needed_(needed) {}
    VoxelLight at(const glm::ivec3& voxel) {
        const glm::ivec3 origin(voxel.x & ~7, voxel.y & ~7, voxel.z & ~7);
        if (origin != origin_ || !known_) origin_ = origin, slot_ = needed_.slotOf(origin), known_ = true;
        if (slot_ < 0) return {};
        const NeededVoxels::Mask* mask = lobe_.mask(slot_);
        const int i = NeededVoxels::offsetInLeaf(voxel);
        return mask != nullptr && NeededVoxels::maskBit(*mask, i) ? lobe_.inLeaf(slot_, i) : VoxelLight{};
    }

private:
    const Lobe& lobe_;
    const NeededVoxels& needed_;
    glm::ivec3 origin_{0};
    int slot_ = -1;
    bool known_ = false;
};

glm::dvec3 mirrored(const glm::dvec3& v, const glm::dvec3& mirror) { return v - 2 * glm::dot(mirror, v) * mirror; }

/// What takes the mean direction of a lobe to (1, 1, 1).
void chooseMirror(const Lobe& lobe, const std::vector<ActiveLeaf>& leaves, CompressedLight& out) {
    glm::dvec3 sum(0);
    for (const ActiveLeaf& leaf : leaves) {
        if (leaf.slot < 0) continue;
        for (int i = 0; i < kVoxels; ++i)
            if (NeededVoxels::maskBit(leaf.mask, i)) sum += lobe.inLeaf(leaf.slot, i).flux;
    }
    const glm::dvec3 along(1 / std::sqrt(3.0));
    const double length = glm::length(sum);
    const glm::dvec3 axis = length > 0 ? sum / length : along, to = axis - along;
    out.mirror = glm::length(to) > 1e-6 ? glm::normalize(to) : glm::dvec3(0);
    // As a game multiplies with it.
    for (int a = 0; a < 3; ++a) out.mirror[a] = double(static_cast<float>(out.mirror[a]));
}

/// Where the voxels of the textures come from, and go.
class Compressor {
public:
    Compressor(Lobe& lobe, CompressedLight& out) : lobe_(lobe), out_(out) {
        wide_ = (out.texels.x + 3) / 4, high_ = (out.texels.y + 3) / 4;
        const auto blocks = std::size_t(wide_) * std::size_t(high_) * std::size_t(out.texels.z);
        out.flux.resize(16 * blocks), out.colour.resize(16 * blocks);
    }

    /// The voxel that a texel stands for, or nothing: padding.
    bool voxelOf(const glm::ivec3& texel, glm::ivec3& voxel) const {
        if (out_.one_box) {
            voxel = out_.first + texel;
            return glm::all(glm::lessThan(texel, out_.texels));
        }
        if (texel.x >= kSide || texel.y >= kSide) return false;
        const CompressedLight::Brick& brick = out_.bricks[static_cast<std::size_t>(texel.z / kSide)];
        const glm::ivec3 page(brick.page[0], brick.page[1], brick.page[2]);
        voxel = 8 * page + brick.step * glm::ivec3(texel.x, texel.y, texel.z % kSide);
        return true;
    }

    /// What both textures hold in a block's texels, with the bias.
    struct Pair {
        Bc6hTexels flux, colour;
    };
    Pair texelsOf(LobeReader& reader, int bx, int by, int z) const {
        Pair out;
        out.flux.used = 0;
        for (std::size_t n = 0; n < 16; ++n) {
            glm::ivec3 voxel;
            if (!voxelOf({4 * bx + static_cast<int>(n % 4), 4 * by + static_cast<int>(n / 4), z}, voxel)) continue;
            out.flux.used = static_cast<std::uint16_t>(out.flux.used | 1U << n);
            const VoxelLight light = reader.at(voxel);
            const glm::dvec3 stored = mirrored(light.flux, out_.mirror) + double(out_.bias);
            for (std::size_t c = 0; c < 3; ++c) {
                out.flux.rgb[n][c] = static_cast<float>(stored[static_cast<int>(c)]);
                out.colour.rgb[n][c] = light.colour[c] + out_.bias;
            }
        }
        out.colour.used = out.flux.used;
        return out;
    }

    /// Chooses the bias, and whether flux needs a sign, by what some of the blocks with light lose.
    void chooseBias() {
        double mean = 0, lit = 0;
        std::vector<glm::ivec3> blocks;
        LobeReader reader(lobe_, lobe_.field().needed());
        constexpr int kBlocks = 1500, kTries = 40 * kBlocks;
        const auto all = std::int64_t(wide_) * high_ * out_.texels.z;
        for (int n = 0; n < kTries && static_cast<int>(blocks.size()) < kBlocks; ++n) {
            // Evenly over the volume, in an order that meets no pattern of it.
            const auto at = static_cast<std::int64_t>(std::fmod(0.5 + n * 0.6180339887498949, 1.0) * double(all));
            const glm::ivec3 block(int(at % wide_), int(at / wide_ % high_), int(at / wide_ / high_));
            const Pair texels = texelsOf(reader, block.x, block.y, block.z);
            double sum = 0;
            for (std::size_t i = 0; i < 16; ++i) sum += double(texels.colour.rgb[i][0] + texels.colour.rgb[i][1]);
            if (sum <= 0) continue;
            blocks.push_back(block), mean += sum / 32, lit += 1;
        }
        if (lit == 0) return;
        mean /= lit;
        double least = std::numeric_limits<double>::infinity();
        float bias = 0;
        Bc6hSign flux_sign = Bc6hSign::Signed;
        for (const int part : {0, 64, 32, 16, 8, 4, 2, 1}) {
            // Powers of two, which halves hold.
            out_.bias = part == 0 ? 0.0F : std::ldexp(1.0F, std::max(-14, std::ilogb(mean / part)));
            for (const Bc6hSign sign : {Bc6hSign::Unsigned, Bc6hSign::Signed}) {
                out_.flux_sign = sign;
                double off = 0;
                for (const glm::ivec3& block : blocks) {
                    const Pair texels = texelsOf(reader, block.x, block.y, block.z);
                    off += difference(texels.flux, sign) + difference(texels.colour, Bc6hSign::Unsigned);
                }
                if (off < least) least = off, bias = out_.bias, flux_sign = sign;
            }
        }
        out_.bias = bias, out_.flux_sign = flux_sign;
    }

    /// One layer of blocks.
    void encodeLayer(int z) {
        LobeReader reader(lobe_, lobe_.field().needed());
        for (int by = 0; by < high_; ++by)
            for (int bx = 0; bx < wide_; ++bx) {
                const Pair texels = texelsOf(reader, bx, by, z);
                if (texels.flux.used == 0) continue;
                const std::size_t at = 16 * blockAt(bx, by, z);
                const Bc6hBlock f = encodeBc6h(texels.flux, out_.flux_sign),
                                c = encodeBc6h(texels.colour, Bc6hSign::Unsigned);
                std::copy(f.begin(), f.end(), out_.flux.begin() + static_cast<std::ptrdiff_t>(at));
                std::copy(c.begin(), c.end(), out_.colour.begin() + static_cast<std::ptrdiff_t>(at));
            }
    }

    std::size_t blockAt(int bx, int by, int z) const {
        return (std::size_t(z) * std::size_t(high_) + std::size_t(by)) * std::size_t(wide_) + std::size_t(bx);
    }

private:
    /// What a block loses: the sum of absolute differences.
    static double difference(const Bc6hTexels& texels, Bc6hSign sign) {
        const auto decoded = decodeBc6h(encodeBc6h(texels, sign), sign);
        double sum = 0;
        for (std::size_t n = 0; n < 16; ++n)
            for (std::size_t c = 0; c < 3 && (texels.used >> n & 1) != 0; ++c)
                sum += std::fabs(double(decoded[n][c]) - double(texels.rgb[n][c]));
        return sum;
    }

    Lobe& lobe_;
    CompressedLight& out_;
    int wide_ = 0, high_ = 0;
};

/// Texels as a GPU reads them; blocks are decoded one at a time.
class Decoded {
public:
    Decoded(const CompressedLight& light, const Compressor& blocks) : light_(light), blocks_(blocks) {}
    VoxelLight at(const glm::ivec3& texel) {
        const std::size_t block = blocks_.blockAt(texel.x / 4, texel.y / 4, texel.z);
        if (block != block_) {
            block_ = block;
            Bc6hBlock f, c;
            std::memcpy(f.data(), light_.flux.data() + 16 * block, 16);
            std::memcpy(c.data(), light_.colour.data() + 16 * block, 16);
            flux_ = decodeBc6h(f, light_.flux_sign), colour_ = decodeBc6h(c, Bc6hSign::Unsigned);
        }
        const auto n = static_cast<std::size_t>(texel.x % 4 + 4 * (texel.y % 4));
        const glm::dvec3 stored = glm::dvec3(flux_[n][0], flux_[n][1], flux_[n][2]) - double(light_.bias);
        VoxelLight out{mirrored(stored, light_.mirror), {}};
        for (std::size_t c = 0; c < 3; ++c) out.colour[c] = colour_[n][c] - light_.bias;
        return out;
    }

private:
    const CompressedLight& light_;
    const Compressor& blocks_;
    std::size_t block_ = ~std::size_t{0};
    std::array<Rgb, 16> flux_{}, colour_{};
};

VoxelLight meanOf(const std::array<VoxelLight, 8>& lights) {
    VoxelLight mean;
    for (const VoxelLight& light : lights) {
        mean.flux += light.flux / 8.0;
        for (std::size_t c = 0; c < 3; ++c) mean.colour[c] += light.colour[c] / 8;
    }
    return mean;
}

/// Gives the active voxels of a leaf what a look-up at their centres reads in their brick or box.
void decodeLeaf(Lobe& lobe, int slot, const CompressedLight& light, const Compressor& blocks, std::ptrdiff_t brick) {
    const NeededVoxels::Mask& mask = *lobe.mask(slot);
    const glm::ivec3 origin = lobe.field().needed().leafOrigin(slot);
    Decoded decoded(light, blocks);
    for (int i = 0; i < kVoxels; ++i) {
        if (!NeededVoxels::maskBit(mask, i)) continue;
        const glm::ivec3 in_leaf(i >> 6, i >> 3 & 7, i & 7);
        VoxelLight here;
        if (light.one_box) {
            here = decoded.at(origin + in_leaf - light.first);
        } else {
            const CompressedLight::Brick& of = light.bricks[static_cast<std::size_t>(brick)];
            const glm::ivec3 first(0, 0, kSide * static_cast<int>(brick)), page(of.page[0], of.page[1], of.page[2]);
            const glm::ivec3 at = origin + in_leaf - 8 * page;
            if (of.step == 1) {
                here = decoded.at(first + at);
            } else {
                // Even voxels stand on a wide one; odd ones in the middle between two.
                std::array<VoxelLight, 8> corners;
                for (int n = 0; n < 8; ++n)
                    corners[std::size_t(n)] = decoded.at(first + (at + glm::ivec3(n & 1, n >> 1 & 1, n >> 2)) / 2);
                here = meanOf(corners);
            }
        }
        // What is lit stays so: files and games tell lit voxels from dark ones.
        const VoxelLight was = lobe.inLeaf(slot, i);
        const bool lit = was.colour[0] > 0 || was.colour[1] > 0 || was.colour[2] > 0;
        float mean = 0;
        for (float& c : here.colour) c = std::max(c, 0.0F), mean += c / 3;
        if (lit && mean < 2 * format::kActiveAbove) here.colour.fill(2 * format::kActiveAbove);
        lobe.set(slot, i, here);
    }
}

std::shared_ptr<const CompressedLight> compressed(LightField& field, const std::vector<ActiveLeaf>& leaves,
                                                  const LightVolume& volume, const CoarseBlocks& coarse,
                                                  const Monitor& monitor) {
    auto out = std::make_shared<CompressedLight>();
    Lobe lobe(field, leaves, volume.reference_irradiance);
    chooseMirror(lobe, leaves, *out);
    const BrickPages pages = brickPages(volume, leaves, coarse);
    const glm::ivec3 period = periodVoxels(volume);
    out->one_box = runtimeSize(pages, field.channels(), coarse, GameTexels::Bc6h).dense;
    if (out->one_box) {
        for (int a = 0; a < 3; ++a) {
            out->first[a] = pages.low[a] - (period[a] == 0);
            out->texels[a] = period[a] != 0 ? period[a] : pages.high[a] - pages.low[a] + 3;
        }
    } else {
        for (const auto& page : pages.pages) out->bricks.push_back({page, 1});
        for (const auto& block : pages.blocks) out->bricks.push_back({{2 * block[0], 2 * block[1], 2 * block[2]}, 2});
        out->texels = {kPitch, kPitch, kSide * static_cast<int>(out->bricks.size())};
    }
    Compressor compressor(lobe, *out);
    compressor.chooseBias();
    parallelFor(out->texels.z, [&](std::int64_t z) {
        monitor.checkCancelled();
        compressor.encodeLayer(static_cast<int>(z));
    });
    const auto brickOf = [&](const glm::ivec3& origin) -> std::ptrdiff_t {
        if (out->one_box) return 0;
        const std::array<int, 3> page{floorDiv(origin.x, 8), floorDiv(origin.y, 8), floorDiv(origin.z, 8)};
        const auto own = std::lower_bound(pages.pages.begin(), pages.pages.end(), page);
        if (own != pages.pages.end() && *own == page) return own - pages.pages.begin();
        const std::array<int, 3> block{page[0] >> 1, page[1] >> 1, page[2] >> 1};
        const auto shared = std::lower_bound(pages.blocks.begin(), pages.blocks.end(), block);
        return static_cast<std::ptrdiff_t>(pages.pages.size()) + (shared - pages.blocks.begin());
    };
    for (const ActiveLeaf& leaf : leaves)
        if (leaf.slot >= 0 && field.state(leaf.slot) != LeafState::Dense) field.makeDense(leaf.slot);
    parallelFor(static_cast<std::int64_t>(leaves.size()), [&](std::int64_t n) {
        const ActiveLeaf& leaf = leaves[static_cast<std::size_t>(n)];
        if (leaf.slot >= 0) decodeLeaf(lobe, leaf.slot, *out, compressor, brickOf(leaf.origin));
    });
    return out;
}

template <class T>
void append(std::string& out, const T& value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    out.append(bytes, sizeof(T));
}

}  // namespace

std::string CompressedLight::bytes() const {
    std::string out(format::kBlocksMagic, 8);
    append(out, std::uint32_t{format::kBlocksVersion});
    append(out, std::uint32_t{one_box ? format::kBlocksBox : format::kBlocksBricks});
    for (int a = 0; a < 3; ++a) append(out, std::int32_t{first[a]});
    for (int a = 0; a < 3; ++a) append(out, static_cast<std::uint32_t>(texels[a]));
    append(out, std::uint32_t{flux_sign == Bc6hSign::Signed});
    for (int a = 0; a < 3; ++a) append(out, static_cast<float>(mirror[a]));
    append(out, static_cast<std::uint32_t>(bricks.size()));
    append(out, bias);
    for (const Brick& brick : bricks) {
        for (const int p : brick.page) append(out, std::int32_t{p});
        append(out, std::int32_t{brick.step});
    }
    out.append(flux.begin(), flux.end());
    out.append(colour.begin(), colour.end());
    return out;
}

void compressLight(LightVolume& volume, const Monitor& monitor) {
    if (!volume.field.channels().flux)
        throw Error(ErrorCode::Input,
                    "has no directions, and bc6h stores flux and colour; bake it with the grid 'direction', or export "
                    "it as it is",
                    "--compress");
    const CoarseBlocks coarse = coarseBlocksOf(volume);
    const std::vector<ActiveLeaf> leaves = activeLeaves(volume, ActiveBy::Light);
    const std::vector<ActiveLeaf> second = secondLobeLeaves(volume, leaves);
    volume.compressed[0] = compressed(volume.field, leaves, volume, coarse, monitor);
    if (!second.empty()) volume.compressed[1] = compressed(*volume.second, second, volume, coarse, monitor);
}

}  // namespace photic
