// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/shape_texels.h"

#include <array>
#include <bit>
#include <cstring>

#include "runtime/src/guarded.h"
#include "runtime/src/index_volume_data.h"
#include "runtime/src/shape_tree.h"

namespace photic::runtime {
namespace {

using Texel = std::array<std::uint32_t, 4>;
using Floats = std::array<float, 3>;
constexpr std::size_t kHeader = 4, kNode = 4, kCorners = 3;  // texels

Texel texelOf(const Floats& v, std::int32_t last) {
    return {std::bit_cast<std::uint32_t>(v[0]), std::bit_cast<std::uint32_t>(v[1]), std::bit_cast<std::uint32_t>(v[2]),
            std::bit_cast<std::uint32_t>(last)};
}

std::size_t sizeOf(const SharpShape& shape, const ShapeTree* tree) {
    if (!tree) return kHeader;
    const std::size_t normals = shape.kind == SharpShape::Kind::Smooth ? kCorners : 0;
    return kHeader + kNode * tree->nodes.size() + (kCorners + normals) * shape.triangles.size();
}

/// Header, nodes, corners of triangles and their normals, at the end of `out`.
void append(const SharpShape& shape, const ShapeTree* tree, std::vector<Texel>& out) {
    Floats excess;
    for (std::size_t c = 0; c < 3; ++c) excess[c] = 0.5F * (shape.index[c] * shape.index[c] - 1);
    out.push_back(texelOf(excess, static_cast<std::int32_t>(shape.kind)));
    out.push_back(texelOf(shape.absorption, static_cast<std::int32_t>(shape.faces)));
    out.push_back(texelOf(shape.colour, static_cast<std::int32_t>(shape.rank)));
    if (!tree) {
        out.push_back(
            texelOf({shape.ball[0], shape.ball[1], shape.ball[2]}, std::bit_cast<std::int32_t>(shape.ball[3])));
        return;
    }
    const std::size_t nodes = out.size() + 1, corners = nodes + kNode * tree->nodes.size();
    const std::size_t normals = corners + kCorners * tree->order.size();
    out.push_back({static_cast<std::uint32_t>(nodes), static_cast<std::uint32_t>(corners),
                   static_cast<std::uint32_t>(normals), static_cast<std::uint32_t>(tree->order.size())});
    for (const auto& node : tree->nodes) {
        for (const ShapeTree::Child& child : node) {
            const std::int32_t to =
                child.to < 0 ? child.to : static_cast<std::int32_t>(nodes + kNode * static_cast<std::size_t>(child.to));
            out.push_back(texelOf(child.box.low, to));
            out.push_back(texelOf(child.box.high, 0));
        }
    }
    for (const auto* vectors : {&shape.positions, &shape.normals}) {
        if (vectors->empty()) continue;
        for (const std::uint32_t t : tree->order)
            for (const std::uint32_t v : shape.triangles[t]) out.push_back(texelOf((*vectors)[v], 0));
    }
}

}  // namespace

ShapeTexels::ShapeTexels(const std::vector<IndexVolume>& objects, int largest_texture) {
    std::vector<Texel> texels;
    const std::size_t most = std::size_t{kWidth} * static_cast<std::size_t>(largest_texture);
    for (const IndexVolume& object : objects) {
        const auto& shape = object.data().shape;
        places.push_back(shape ? static_cast<std::int32_t>(texels.size()) : -1);
        if (!shape) continue;
        std::optional<ShapeTree> tree;
        if (shape->kind != SharpShape::Kind::Ball) tree.emplace(*shape);
        if (texels.size() + sizeOf(*shape, tree ? &*tree : nullptr) > most)
            fail(ErrorCode::Limit, "the meshes take more than a texture of 2048 x " + std::to_string(largest_texture) +
                                       " texels, the GPU's largest; upload fewer triangles together");
        append(*shape, tree ? &*tree : nullptr, texels);
    }
    const bool none = texels.empty();
    const std::uint32_t width = none ? 1 : kWidth;
    const auto rows = static_cast<std::uint32_t>((texels.size() + width - 1) / width);
    texture = {TexelFormat::Rgba32Uint, {width, none ? 1 : rows, 1}, {}};
    texels.resize(std::size_t{width} * texture.size[1]);
    texture.texels.resize(texels.size() * sizeof(Texel));
    std::memcpy(texture.texels.data(), texels.data(), texture.texels.size());
}

}  // namespace photic::runtime
