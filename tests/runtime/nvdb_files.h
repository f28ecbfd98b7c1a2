// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

namespace photic::test {

/// How a test's light is written with NanoVDB's own headers: the grids that photic::runtime::loadVolume() knows.
enum class NvdbEncoding {
    Vec4,      ///< `flux`, and `irradiance_rgb` when coloured
    Fp16,      ///< scalar grids of 16-bit codes
    Floats,    ///< the same of floats
    Direction  ///< `irradiance` and `direction`, as nanovdb_convert writes a .vdb
};

/// How NanoVDB packs its grids.
enum class NvdbPacking { None, Zip, Blosc };

/// flux.xyz, mean irradiance, irradiance per channel.
using LightValues = std::array<float, 7>;

struct NvdbSpec {
    std::array<int, 3> min{0, 0, 0}, max{15, 15, 15};  ///< voxels, both inside
    std::function<LightValues(int i, int j, int k)> values;
    std::function<bool(int i, int j, int k)> active;  ///< all, when empty
    bool coloured = false;
    NvdbEncoding encoding = NvdbEncoding::Vec4;
    NvdbPacking packing = NvdbPacking::None;
    std::array<double, 9> world_from_index{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< by rows
    std::array<double, 3> origin_world{0, 0, 0};
    std::string json;  ///< blind data `photic` of the first grid; none when empty
};

/// The bytes of a `.nvdb`.
std::vector<unsigned char> makeNvdb(const NvdbSpec& spec);

/// Light that turns and varies in every voxel, white or coloured, always |flux| <= irradiance; peaks near 20.
LightValues swirl(int i, int j, int k);

/// Light of two levels: `spec`'s own values, but that blocks of 16^3 voxels for which coarse(block) holds, far sides
/// included, have the look-up of every second of them, where they lie in the box. Says so in its JSON, which is
/// replaced.
/// @param repeats  along each axis: the box is a period of whole blocks, and its far end is its beginning
NvdbSpec twoLevels(NvdbSpec spec, const std::function<bool(int x, int y, int z)>& coarse,
                   const std::array<bool, 3>& repeats = {});

}  // namespace photic::test
