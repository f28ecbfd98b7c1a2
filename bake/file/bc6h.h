// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace photic {

/// BC6H, the block compression of graphics cards for light: 4 x 4 texels of three half floats in 16 bytes.
///
/// The texels of a block lie on a line through the space of three colours, at 16 places of it: the block holds both
/// ends (10 to 16 bits a channel) and for each texel which place. Lines are straight in the bits of half floats, which
/// are nearly logarithms, so that dark texels keep their digits. After the Khronos Data Format Specification 1.3,
/// section 23 (BPTC); of its 14 modes these functions use the four with one line a block (11 to 14), since light of one
/// direction lies on one line: a second line would cost half of the places.
enum class Bc6hSign {
    Unsigned,  ///< BC6H_UF16: 0 to 65504
    Signed     ///< BC6H_SF16
};

using Bc6hBlock = std::array<std::uint8_t, 16>;

/// 4 x 4 texels, x fastest.
struct Bc6hTexels {
    std::array<std::array<float, 3>, 16> rgb{};
    std::uint16_t used = 0xffff;  ///< bit n: texel n counts; the others become whatever is cheapest
};

/// The block that is nearest, by the sum of squared differences over what is used. Values below the least are raised to
/// it, those above 65504 cut. Deterministic.
/// Cost: about 5 us.
Bc6hBlock encodeBc6h(const Bc6hTexels& texels, Bc6hSign sign);

/// What a graphics card reads in a block of encodeBc6h(), to the bit.
std::array<std::array<float, 3>, 16> decodeBc6h(const Bc6hBlock& block, Bc6hSign sign);

}  // namespace photic
