// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace photic::cli {

/// How far values a_i are from references b_i: running sums, any number of channels.
class Difference {
public:
    /// @return true when this is the largest difference so far
    bool add(double a, double b) {
        const double d = std::fabs(a - b);
        sum_a_ += a, sum_b_ += b, sum_abs_b_ += std::fabs(b), sum_d_ += d, sum_d2_ += d * d;
        ++count_;
        if (!(d > worst_) && !std::isnan(d)) return false;
        worst_ = d, worst_a_ = a, worst_b_ = b;
        return true;
    }
    std::int64_t count() const { return count_; }
    /// sum |a - b| / sum |b|; infinite when only b is dark.
    double relativeL1() const { return ratio(sum_d_, sum_abs_b_); }
    /// sqrt(mean (a - b)^2) / mean |b|.
    double relativeL2() const { return ratio(std::sqrt(sum_d2_ * static_cast<double>(count_)), sum_abs_b_); }
    /// Largest |a - b|, absolute and over the mean of |b|.
    double worst() const { return worst_; }
    double relativeWorst() const { return ratio(worst_ * static_cast<double>(count_), sum_abs_b_); }
    double worstA() const { return worst_a_; }
    double worstB() const { return worst_b_; }
    /// sum a / sum b.
    double energyRatio() const { return sum_a_ == sum_b_ ? 1 : sum_a_ / sum_b_; }

private:
    static double ratio(double top, double bottom) { return top == 0 ? 0 : top / bottom; }

    std::int64_t count_ = 0;
    double sum_a_ = 0, sum_b_ = 0, sum_abs_b_ = 0, sum_d_ = 0, sum_d2_ = 0;
    double worst_ = 0, worst_a_ = 0, worst_b_ = 0;
};

}  // namespace photic::cli
