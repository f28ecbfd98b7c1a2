// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/wave_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <utility>

#include "bake/scene/vector_clones.h"

namespace photic {
namespace {

constexpr std::size_t kBlock = 64;

class FlatField final : public HeightField {
public:
    explicit FlatField(double z) : z_(z) {}
    SurfacePoint at(glm::dvec2 uv) const override { return {{uv.x, uv.y, z_}, {0, 0, 1}}; }
    void row(glm::dvec2 start, double step, std::size_t count, SurfaceRow& out) const override {
        out.resize(count);
        Patch everywhere_beyond;
        everywhere_beyond.outside_z = z_;
        fillBeyond(everywhere_beyond, start, step, {}, out);
    }
    double minZ() const override { return z_; }
    double maxZ() const override { return z_; }
    double featureSize() const override { return std::numeric_limits<double>::infinity(); }

private:
    double z_;
};

/// Cosine and sine of j * angle for j in [0, 64).
struct RotationTable {
    std::array<double, kBlock> cosine, sine;

    /// Products of six exact rotations (by 1, 2, 4 ... 32 steps): rounding grows with the number of factors only.
    explicit RotationTable(double angle) {
        cosine[0] = 1, sine[0] = 0;
        for (std::size_t span = 1; span < kBlock; span *= 2) {
            const double c = std::cos(angle * static_cast<double>(span)),
                         s = std::sin(angle * static_cast<double>(span));
            for (std::size_t j = 0; j < span; ++j) {
                cosine[span + j] = cosine[j] * c - sine[j] * s;
                sine[span + j] = sine[j] * c + cosine[j] * s;
            }
        }
    }
};

/// Adds one harmonic over a block by the addition theorem: no chain from point to point, so the lanes are free.
/// z += a sin(base + j angle); nx -= kx a cos(...), ny -= ky a cos(...).
PHOTIC_VECTOR_CLONES
void addHarmonic(const double* table_cos, const double* table_sin, double a_sin, double a_cos, double kx, double ky,
                 std::size_t count, double* __restrict z, double* __restrict nx, double* __restrict ny) {
    for (std::size_t j = 0; j < count; ++j) {
        const double s = a_sin * table_cos[j] + a_cos * table_sin[j];
        const double c = a_cos * table_cos[j] - a_sin * table_sin[j];
        z[j] += s;
        nx[j] -= kx * c;
        ny[j] -= ky * c;
    }
}

class WaveField final : public HeightField {
public:
    WaveField(std::vector<Wave> waves, const glm::dvec3& center, const Patch& patch) : center_(center), patch_(patch) {
        double height = 0;
        for (const Wave& wave : waves) {
            if (wave.amplitude == 0) continue;
            const glm::dvec2 k = 2 * std::numbers::pi / wave.wavelength * glm::normalize(wave.direction);
            harmonics_.push_back({wave.amplitude, k, wave.phase});
            height += std::fabs(wave.amplitude);
            feature_size_ = std::min(feature_size_, wave.wavelength / 8);
        }
        min_z_ = center.z - height, max_z_ = center.z + height;
        if (patch.bounded()) min_z_ = std::min(min_z_, patch.outside_z), max_z_ = std::max(max_z_, patch.outside_z);
    }

    SurfacePoint at(glm::dvec2 uv) const override {
        if (!patch_.contains(uv)) return patch_.beyond(uv);
        const glm::dvec2 p = uv - glm::dvec2(center_);
        SurfacePoint out{{uv.x, uv.y, center_.z}, {0, 0, 1}};
        for (const Harmonic& wave : harmonics_) {
            const double argument = glm::dot(wave.k, p) + wave.phase;
            const double slope = wave.amplitude * std::cos(argument);
            out.position.z += wave.amplitude * std::sin(argument);
            out.normal.x -= wave.k.x * slope, out.normal.y -= wave.k.y * slope;
        }
        return out;
    }

    void row(glm::dvec2 start, double step, std::size_t count, SurfaceRow& out) const override {
        if (!(step > 0)) return HeightField::row(start, step, count, out);
        out.resize(count);
        const RowRange range = rowInside(patch_, start, step, count);
        fillBeyond(patch_, start, step, range, out);
        for (std::size_t i = range.first; i < range.last; ++i) {
            out.px[i] = start.x + step * static_cast<double>(i), out.py[i] = start.y, out.pz[i] = center_.z;
            out.nx[i] = 0, out.ny[i] = 0, out.nz[i] = 1;
        }
        for (const Harmonic& wave : harmonics_) {
            const RotationTable table(wave.k.x * step);
            // Each block starts from an exact sine: errors do not add up along the row.
            for (std::size_t i = range.first; i < range.last; i += kBlock) {
                const double base = wave.k.x * (out.px[i] - center_.x) + wave.k.y * (start.y - center_.y) + wave.phase;
                addHarmonic(table.cosine.data(), table.sine.data(), wave.amplitude * std::sin(base),
                            wave.amplitude * std::cos(base), wave.k.x, wave.k.y, std::min(kBlock, range.last - i),
                            &out.pz[i], &out.nx[i], &out.ny[i]);
            }
        }
    }

    double minZ() const override { return min_z_; }
    double maxZ() const override { return max_z_; }
    double featureSize() const override { return feature_size_; }

private:
    struct Harmonic {
        double amplitude;
        glm::dvec2 k;  // [rad/m]
        double phase;
    };
    std::vector<Harmonic> harmonics_;
    glm::dvec3 center_;
    Patch patch_;
    double min_z_ = 0, max_z_ = 0, feature_size_ = std::numeric_limits<double>::infinity();
};

}  // namespace

std::shared_ptr<const HeightField> makeFlatField(double z) { return std::make_shared<FlatField>(z); }

std::shared_ptr<const HeightField> makeWaveField(std::vector<Wave> waves, const glm::dvec3& center,
                                                 const Patch& patch) {
    return std::make_shared<WaveField>(std::move(waves), center, patch);
}

}  // namespace photic
