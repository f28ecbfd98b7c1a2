// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/block_texels.h"

#include <algorithm>
#include <cmath>

#include "runtime/format/light_volume_format.h"
#include "runtime/src/brick_plan.h"

namespace photic::runtime {
namespace {

[[noreturn]] void damaged(const Bytes& bytes) {
    fail(ErrorCode::Format, bytes.what() + " holds no sound BC6H blocks; the file is damaged: export it again");
}

}  // namespace

std::shared_ptr<const BlockTexels> BlockTexels::of(const Bytes& bytes) {
    bytes.require(0, format::kBlocksHeader, 1, "the header of BC6H blocks");
    if (bytes.get<std::uint32_t>(8) != format::kBlocksVersion)
        fail(ErrorCode::Format, bytes.what() + " holds BC6H blocks of version " +
                                    std::to_string(bytes.get<std::uint32_t>(8)) + "; only 1 is read: export it again");
    auto out = std::make_shared<BlockTexels>();
    const auto kind = bytes.get<std::uint32_t>(12);
    out->one_box = kind == format::kBlocksBox;
    const std::uint64_t bricks = bytes.get<std::uint32_t>(56);
    if ((kind != format::kBlocksBox && kind != format::kBlocksBricks) || (out->one_box && bricks != 0)) damaged(bytes);
    std::uint64_t blocks = 1;
    for (std::size_t a = 0; a < 3; ++a) {
        out->first[a] = bytes.get<std::int32_t>(16 + 4 * a);
        const auto texels = bytes.get<std::uint32_t>(28 + 4 * a);
        // Far below these bounds a block's place overflows nothing.
        if (texels < 1 || texels > 1U << 28 || std::abs(std::int64_t{out->first[a]}) > kLargestIndex) damaged(bytes);
        out->texels[a] = static_cast<int>(texels);
        blocks *= a < 2 ? blocksIn(out->texels[a]) : texels;
        if (blocks > bytes.size()) damaged(bytes);
        out->mirror[a] = bytes.get<float>(44 + 4 * a);
        if (!(std::fabs(out->mirror[a]) <= 1.001F)) damaged(bytes);
    }
    out->bias = bytes.get<float>(60);
    if (!(out->bias >= 0 && out->bias <= 65504)) damaged(bytes);
    out->signed_flux = bytes.get<std::uint32_t>(40) != 0;
    const std::uint64_t table = format::kBlocksHeader, begin = table + bricks * format::kBlocksBrick;
    if (!out->one_box && (out->texels[0] != kPitch || out->texels[1] != kPitch ||
                          static_cast<std::uint64_t>(out->texels[2]) != bricks * kSide))
        damaged(bytes);
    bytes.require(table, bricks, format::kBlocksBrick, "the table of BC6H bricks");
    bytes.require(begin, blocks, 2 * kBlockBytes, "BC6H blocks");
    for (std::uint64_t n = 0; n < bricks; ++n) {
        std::array<int, 4> key{};
        for (std::size_t i = 0; i < 4; ++i) key[i] = bytes.get<std::int32_t>(table + n * format::kBlocksBrick + 4 * i);
        if ((key[3] != 1 && key[3] != 2) || !out->numbers.emplace(key, static_cast<std::uint32_t>(n)).second)
            damaged(bytes);
    }
    const auto copy = [&](std::uint64_t at) {
        const auto view = bytes.view(at, blocks * kBlockBytes);
        return std::vector<unsigned char>(view.begin(), view.end());
    };
    out->flux = copy(begin);
    out->colour = copy(begin + blocks * kBlockBytes);
    return out;
}

bool BlockTexels::serve(const BrickPlan& plan, const VolumeData& data) const {
    if (one_box) {
        for (std::size_t a = 0; a < 3; ++a) {
            const int last = first[a] + texels[a] - 1;
            // A cell reads the voxel behind it too, which is the first one again where the light repeats.
            const bool there = data.period[a] != 0 ? plan.cell_min[a] == first[a] && texels[a] == data.period[a]
                                                   : plan.cell_min[a] >= first[a] && plan.cell_max[a] < last;
            if (!there) return false;
        }
        return data.lit_voxels > 0;
    }
    return data.period == Int3{0, 0, 0} &&
           std::all_of(plan.bricks.begin(), plan.bricks.end(), [&](const BrickPlan::Brick& brick) {
               return numbers.contains({brick.page[0], brick.page[1], brick.page[2], brick.step});
           });
}

}  // namespace photic::runtime
