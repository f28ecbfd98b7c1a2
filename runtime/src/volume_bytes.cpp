// SPDX-License-Identifier: Apache-2.0
#include "photic/volume_bytes.h"

#include <cstring>

#include "runtime/src/volume_layout.h"

namespace photic::runtime {
namespace {

std::array<std::uint32_t, 3> sizeOf(const Int3& size) {
    return {static_cast<std::uint32_t>(size[0]), static_cast<std::uint32_t>(size[1]),
            static_cast<std::uint32_t>(size[2])};
}

template <class T>
std::vector<unsigned char> bytesOf(const std::vector<T>& values) {
    std::vector<unsigned char> out(values.size() * sizeof(T));
    if (!out.empty()) std::memcpy(out.data(), values.data(), out.size());
    return out;
}

template <class Source>
TextureBytes textureOf(const BrickLayout& bricks, const Source& source) {
    const Int3& size = bricks.textureSize();
    TextureBytes out{TexelFormat::Rgba16Float, sizeOf(size), {}};
    out.texels.resize(BrickLayout::texelsOf(size) * sizeof(Half4));
    std::vector<Half4> slab(bricks.slabTexels());
    const std::size_t layer = BrickLayout::texelsOf({size[0], size[1], 1});
    for (int z = 0; z < size[2]; z += bricks.slabDepth()) {
        const int count = std::min(bricks.slabDepth(), size[2] - z);
        bricks.fillSlab(z, count, source, slab.data());
        std::memcpy(out.texels.data() + static_cast<std::size_t>(z) * layer * sizeof(Half4), slab.data(),
                    static_cast<std::size_t>(count) * layer * sizeof(Half4));
    }
    return out;
}

TextureBytes blocksOf(const BrickLayout& bricks, const std::vector<unsigned char>& of, TexelFormat format) {
    const Int3& size = bricks.textureSize();
    TextureBytes out{format, sizeOf(size), {}};
    out.texels.resize(static_cast<std::size_t>(size[2]) * bricks.blockLayerBytes());
    for (int z = 0; z < size[2]; z += bricks.slabDepth())
        bricks.fillBlocks(z, std::min(bricks.slabDepth(), size[2] - z), of,
                          out.texels.data() + static_cast<std::size_t>(z) * bricks.blockLayerBytes());
    return out;
}

VolumeBytes bytesOf(const VolumeLayout& layout, const UploadInfo& info) {
    VolumeBytes out;
    out.info = info;
    const BrickLayout& bricks = layout.bricks();
    if (bricks.layout() == Layout::Buffer) {
        out.bricks = bytesOf(layout.bufferTexels());
    } else if (const BlockTexels* blocks = layout.blocks()) {
        out.light =
            blocksOf(bricks, blocks->flux, blocks->signed_flux ? TexelFormat::Bc6hSigned : TexelFormat::Bc6hUnsigned);
        out.colour = blocksOf(bricks, blocks->colour, TexelFormat::Bc6hUnsigned);
    } else {
        out.light = textureOf(bricks, layout.lightSource());
        if (layout.coloured()) out.colour = textureOf(bricks, layout.colourSource());
    }
    out.pages = {TexelFormat::R32Uint, sizeOf(layout.pageCount()), bytesOf(bricks.pageEntries())};
    const VolumeParameters parameters = layout.parameters();
    static_assert(sizeof(parameters) == sizeof(out.parameters));
    std::memcpy(out.parameters.data(), &parameters, sizeof(parameters));
    for (std::size_t a = 0; a < 3; ++a) out.sampler_repeats[a] = layout.repeats(a);
    return out;
}

}  // namespace

Result<VolumeBytes> packVolume(const Volume& volume, const UploadOptions& options) {
    return guarded([&]() -> Result<VolumeBytes> {
        GpuLimits limits;
        if (options.largest_texture_3d > 0) limits.texture_3d = options.largest_texture_3d;
        if (options.largest_storage_block > 0) limits.storage_block = options.largest_storage_block;
        return fitLayout(volume, options, limits,
                         [](const VolumeLayout& layout, const UploadInfo& info) { return bytesOf(layout, info); });
    });
}

}  // namespace photic::runtime
