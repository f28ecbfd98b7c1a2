// SPDX-License-Identifier: Apache-2.0
#include "photic/index_volume.h"

#include <algorithm>
#include <cmath>

#include "runtime/src/index_volume_data.h"

namespace photic::runtime {
namespace {

/// Values and slopes of the four B-splines that reach the place t, 0 to 1, between the second and the third node.
struct SplineWeights {
    double value[4], slope[4];
};
SplineWeights weightsAt(double t) {
    const double u = 1 - t, t2 = t * t, u2 = u * u;
    return {{u2 * u / 6, (4 - 6 * t2 + 3 * t2 * t) / 6, (4 - 6 * u2 + 3 * u2 * u) / 6, t2 * t / 6},
            {-u2 / 2, (3 * t - 4) * t / 2, (4 - 3 * u) * u / 2, t2 / 2}};
}

/// The spline and its slopes per node, at a place in nodes.
struct SplineValue {
    double value = 0;
    Double3 slope{0, 0, 0};
};
SplineValue splineAt(const IndexVolumeData& data, const std::vector<float>& coefficients, const Double3& node) {
    int first[3];
    SplineWeights w[3];
    for (std::size_t a = 0; a < 3; ++a) {
        const double inside = std::clamp(node[a], 1.0, data.count[a] - 2.0);
        const int cell = std::min(static_cast<int>(inside), data.count[a] - 3);
        first[a] = cell - 1;
        w[a] = weightsAt(inside - cell);
        // Beyond the last places that a spline knows it goes on as it is.
        if (inside != node[a]) std::fill_n(w[a].slope, 4, 0.0);
    }
    SplineValue out;
    for (int k = 0; k < 4; ++k) {
        double value = 0, dx = 0, dy = 0;
        for (int j = 0; j < 4; ++j) {
            const float* row = &coefficients[data.flat(first[0], first[1] + j, first[2] + k)];
            double v = 0, d = 0;
            for (int i = 0; i < 4; ++i) v += w[0].value[i] * double(row[i]), d += w[0].slope[i] * double(row[i]);
            value += w[1].value[j] * v, dx += w[1].value[j] * d, dy += w[1].slope[j] * v;
        }
        out.value += w[2].value[k] * value;
        out.slope[0] += w[2].value[k] * dx, out.slope[1] += w[2].value[k] * dy, out.slope[2] += w[2].slope[k] * value;
    }
    return out;
}

/// Trilinear between nodes. @param value  of a node's element, a channel
template <std::size_t Channels, class Element, class Value>
std::array<double, Channels> trilinear(const IndexVolumeData& data, const std::vector<Element>& values,
                                       const Double3& node, const Value& value) {
    int low[3];
    double t[3];
    for (std::size_t a = 0; a < 3; ++a) {
        const double inside = std::clamp(node[a], 0.0, data.count[a] - 1.0);
        low[a] = std::min(static_cast<int>(inside), data.count[a] - 2), t[a] = inside - low[a];
    }
    std::array<double, Channels> out{};
    for (int corner = 0; corner < 8; ++corner) {
        const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
        const double weight = (x ? t[0] : 1 - t[0]) * (y ? t[1] : 1 - t[1]) * (z ? t[2] : 1 - t[2]);
        const Element& element = values[data.flat(low[0] + x, low[1] + y, low[2] + z)];
        for (std::size_t c = 0; c < Channels; ++c) out[c] += weight * value(element[c]);
    }
    return out;
}
std::array<double, 4> halvesAt(const IndexVolumeData& data, const std::vector<Half4>& values, const Double3& node) {
    return trilinear<4>(data, values, node, [](std::uint16_t half) { return double(floatOfHalf(half)); });
}

bool holds(const IndexVolumeData& data, const Double3& node) {
    for (std::size_t a = 0; a < 3; ++a)
        if (!(node[a] >= data.box_low[a] && node[a] <= data.box_high[a])) return false;
    return data.count[0] > 0;
}

}  // namespace

IndexVolume::IndexVolume() : data_(std::make_shared<IndexVolumeData>()) {}

const std::string& IndexVolume::name() const { return data_->name; }
bool IndexVolume::disperses() const {
    if (data_->hasSamples() || !data_->shape) return !data_->spline[1].empty();
    const auto& n = data_->shape->index;
    return n[0] != n[1] || n[0] != n[2];
}
IndexShape IndexVolume::shape() const {
    if (!data_->shape) return IndexShape::Samples;
    return data_->shape->kind == SharpShape::Kind::Ball ? IndexShape::Ball : IndexShape::Mesh;
}
std::size_t IndexVolume::triangles() const { return data_->shape ? data_->shape->triangles.size() : 0; }
bool IndexVolume::attenuates() const {
    const auto& s = data_->scattering;
    return !data_->attenuation.empty() || s[0] > 0 || s[1] > 0 || s[2] > 0;
}
bool IndexVolume::shines() const { return !data_->glow.empty(); }
bool IndexVolume::reflects() const {
    const auto& a = data_->albedo;
    return !data_->coat.empty() || a[0] > 0 || a[1] > 0 || a[2] > 0 || data_->roughness > 0;
}
bool IndexVolume::sharpSides() const { return data_->sharp_sides; }
std::array<int, 3> IndexVolume::nodes() const { return data_->count; }

Vec3 IndexVolume::node(double i, double j, double k) const {
    const Double3 p = multiply(data_->transform.world_from_index, {i, j, k});
    const Double3& o = data_->transform.origin_world;
    return {p[0] + o[0], p[1] + o[1], p[2] + o[2]};
}

void IndexVolume::box(Vec3& low, Vec3& high) const {
    low = {data_->box_low[0], data_->box_low[1], data_->box_low[2]};
    high = {data_->box_high[0], data_->box_high[1], data_->box_high[2]};
}

std::uint64_t IndexVolume::bytes() const {
    std::uint64_t sum =
        (data_->attenuation.size() + data_->glow.size()) * sizeof(Half4) + data_->faces.size() + 3 * data_->coat.size();
    for (const auto& channel : data_->spline) sum += channel.size() * sizeof(float);
    return sum + (data_->shape ? data_->shape->bytes() : 0);
}

Refraction IndexVolume::at(const Vec3& world, int channel) const {
    Refraction out;
    const Double3 node = data_->transform.indexOf({world.x, world.y, world.z});
    if (!holds(*data_, node)) return out;
    const auto c = static_cast<std::size_t>(disperses() ? std::clamp(channel, 0, 2) : 0);
    const SplineValue v = splineAt(*data_, data_->spline[c], node);
    out.half_square += v.value;
    // The gradient is a covector: by the transpose of index_from_world.
    const Matrix3& m = data_->transform.index_from_world;
    out.gradient = {m[0] * v.slope[0] + m[3] * v.slope[1] + m[6] * v.slope[2],
                    m[1] * v.slope[0] + m[4] * v.slope[1] + m[7] * v.slope[2],
                    m[2] * v.slope[0] + m[5] * v.slope[1] + m[8] * v.slope[2]};
    return out;
}

Attenuation IndexVolume::attenuation(const Vec3& world) const {
    Attenuation out;
    const Double3 node = data_->transform.indexOf({world.x, world.y, world.z});
    if (!holds(*data_, node)) return out;
    double there = 1;
    if (!data_->attenuation.empty()) {
        const auto v = halvesAt(*data_, data_->attenuation, node);
        out.absorption = {v[0], v[1], v[2]};
        there = v[3];
    }
    const auto& s = data_->scattering;
    out.scattering = {there * double(s[0]), there * double(s[1]), there * double(s[2])};
    out.anisotropy = double(data_->anisotropy);
    if (shines()) {
        const auto v = halvesAt(*data_, data_->glow, node);
        out.emission = {v[0], v[1], v[2]};
        out.anisotropy = v[3];
    }
    if (!data_->faces.empty()) {
        const auto nearest = [&](std::size_t a) {
            return std::clamp(static_cast<int>(std::lround(node[a])), 0, data_->count[a] - 1);
        };
        out.face = data_->faces[data_->flat(nearest(0), nearest(1), nearest(2))] >= 128;
    }
    return out;
}

FaceReflection IndexVolume::faceReflection(const Vec3& world) const {
    FaceReflection out;
    const Double3 node = data_->transform.indexOf({world.x, world.y, world.z});
    if (!holds(*data_, node)) return out;
    out.albedo = {double(data_->albedo[0]), double(data_->albedo[1]), double(data_->albedo[2])};
    if (!data_->coat.empty()) {
        const auto v = trilinear<3>(*data_, data_->coat, node, [](std::uint8_t of255) { return of255 / 255.0; });
        out.albedo = {v[0], v[1], v[2]};
    }
    out.roughness = double(data_->roughness);
    return out;
}

}  // namespace photic::runtime
