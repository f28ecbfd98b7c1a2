// SPDX-License-Identifier: Apache-2.0
#include "photic/index_volume_bytes.h"

#include <cstring>

#include "runtime/src/bent_parameters.h"
#include "runtime/src/guarded.h"
#include "runtime/src/index_atlas_bytes.h"
#include "runtime/src/shape_texels.h"

namespace photic::runtime {
namespace {

template <class T>
TextureBytes textureOf(TexelFormat format, const Int3& size, const std::vector<T>& texels) {
    TextureBytes out{format, {}, {}};
    for (std::size_t a = 0; a < 3; ++a) out.size[a] = static_cast<std::uint32_t>(size[a]);
    out.texels.resize(texels.size() * sizeof(T));
    std::memcpy(out.texels.data(), texels.data(), out.texels.size());
    return out;
}

}  // namespace

IndexVolumeBytes atlasBytes(const std::vector<IndexVolume>& volumes, int largest_texture, int largest_flat) {
    const IndexAtlas atlas(volumes, largest_texture);
    constexpr Int3 kOne{1, 1, 1};
    const Int3 spline_size{atlas.texels[0], atlas.texels[1], atlas.spline_layers};
    const std::vector<Half4> none(1);
    IndexVolumeBytes out;
    out.spline = textureOf(TexelFormat::R32Float, spline_size, atlas.spline(volumes));
    out.gradients = textureOf(TexelFormat::Rgba16Float, atlas.texels, atlas.gradients(volumes));
    out.attenuation = atlas.attenuates ? textureOf(TexelFormat::Rgba16Float, atlas.texels, atlas.attenuation(volumes))
                                       : textureOf(TexelFormat::Rgba16Float, kOne, none);
    out.glow = atlas.glows ? textureOf(TexelFormat::Rgba16Float, atlas.texels, atlas.glow(volumes))
                           : textureOf(TexelFormat::Rgba16Float, kOne, none);
    out.faces = atlas.has_coat    ? textureOf(TexelFormat::Rgba8, atlas.texels, atlas.coat(volumes))
                : atlas.has_faces ? textureOf(TexelFormat::R8, atlas.texels, atlas.faces(volumes))
                                  : textureOf(TexelFormat::R8, kOne, std::vector<std::uint8_t>(1));
    out.blocks = textureOf(TexelFormat::R8Uint, atlas.blocks, atlas.reach);
    ShapeTexels shapes(volumes, largest_flat);
    out.shapes = std::move(shapes.texture);
    out.objects = std::make_shared<IndexObjects>(volumes, atlas, shapes.places);
    out.info.objects = static_cast<int>(volumes.size());
    out.info.texels = atlas.texels;
    out.info.even = atlas.even;
    for (const TextureBytes* texture :
         {&out.spline, &out.gradients, &out.attenuation, &out.glow, &out.faces, &out.blocks, &out.shapes})
        out.info.bytes += texture->texels.size();
    return out;
}

Result<IndexVolumeBytes> packIndexVolumes(const std::vector<IndexVolume>& objects, int largest_texture) {
    return guarded([&]() -> Result<IndexVolumeBytes> {
        if (largest_texture < 1) fail(ErrorCode::Usage, "textures of no texels a side hold nothing");
        return atlasBytes(objects, largest_texture, largest_texture);
    });
}

Result<std::vector<unsigned char>> packBentParameters(const float* origin, const IndexVolumeBytes& bytes,
                                                      const std::vector<PlacedObject>& placed,
                                                      const BentRayOptions& options, const Surroundings& surroundings) {
    return guarded([&]() -> Result<std::vector<unsigned char>> {
        if (!bytes.objects) fail(ErrorCode::Usage, "there are no objects; packIndexVolumes() makes the bytes");
        const Double3 place{double(origin[0]), double(origin[1]), double(origin[2])};
        const BentBlock block = bentBlock(*bytes.objects, placed, place, options, surroundings);
        std::vector<unsigned char> out(sizeof(block));
        std::memcpy(out.data(), &block, sizeof(block));
        return out;
    });
}

}  // namespace photic::runtime
