// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/affine.h"

#include <cmath>
#include <utility>

namespace photic::runtime {

Affine Affine::of(const std::array<float, 16>& m) {
    Affine out;
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 3; ++column) out.matrix[3 * row + column] = double(m[4 * column + row]);
        out.shift[row] = double(m[12 + row]);
    }
    return out;
}

Double3 Affine::apply(const Double3& p) const {
    Double3 out = multiply(matrix, p);
    for (std::size_t a = 0; a < 3; ++a) out[a] += shift[a];
    return out;
}

Affine Affine::operator*(const Affine& first) const {
    Affine out;
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column) {
            double sum = 0;
            for (std::size_t k = 0; k < 3; ++k) sum += matrix[3 * row + k] * first.matrix[3 * k + column];
            out.matrix[3 * row + column] = sum;
        }
    out.shift = apply(first.shift);
    return out;
}

namespace {

/// Gauss and Jordan, the largest pivot first. @return false where there is no inverse
template <std::size_t kSize>
bool invert(std::array<double, kSize * kSize> m, std::array<double, kSize * kSize>& out) {
    out.fill(0);
    for (std::size_t i = 0; i < kSize; ++i) out[kSize * i + i] = 1;
    for (std::size_t c = 0; c < kSize; ++c) {
        std::size_t pivot = c;
        for (std::size_t r = c + 1; r < kSize; ++r)
            if (std::fabs(m[kSize * r + c]) > std::fabs(m[kSize * pivot + c])) pivot = r;
        const double value = m[kSize * pivot + c];
        if (!(std::fabs(value) > 1e-300) || !std::isfinite(value)) return false;
        for (std::size_t k = 0; k < kSize; ++k) {
            std::swap(m[kSize * c + k], m[kSize * pivot + k]), std::swap(out[kSize * c + k], out[kSize * pivot + k]);
            m[kSize * c + k] /= value, out[kSize * c + k] /= value;
        }
        for (std::size_t r = 0; r < kSize; ++r) {
            const double factor = r == c ? 0 : m[kSize * r + c];
            for (std::size_t k = 0; k < kSize && factor != 0; ++k)
                m[kSize * r + k] -= factor * m[kSize * c + k], out[kSize * r + k] -= factor * out[kSize * c + k];
        }
    }
    for (const double value : out)
        if (!std::isfinite(value)) return false;
    return true;
}

}  // namespace

std::optional<Affine> Affine::inverse() const {
    Affine out;
    if (!invert<3>(matrix, out.matrix)) return {};
    const Double3 back = multiply(out.matrix, shift);
    for (std::size_t a = 0; a < 3; ++a) {
        out.shift[a] = -back[a];
        if (!std::isfinite(out.shift[a])) return {};
    }
    return out;
}

std::optional<ClipMatrices> clipMatrices(const float* world_from_clip, const Double3& camera) {
    // By rows: the camera's place times the fourth row is taken off the first three.
    std::array<double, 16> place, clip;
    for (std::size_t row = 0; row < 4; ++row)
        for (std::size_t column = 0; column < 4; ++column) {
            const double w = double(world_from_clip[4 * column + 3]);
            place[4 * row + column] = double(world_from_clip[4 * column + row]) - (row < 3 ? camera[row] * w : 0.0);
        }
    if (!invert<4>(place, clip)) return {};
    ClipMatrices out;
    for (std::size_t row = 0; row < 4; ++row)
        for (std::size_t column = 0; column < 4; ++column) {
            out.place_from_clip[4 * column + row] = static_cast<float>(place[4 * row + column]);
            out.clip_from_place[4 * column + row] = static_cast<float>(clip[4 * row + column]);
        }
    return out;
}

}  // namespace photic::runtime
