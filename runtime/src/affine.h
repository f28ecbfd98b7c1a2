// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "runtime/src/volume_data.h"

namespace photic::runtime {

/// p -> matrix * p + shift, in double.
struct Affine {
    Matrix3 matrix{1, 0, 0, 0, 1, 0, 0, 0, 1};
    Double3 shift{0, 0, 0};

    /// Of a matrix column by column.
    static Affine of(const std::array<float, 16>& m);
    Double3 apply(const Double3& p) const;
    Affine operator*(const Affine& first) const;
    /// Nothing where there is none, or where numbers are not finite.
    std::optional<Affine> inverse() const;
};

/// Between clip space and places relative to a camera, column by column.
struct ClipMatrices {
    std::array<float, 16> place_from_clip, clip_from_place;
};
/// Nothing where the matrix has no inverse. Through double: a camera may be far from the world's origin.
std::optional<ClipMatrices> clipMatrices(const float* world_from_clip, const Double3& camera);

}  // namespace photic::runtime
