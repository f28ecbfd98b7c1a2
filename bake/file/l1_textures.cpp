// SPDX-License-Identifier: Apache-2.0
#include "bake/file/l1_textures.h"

#include <Imath/half.h>

#include <nlohmann/json.hpp>
#include <string_view>

#include "bake/file/output_set.h"
#include "bake/file/runtime_metadata.h"
#include "bake/file/sidecar.h"
#include "bake/file/texture_headers.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

using Json = nlohmann::ordered_json;
using Texel = std::array<std::uint16_t, 4>;

float fromHalf(std::uint16_t bits) { return imath_half_to_float(bits); }
std::uint16_t toHalf(float value) { return imath_float_to_half(value); }

/// Adds a lobe's harmonics to the three texels of a voxel. Unity's axes are (x, z, y) of Photic's.
void addLobe(const LobeTexels& lobe, std::size_t at, std::array<std::array<float, 4>, 3>& texels) {
    const std::uint16_t* light = &lobe.light[4 * at];
    const glm::vec3 flux(fromHalf(light[0]), fromHalf(light[1]), fromHalf(light[2]));
    const float mean = fromHalf(light[3]);
    const L1Irradiance all = l1Irradiance(mean, flux);
    for (std::size_t c = 0; c < 3; ++c) {
        // In colour the direction is that of the channels' mean.
        const float share = lobe.rgb.empty() || !(mean > 0) ? 1.0f : fromHalf(lobe.rgb[4 * at + c]) / mean;
        texels[0][c] += share * all.l0;
        texels[1][c] += share * all.l1[0];
        texels[2][c] += share * all.l1[2];
        texels[c][3] += share * all.l1[1];
    }
}

std::array<Texel, 3> texelsOf(const DenseTexels& dense, std::size_t at) {
    std::array<std::array<float, 4>, 3> sums{};
    addLobe(dense.first, at, sums);
    if (dense.second) addLobe(*dense.second, at, sums);
    std::array<Texel, 3> texels{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t c = 0; c < 4; ++c) texels[i][c] = toHalf(sums[i][c]);
    return texels;
}

}  // namespace

std::array<std::string, 3> l1Paths(const std::string& path) {
    return {partPath(path, "_0"), partPath(path, "_1"), partPath(path, "_2")};
}

DenseWritten writeL1Textures(OutputSet& outputs, const std::string& path, const LightVolume& volume,
                             TextureFormat format, const std::optional<VoxelBox>& box) {
    const DenseTexels dense = denseTexels(volume, box);
    const glm::ivec3 own(dense.size.x, dense.size.z, dense.size.y);
    const auto row = static_cast<std::size_t>(own.x), rows = static_cast<std::size_t>(own.y);
    std::array<std::vector<Texel>, 3> textures;
    for (auto& texture : textures) texture.resize(row * rows * static_cast<std::size_t>(own.z));
    parallelFor(own.z, [&](std::int64_t z) {
        for (std::size_t y = 0; y < rows; ++y) {
            for (std::size_t x = 0; x < row; ++x) {
                const std::size_t from = x + row * (static_cast<std::size_t>(z) + static_cast<std::size_t>(own.z) * y);
                const std::size_t to = x + row * (y + rows * static_cast<std::size_t>(z));
                const auto texels = texelsOf(dense, from);
                for (std::size_t i = 0; i < 3; ++i) textures[i][to] = texels[i];
            }
        }
    });
    Json json = runtimeMetadata(volume);
    // Both of a matrix' ends are turned to Unity's axes: its second and third rows and columns change places.
    const int turned[4] = {0, 2, 1, 3};
    json["world_from_texture"] = Json::array();
    for (const int i : turned) {
        Json line = Json::array();
        for (const int j : turned) line.push_back(dense.world_from_texture[j][i]);
        json["world_from_texture"].push_back(line);
    }
    const auto paths = l1Paths(path);
    json["texture_size"] = {own.x, own.y, own.z};
    json["up_axis"] = "Y";
    json["handedness"] = "left";
    json["texture"] = nameOf(paths[0]);
    json["l1_textures"] = {nameOf(paths[0]), nameOf(paths[1]), nameOf(paths[2])};
    const std::string metadata = json.dump(-1, ' ', false, Json::error_handler_t::replace);

    DenseWritten written{{}, dense.size, dense.clamped};
    for (std::size_t i = 0; i < 3; ++i) {
        std::string bytes = format == TextureFormat::Ktx2 ? ktx2Header(own, metadata) : ddsHeader(own);
        bytes.append(reinterpret_cast<const char*>(textures[i].data()), textures[i].size() * sizeof(Texel));
        outputs.write(paths[i], bytes);
        written.files.push_back(paths[i]);
    }
    written.files.push_back(sidecarPath(path));
    outputs.write(written.files.back(), json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
    return written;
}

}  // namespace photic
