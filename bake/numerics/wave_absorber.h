// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <glm/vec3.hpp>

namespace photic {

/// What ends the waves at an open side of the domain.
enum class WaveAbsorber {
    Pml,     ///< a perfectly matched layer of one block (8 cells), before a mirror on x and y: waves along it stay
             ///< straight
    Sponge,  ///< damping that grows through a band of cells [Mercier 2014, section 4]
    Rigid    ///< phi = 0 beyond the last cell: everything is reflected
};

/// Memory variables of a convolutional perfectly matched layer over the 8 cells of a block, counted outwards.
///
/// d/dx becomes d/dx + psi with psi(n) = b psi(n-1) + a d/dx phi(n), and the same once more for the second derivative
/// (R. Pasalic and R. McGarry, "Convolutional perfectly matched layer for isotropic and anisotropic acoustic wave
/// equations", SEG 2010; D. Komatitsch and R. Martin, Geophysics 72, 2007). psi lies between the cells, and the
/// fourth-order second difference is split exactly, delta- M delta+ with M = 1 - h^2/12 delta+ delta-, so that psi and
/// the plain part see one operator: with differences that do not match, the layer grows waves after some thousand
/// steps.
struct PmlTable {
    std::array<float, 8> a{}, b{};            ///< at the cells
    std::array<float, 8> a_half{}, b_half{};  ///< halfway to the next one outwards
};

/// @param spacing    of the cells across the layer
/// @param frequency  angular frequency around which the layer absorbs best
PmlTable pmlTable(double spacing, double speed, double dt, double frequency);

/// gamma dt of phi_tt + 2 gamma phi_t at `depth` cells into a sponge of `width` cells; grows with the square of the
/// depth.
double spongeDamping(double depth, double width, double spacing, double speed, double dt);

}  // namespace photic
