// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "bake/scene/graded_index.h"

namespace photic {

/// How samples become the coefficients of a spline.
enum class SplineFit {
    Auto,     ///< through smooth samples, plain where neighbours are more than a quarter of the range apart
    Through,  ///< prefiltered: through the samples; for smooth fields, it rings at jumps
    Plain     ///< the samples themselves: blurs by 0.58 samples, never rings, and constant regions stay constant
};

/// n^2 / 2 as a cubic B-spline over an axis-aligned grid of nodes, with its own exact gradient; beyond the nodes it
/// goes on as at their rim. 4 bytes a node.
class SplineIndex {
public:
    struct Nodes {
        glm::dvec3 first_world{0};  ///< of node (0, 0, 0) [m]
        glm::dvec3 spacing{1};      ///< [m]
        glm::ivec3 count{0};        ///< at least 4 along each axis
    };
    /// @param half_square  n^2 / 2 at a place in the world; called from several threads
    /// @throws Error{Input} where it is no positive number, with the place, and for more than 2^30 nodes
    SplineIndex(const Nodes& nodes, const std::function<double(const glm::dvec3&)>& half_square, SplineFit fit);

    IndexSample at(const glm::dvec3& world) const;
    const Nodes& nodes() const { return nodes_; }
    /// Coefficients, x fastest.
    const float* coefficients() const { return coefficients_.data(); }
    /// Of the samples.
    double least() const { return least_; }
    double largest() const { return largest_; }
    /// What was done: not Auto.
    SplineFit fit() const { return fit_; }
    /// Largest step of the coefficients between neighbours in some layers of nodes across an axis, inclusive: how much
    /// n^2 / 2 may change from a node to the next there.
    double steepest(int axis, int first, int last) const;
    /// Largest step between neighbouring samples, as a share of the range; 0 without a range.
    double steepest() const { return steepest_; }
    std::int64_t bytes() const { return static_cast<std::int64_t>(coefficients_.size() * sizeof(float)); }

private:
    std::size_t flat(int x, int y, int z) const {
        return (static_cast<std::size_t>(z) * static_cast<std::size_t>(nodes_.count.y) + static_cast<std::size_t>(y)) *
                   static_cast<std::size_t>(nodes_.count.x) +
               static_cast<std::size_t>(x);
    }
    void sample(const std::function<double(const glm::dvec3&)>& half_square);
    void prefilter(int axis);

    Nodes nodes_;
    SplineFit fit_;
    std::vector<float> coefficients_;
    double least_ = 0, largest_ = 0, steepest_ = 0;
};

/// A spline as an index by itself, that fills the world. The spline must outlive it.
class SplineGradedIndex final : public GradedIndex {
public:
    explicit SplineGradedIndex(const SplineIndex& spline) : spline_(spline) {}
    IndexSample at(const glm::dvec3& world) const override { return spline_.at(world); }
    bool contains(const glm::dvec3&) const override { return true; }
    std::optional<WorldBox> bounds() const override { return {}; }

private:
    const SplineIndex& spline_;
};

/// Values and slopes of the four B-splines that reach the place t, 0..1, between the second and the third node.
struct CubicWeights {
    double value[4], slope[4];
};
CubicWeights cubicBSpline(double t);

}  // namespace photic
