// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "runtime/src/brick_layout.h"
#include "runtime/src/guarded.h"

namespace photic::runtime {

/// The uniform block photic_parameters of photic_volume.glsl, by std140: rows of 16 bytes. docs/volume_bytes.md says it
/// in words.
struct VolumeParameters {
    float row_x[4], row_y[4], row_z[4];
    float centre[3], scale;
    std::int32_t offset[3], layout;
    std::int32_t cell_min[3], coloured;
    std::int32_t cell_max[3], directed;
    std::int32_t period[3], repeats;
    std::int32_t dense_min[4];
    float texel[4], lit_min[4], lit_max[4];
    float mirror[3], bias;
};
static_assert(sizeof(VolumeParameters) == 13 * 16);

/// A light volume laid out in one way: what is uploaded, texel by texel.
class VolumeLayout {
public:
    /// @param blocks  the volume's own, which serve the plan; or null: half floats
    VolumeLayout(const VolumeData& data, const BrickPlan& plan, Layout layout, const GpuLimits& limits,
                 const BlockTexels* blocks = nullptr)
        : data_(data), plan_(plan), blocks_(blocks), bricks_(plan, layout, data.period, limits.texture_3d, blocks) {}

    const BrickLayout& bricks() const { return bricks_; }
    bool coloured() const { return data_.coloured; }
    bool repeats(std::size_t axis) const { return bricks_.layout() == Layout::Dense && data_.period[axis] != 0; }
    /// Of all textures; of blocks, how many of a texture's.
    std::uint64_t texelBytes() const { return blocks_ ? 2 : sizeof(Half4) * (data_.coloured ? 2 : 1); }
    const BlockTexels* blocks() const { return blocks_; }
    const Int3& pageCount() const { return plan_.page_count; }

    /// Sources of texels for BrickLayout: flux.xyz and mean; red, green, blue, 0.
    auto lightSource() const {
        return [this](const Int3& min, const Int3& size, Half4* out) { fillBox(data_, min, size, out, nullptr); };
    }
    auto colourSource() const {
        return [this](const Int3& min, const Int3& size, Half4* out) { fillBox(data_, min, size, nullptr, out); };
    }
    /// The storage buffer's content: per voxel the light, and in colour the colour behind it.
    std::vector<Half4> bufferTexels() const;

    VolumeParameters parameters() const;
    UploadInfo info(const GpuLimits& limits) const;

private:
    const VolumeData& data_;
    const BrickPlan& plan_;
    const BlockTexels* blocks_;
    BrickLayout bricks_;
};

/// One way to lay a volume out.
struct LayoutChoice {
    Layout layout;
    const BlockTexels* blocks;
};

/// The ways to try, best first: blocks, where the volume has them and they are wanted and can be read, then half
/// floats.
std::vector<LayoutChoice> layoutChoices(const VolumeData& data, const BrickPlan& plan, const UploadOptions& options,
                                        const GpuLimits& limits);

/// What make(layout) returns for the first layout that fits the budget and the limits and for which it throws no
/// Failure; where none does, the same of the volume at half its resolution, unless that is to be refused.
/// @return Error{Limit}, Error{Memory}: why no layout fits, one by one
template <class Make>
auto fitLayout(const Volume& volume, const UploadOptions& options, const GpuLimits& limits, const Make& make)
    -> Result<decltype(make(std::declval<const VolumeLayout&>(), UploadInfo{}))> {
    Volume level = volume;
    for (int coarsened = 0;; ++coarsened) {
        Error why{ErrorCode::Limit, {}};
        try {
            const BrickPlan plan = planBricks(level.data(), options.budget);
            std::string reasons;
            for (const auto& [candidate, blocks] : layoutChoices(level.data(), plan, options, limits)) {
                const VolumeLayout layout(level.data(), plan, candidate, limits, blocks);
                const LayoutNeed need = layout.bricks().need(layout.texelBytes(), limits);
                std::string reason = need.obstacle;
                if (reason.empty() && need.bytes > options.budget) {
                    reason = std::to_string(need.bytes) + " bytes, and the budget is " + std::to_string(options.budget);
                }
                if (reason.empty()) {
                    try {
                        UploadInfo info = layout.info(limits);
                        info.coarsened = coarsened;
                        return make(layout, info);
                    } catch (const Failure& failure) {
                        why.code = failure.error.code;
                        reason = failure.error.message;
                    }
                }
                reasons += std::string(reasons.empty() ? "" : "; ") + (blocks ? "BC6H " : "") + nameOf(candidate) +
                           ": " + reason;
            }
            why.message =
                "the volume fits in no layout: " + reasons + "; raise the budget, or export with a smaller one";
        } catch (const Failure& failure) {
            why = failure.error;
        }
        // A handful of voxels that does not fit will not fit when it is coarser.
        if (options.when_too_large == WhenTooLarge::Refuse || level.litVoxelCount() < 64) return why;
        level = halfResolution(level.data());
    }
}

}  // namespace photic::runtime
