// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "bake/file/bc6h.h"
#include "bake/file/vdb.h"
#include "bake/report/monitor.h"

namespace photic {

/// The light of one lobe as BC6H textures, as a game's GPU takes them (docs/files.md): flux and colour apart, two bytes
/// a texel of both instead of eight or sixteen.
///
/// The three components of a block share the places on one line, so what is coarse about a block goes along the flux
/// and not across it. Lines are straight in the bits of half floats, which pass through many tiny numbers on their way
/// through 0: so that components of both signs are rare, flux is stored mirrored, such that its mean lies along (1, 1,
/// 1). And since a block with dark and bright texels would spend most places on the way between 0 and the least of what
/// counts, all is stored with a bias on top, which is chosen for each volume.
struct CompressedLight {
    struct Brick {
        std::array<int, 3> page;  ///< begins at voxel 8 * page
        int step;                 ///< 1; 2: every second voxel
    };
    bool one_box = false;       ///< or bricks
    glm::ivec3 first{0};        ///< of one box: its first voxel
    glm::ivec3 texels{0};       ///< of each texture; bricks of 12 x 12 x 9 lie one behind the other along z
    std::vector<Brick> bricks;  ///< of 9^3 voxels, which begin at each one's first texel
    Bc6hSign flux_sign = Bc6hSign::Signed;
    glm::dvec3 mirror{0};  ///< flux = s - 2 mirror dot(mirror, s), where s is stored - bias
    float bias = 0;        ///< on all components of both textures; a half float, so that darkness is exact
    std::vector<std::uint8_t> flux, colour;  ///< blocks, x fastest

    /// As a file holds it.
    std::string bytes() const;
};

/// Compresses the light of both lobes: `compressed` of the volume holds the blocks, and its fields what a GPU reads in
/// them. A box or bricks, whichever takes fewer bytes; light that repeats is always a box.
/// @throws Error{Input} for a volume without directions; Error{Cancelled}
void compressLight(LightVolume& volume, const Monitor& monitor);

}  // namespace photic
