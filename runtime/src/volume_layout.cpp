// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/volume_layout.h"

#include <algorithm>
#include <limits>

namespace photic::runtime {

std::vector<Half4> VolumeLayout::bufferTexels() const {
    const std::size_t step = data_.coloured ? 2 : 1;
    std::vector<Half4> texels(std::size_t{plan_.brickCount()} * BrickPlan::kVoxels * step);
    bricks_.fillBuffer(0, step, lightSource(), texels.data());
    if (data_.coloured) bricks_.fillBuffer(1, step, colourSource(), texels.data());
    return texels;
}

VolumeParameters VolumeLayout::parameters() const {
    VolumeParameters p{};
    // Local coordinates count from a voxel in the middle, and their centre is that voxel's, rounded to float: what the
    // rounding costs goes into the rows' fourth component.
    Double3 middle, world;
    for (std::size_t a = 0; a < 3; ++a) middle[a] = floorDivide(plan_.cell_min[a] + plan_.cell_max[a] + 1, 2);
    const Double3 offset = multiply(data_.transform.world_from_index, middle);
    for (std::size_t a = 0; a < 3; ++a) {
        p.centre[a] = static_cast<float>(data_.transform.origin_world[a] + offset[a]);
        world[a] = static_cast<double>(p.centre[a]);
    }
    p.scale = static_cast<float>(data_.metadata.reference_irradiance);
    const Double3 index = data_.transform.indexOf(world);
    float* const rows[3] = {p.row_x, p.row_y, p.row_z};
    for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t c = 0; c < 3; ++c)
            rows[a][c] = static_cast<float>(data_.transform.index_from_world[3 * a + c]);
        rows[a][3] = static_cast<float>(index[a] - middle[a]);
        const int first = 8 * plan_.page_min[a], centre = static_cast<int>(middle[a]);
        p.offset[a] = centre - first;
        p.cell_min[a] = plan_.cell_min[a] - first;
        p.cell_max[a] = plan_.cell_max[a] - first;
        p.dense_min[a] = plan_.cell_min[a] - first;
        p.period[a] = data_.period[a];
        if (blocks_ && blocks_->one_box) p.dense_min[a] = blocks_->first[a] - first;
        p.texel[a] = 1.0F / static_cast<float>(bricks_.textureSize()[a]);
        constexpr float kFar = std::numeric_limits<float>::max();
        const bool repeats = data_.period[a] != 0;
        p.lit_min[a] = repeats ? -kFar : static_cast<float>(plan_.cell_min[a] - centre);
        p.lit_max[a] = repeats ? kFar : static_cast<float>(plan_.cell_max[a] + 1 - centre);
    }
    if (blocks_) {
        p.dense_min[3] = 1;
        std::copy(blocks_->mirror.begin(), blocks_->mirror.end(), p.mirror);
        p.bias = blocks_->bias;
    }
    p.layout = bricks_.layout() == Layout::Dense ? 2 : 1;
    p.coloured = data_.coloured;
    p.directed = data_.has_direction;
    p.repeats = data_.period != Int3{0, 0, 0};
    return p;
}

std::vector<LayoutChoice> layoutChoices(const VolumeData& data, const BrickPlan& plan, const UploadOptions& options,
                                        const GpuLimits& limits) {
    std::vector<LayoutChoice> choices;
    if (const BlockTexels* blocks = data.blocks.get();
        blocks && options.texels == Texels::AsInFile && limits.bc6h && blocks->serve(plan, data)) {
        const Layout layout = blocks->one_box ? Layout::Dense : Layout::Atlas;
        if (options.layout == Layout::Automatic || options.layout == layout) choices.push_back({layout, blocks});
    }
    for (const Layout layout : candidateLayouts(options.layout, plan)) choices.push_back({layout, nullptr});
    return choices;
}

UploadInfo VolumeLayout::info(const GpuLimits& limits) const {
    UploadInfo info;
    info.layout = bricks_.layout();
    info.bc6h = blocks_ != nullptr;
    info.fill = plan_.fill();
    info.bytes = bricks_.need(texelBytes(), limits).bytes;
    info.bricks = bricks_.layout() == Layout::Dense ? 0 : plan_.brickCount() - 1;
    info.coarse_bricks = bricks_.layout() == Layout::Dense ? 0 : plan_.coarse;
    return info;
}

}  // namespace photic::runtime
