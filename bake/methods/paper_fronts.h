// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/mat3x3.hpp>
#include <vector>

#include "bake/field/light_field.h"
#include "bake/methods/wavefront.h"
#include "bake/methods/wavefront_sweep.h"

namespace photic {

/// n and its slopes on a grid of nodes, as [Ihrke et al. 2007, section 5.1] stores them: n is blurred by a Gaussian,
/// slopes are differences of neighbours, and both are looked up trilinearly. 16 bytes a node.
class PaperIndex {
public:
    struct Look {
        double n = 1;
        glm::dvec3 slope{0};  ///< [1/m]
    };
    /// @param samples  plain: its coefficients are n^2 / 2 at its nodes
    /// @param sigma    [nodes]
    PaperIndex(const SplineIndex& samples, double sigma);
    Look at(const glm::dvec3& world) const;
    /// How the slope changes with the place [1/m2]: of the trilinear look-up, so that it jumps from cell to cell.
    glm::dmat3 bendAt(const glm::dvec3& world) const;

private:
    struct Node {
        float n, x, y, z;
    };
    SplineIndex::Nodes nodes_;
    std::vector<Node> values_;
};

/// The light simulator of [Ihrke et al. 2007, sections 4.2 and 5.2], to reproduce and compare: patches of four
/// particles that go steps of equal time by Euler (eqs. 14 and 15), are quartered where they are wider than a voxel,
/// and are laid into the voxel of their middle with their power over their area (eqs. 17 and 18), where the one of
/// highest irradiance is kept. Patches that turn over, as beyond a caustic, are discarded, and those that hold too
/// little energy.
///
/// What the paper leaves open: steps are half a voxel in air; a patch is too faint below a thousandth of its launched
/// one's power. Light in a voxel is a sample of it: the path ledger does not close.
class PaperFronts {
public:
    static constexpr std::size_t kMostPatches = std::size_t{1} << 24;

    PaperFronts(const FrontSpace& space, const GridFrame& frame, double sigma, PatchArea area);

    /// Lays a launched front. Bitwise the same for any number of threads.
    /// @throws Error{Input} for more than kMostPatches patches; Error{Cancelled}
    void lay(const Front& launched, LightField& field, SweepTotals& totals, Monitor& monitor) const;

private:
    struct Patch;
    struct Step;
    bool inside(const glm::dvec3& world) const;
    Step move(Patch& patch, const LightField& field) const;
    void moveNeighbours(Patch& patch) const;
    static void quarter(const Patch& patch, std::vector<Patch>& out);
    static void note(const Patch& patch, const Step& step, LightField& field);

    const FrontSpace& space_;
    GridFrame frame_;
    PaperIndex index_;
    glm::dvec3 voxel_, low_, high_;  // [m]; of the space
    PatchArea area_;
    double time_ = 0;  // of a step [m of optical path]
};

}  // namespace photic
