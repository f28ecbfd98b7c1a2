// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "bake/simd/instruction_set.h"

namespace photic {

/// Blocks of 8^3 cells, z fastest: cell (x, y, z) at x << 6 | y << 3 | z, which is OpenVDB's leaf order.
inline constexpr int kWaveSide = 8;
inline constexpr int kWaveCells = 512;

/// Central differences, per axis, of second or fourth order.
struct WaveDifferences {
    std::array<float, 3> first_1{}, first_2{};  ///< of phi(+1) - phi(-1), phi(+2) - phi(-2)
    /// The second difference as delta- M delta+ with delta of one cell: M delta+ is of phi(1) - phi(0) and phi(2) -
    /// phi(-1).
    std::array<float, 3> half_1{}, half_2{}, step{};
    std::array<float, 3> second_0{}, second_1{}, second_2{};  ///< of phi(0), phi(+-1), phi(+-2)
};

/// One step of phi_tt + 2 gamma phi_t = c^2 lap phi:
/// next = keep * (2 phi + scale * lap phi) - lose * previous.
struct WaveWeights {
    WaveDifferences d;
    float scale = 0;           ///< c^2 dt^2
    float keep = 1, lose = 1;  ///< 1 / (1 + gamma dt), (1 - gamma dt) / (1 + gamma dt)
    float per_two_steps = 0;   ///< 1 / (2 dt)
};

/// Memory of a block in the perfectly matched layer, one entry per axis; null where the axis is not matched.
struct WaveMemory {
    std::array<float*, 3> psi{}, zeta{};  ///< 512 cells each
    std::array<int, 3> outwards{};        ///< 1 or -1
    unsigned mirrors = 0;                 ///< bit per side: what lies beyond is the block's mirror image, not 0
    std::array<std::array<float, 8>, 3> a{}, b{}, a_half{}, b_half{};  ///< by cell along the axis; halfway outwards
};

/// What a kernel sees of a block.
struct WaveBlock {
    const float* now = nullptr;          ///< phi(n)
    float* other = nullptr;              ///< phi(n-1), overwritten by phi(n+1)
    std::array<const float*, 6> side{};  ///< phi(n) of the neighbours -x, +x, -y, +y, -z, +z; zeros where there is none
    const float* speed2 = nullptr;       ///< c^2 by cell, at most 1; null: 1 everywhere
    float* sums = nullptr;               ///< energy, then flux x y z: 512 each; null: nothing is summed
    std::array<float, 6>* largest = nullptr;  ///< largest |phi| of both levels in the half towards each side
};

/// The step, by what is summed on the way: nothing; phi_t^2; phi_t^2 and -phi_t grad phi (c = 1).
enum class WaveSum { Nothing, Energy, EnergyAndFlux };

struct WaveKernels {
    /// [0]: the step alone; [1]: also fills `largest`. Then by WaveSum.
    void (*step[2][3])(const WaveBlock&, const WaveWeights&);
    /// With `speed2`: c^2 lap phi and c gamma for lap phi and gamma; does not fill `largest`. By WaveSum.
    void (*stepVarying[3])(const WaveBlock&, const WaveWeights&);
    void (*stepMatched)(const WaveBlock&, const WaveWeights&, const WaveMemory&);
    /// `damping`: gamma dt by cell along each axis, added up.
    void (*stepSponge)(const WaveBlock&, const WaveWeights&, const std::array<std::array<float, 8>, 3>& damping);
    /// Fills `largest` alone.
    void (*halves)(const float* now, const float* other, std::array<float, 6>& largest);
    const char* name;
};

/// The kernels of an instruction set that this processor has.
const WaveKernels& waveKernels(InstructionSet set);
/// Those of the best (bestInstructionSet).
const WaveKernels& waveKernels();

}  // namespace photic
