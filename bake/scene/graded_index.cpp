// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/graded_index.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <numbers>

#include "bake/scene/index_volume.h"

namespace photic {
namespace {

constexpr IndexSample kAir{};

WorldBox ballBox(const glm::dvec3& center, double radius) { return {center - radius, center + radius}; }

class LuneburgLens final : public GradedIndex {
public:
    LuneburgLens(const glm::dvec3& center, double radius) : center_(center), radius_(radius) {}
    IndexSample at(const glm::dvec3& world) const override {
        const glm::dvec3 r = (world - center_) / radius_;
        const double squared = glm::dot(r, r);
        if (squared >= 1) return kAir;
        return {1 - 0.5 * squared, r * (-1 / radius_)};
    }
    bool contains(const glm::dvec3& world) const override { return glm::distance(world, center_) < radius_; }
    std::optional<WorldBox> bounds() const override { return ballBox(center_, radius_); }

private:
    glm::dvec3 center_;
    double radius_;
};

class FishEye final : public GradedIndex {
public:
    FishEye(const glm::dvec3& center, double n0, double scale, std::optional<double> radius)
        : center_(center), n0_(n0), scale_(scale), radius_(radius) {}
    IndexSample at(const glm::dvec3& world) const override {
        if (!contains(world)) return kAir;
        const glm::dvec3 r = (world - center_) / scale_;
        const double below = 1 + glm::dot(r, r), n = n0_ / below;
        return {0.5 * n * n, r * (-2 * n * n / (below * scale_))};
    }
    bool contains(const glm::dvec3& world) const override {
        return !radius_ || glm::distance(world, center_) < *radius_;
    }
    std::optional<WorldBox> bounds() const override {
        if (!radius_) return {};
        return ballBox(center_, *radius_);
    }

private:
    glm::dvec3 center_;
    double n0_, scale_;
    std::optional<double> radius_;
};

class Selfoc final : public GradedIndex {
public:
    explicit Selfoc(const SelfocRod& rod) : rod_(rod) {}
    IndexSample at(const glm::dvec3& world) const override {
        if (!contains(world)) return kAir;
        const glm::dvec3 across = acrossAxis(world);
        const double square = rod_.n0 * rod_.n0, g2 = rod_.g * rod_.g;
        // Far from the axis of a rod without rim the square would pass through 0: it ends as air.
        const double here = square * (1 - g2 * glm::dot(across, across));
        if (!rod_.radius && here <= 1) return kAir;
        return {0.5 * here, across * (-square * g2)};
    }
    bool contains(const glm::dvec3& world) const override {
        if (!rod_.radius) return true;
        const glm::dvec3 across = acrossAxis(world);
        return glm::dot(across, across) < *rod_.radius * *rod_.radius &&
               std::fabs(glm::dot(world - rod_.center, rod_.axis)) < 0.5 * rod_.length;
    }
    std::optional<WorldBox> bounds() const override {
        if (!rod_.radius) return {};
        glm::dvec3 half(0);
        for (int a = 0; a < 3; ++a)
            half[a] = 0.5 * rod_.length * std::fabs(rod_.axis[a]) +
                      *rod_.radius * std::sqrt(std::max(0.0, 1 - rod_.axis[a] * rod_.axis[a]));
        return WorldBox{rod_.center - half, rod_.center + half};
    }

private:
    glm::dvec3 acrossAxis(const glm::dvec3& world) const {
        const glm::dvec3 d = world - rod_.center;
        return d - glm::dot(d, rod_.axis) * rod_.axis;
    }
    SelfocRod rod_;
};

/// What may fill a box, or the world.
class Boxed : public GradedIndex {
public:
    explicit Boxed(std::optional<WorldBox> box) : box_(box) {}
    IndexSample at(const glm::dvec3& world) const final { return contains(world) ? inside(world) : kAir; }
    bool contains(const glm::dvec3& world) const final { return !box_ || box_->contains(world); }
    std::optional<WorldBox> bounds() const final { return box_; }

private:
    virtual IndexSample inside(const glm::dvec3& world) const = 0;
    std::optional<WorldBox> box_;
};

class LinearSquare final : public Boxed {
public:
    LinearSquare(const glm::dvec3& center, double n0, const glm::dvec3& slope, std::optional<WorldBox> box)
        : Boxed(box), center_(center), n0_(n0), slope_(slope) {}

private:
    IndexSample inside(const glm::dvec3& world) const override {
        return {0.5 * (n0_ * n0_ + glm::dot(slope_, world - center_)), 0.5 * slope_};
    }
    glm::dvec3 center_;
    double n0_;
    glm::dvec3 slope_;
};

class HotAirOverGround final : public Boxed {
public:
    HotAirOverGround(const HotAir& air, std::optional<WorldBox> box) : Boxed(box), air_(air) {}

private:
    IndexSample inside(const glm::dvec3& world) const override {
        const double up = world.z - air_.ground, heat = std::exp(-std::max(up, 0.0) / air_.height);
        const double n = air_.far_index - air_.drop * heat;
        return {0.5 * n * n, {0, 0, up > 0 ? n * air_.drop * heat / air_.height : 0.0}};
    }
    HotAir air_;
};

class Salt final : public Boxed {
public:
    Salt(const SaltLayers& layers, std::optional<WorldBox> box) : Boxed(box), layers_(layers) {}

private:
    IndexSample inside(const glm::dvec3& world) const override {
        const double k = 2 * std::numbers::pi / layers_.wavelength, x = k * world.x, y = 0.5 * k * world.y;
        const double level = layers_.level + layers_.amplitude * std::sin(x) * std::cos(y);
        const double t = std::tanh((world.z - level) / layers_.thickness);
        const double half = 0.5 * (layers_.n_above - layers_.n_below);
        const double n = 0.5 * (layers_.n_above + layers_.n_below) + half * t;
        const double dn = half * (1 - t * t) / layers_.thickness;
        const glm::dvec3 across(-layers_.amplitude * k * std::cos(x) * std::cos(y),
                                0.5 * layers_.amplitude * k * std::sin(x) * std::sin(y), 1);
        return {0.5 * n * n, n * dn * across};
    }
    SaltLayers layers_;
};

/// Samples from a file.
class SampledIndex final : public GradedIndex {
public:
    SampledIndex(std::shared_ptr<const IndexVolume> volume, const glm::dvec3& position, const glm::dmat3& axes)
        : volume_(std::move(volume)), position_(position), shape_from_world_(glm::inverse(axes)) {
        const glm::dvec3 last = glm::dvec3(volume_->size() - 1);
        glm::dmat3 sample_axes;
        for (int a = 0; a < 3; ++a) {
            glm::dvec3 one(0);
            one[a] = 1;
            sample_axes[a] = volume_->place(one) - volume_->place(glm::dvec3(0));
        }
        sample_from_shape_ = glm::inverse(sample_axes), first_ = volume_->place(glm::dvec3(0));
        bounds_.min = glm::dvec3(std::numeric_limits<double>::infinity()), bounds_.max = -bounds_.min;
        for (int corner = 0; corner < 8; ++corner) {
            glm::dvec3 sample;
            for (int a = 0; a < 3; ++a) sample[a] = corner >> a & 1 ? last[a] + 0.5 : -0.5;
            const glm::dvec3 p = position + axes * volume_->place(sample);
            bounds_.min = glm::min(bounds_.min, p), bounds_.max = glm::max(bounds_.max, p);
        }
        // Half a sample's width, for the gradient.
        step_ = 0.25 * (glm::length(axes * sample_axes[0]) + glm::length(axes * sample_axes[1]));
    }
    IndexSample at(const glm::dvec3& world) const override {
        if (!contains(world)) return kAir;
        glm::dvec3 gradient;
        for (int a = 0; a < 3; ++a) {
            glm::dvec3 ahead = world, behind = world;
            ahead[a] += step_, behind[a] -= step_;
            gradient[a] = (halfSquare(ahead) - halfSquare(behind)) / (2 * step_);
        }
        return {halfSquare(world), gradient};
    }
    double halfSquareAt(const glm::dvec3& world) const override {
        return contains(world) ? halfSquare(world) : kAir.half_square;
    }
    bool contains(const glm::dvec3& world) const override {
        const glm::dvec3 s = sample_from_shape_ * (shape_from_world_ * (world - position_) - first_);
        for (int a = 0; a < 3; ++a)
            if (!(s[a] >= -0.5 && s[a] <= volume_->size()[a] - 0.5)) return false;
        return volume_->holds(s);
    }
    std::optional<WorldBox> bounds() const override { return bounds_; }
    std::optional<SamplePlaces> samples() const override {
        return SamplePlaces{glm::inverse(sample_from_shape_ * shape_from_world_),
                            position_ + glm::inverse(shape_from_world_) * first_, volume_->size()};
    }

private:
    double halfSquare(const glm::dvec3& world) const {
        const double n = volume_->at(shape_from_world_ * (world - position_));
        return 0.5 * n * n;
    }
    std::shared_ptr<const IndexVolume> volume_;
    glm::dvec3 position_;
    glm::dmat3 shape_from_world_, sample_from_shape_{1};
    glm::dvec3 first_{0};
    WorldBox bounds_;
    double step_ = 0;
};

}  // namespace

double GradedIndex::indexAt(const glm::dvec3& world) const { return std::sqrt(2 * at(world).half_square); }

std::shared_ptr<const GradedIndex> makeLuneburgLens(const glm::dvec3& center, double radius) {
    return std::make_shared<LuneburgLens>(center, radius);
}

std::shared_ptr<const GradedIndex> makeFishEye(const glm::dvec3& center, double n0, double scale,
                                               std::optional<double> radius) {
    return std::make_shared<FishEye>(center, n0, scale, radius);
}

std::shared_ptr<const GradedIndex> makeSelfocRod(const SelfocRod& rod) { return std::make_shared<Selfoc>(rod); }

std::shared_ptr<const GradedIndex> makeLinearSquare(const glm::dvec3& center, double n0, const glm::dvec3& slope,
                                                    std::optional<WorldBox> box) {
    return std::make_shared<LinearSquare>(center, n0, slope, box);
}

std::shared_ptr<const GradedIndex> makeHotAir(const HotAir& air, std::optional<WorldBox> box) {
    return std::make_shared<HotAirOverGround>(air, box);
}

std::shared_ptr<const GradedIndex> makeSaltLayers(const SaltLayers& layers, std::optional<WorldBox> box) {
    return std::make_shared<Salt>(layers, box);
}

std::shared_ptr<const GradedIndex> makeSampledIndex(std::shared_ptr<const IndexVolume> volume,
                                                    const glm::dvec3& position, const glm::dmat3& shape_axes) {
    return std::make_shared<SampledIndex>(std::move(volume), position, shape_axes);
}

}  // namespace photic
