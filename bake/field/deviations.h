// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace photic {

/// How far values are from a reference that is known up to a standard error: chi^2/n, and the bias that explains it.
///
/// A bias is an error of unknown sign and is added to the standard error in quadrature: as a share of each value, and
/// beside it as an amount that is the same for all, such as a share of the unfocused light.
class Deviations {
public:
    void add(double value, double reference, double standard_error) {
        const double size = reference != 0 ? std::fabs(reference) : 1e-300;
        voxels_.push_back({(value - reference) / size, standard_error / size, size});
    }

    std::size_t count() const { return voxels_.size(); }

    /// @param share   of each reference
    /// @param amount  in the values' unit
    /// @return chi^2/n; 0 of nothing
    double chi2(double share = 0, double amount = 0) const {
        double sum = 0;
        for (const Voxel& v : voxels_) {
            const double same = amount / v.size;
            sum += v.difference * v.difference / (v.error * v.error + share * share + same * same);
        }
        return sum / std::max<double>(1, static_cast<double>(voxels_.size()));
    }

    /// The share that makes chi^2/n 1; 0 where the standard error explains all.
    double bias() const {
        if (chi2() <= 1) return 0;
        double low = 0, high = 1e-6;
        while (chi2(high) > 1 && high < 1e6) high *= 2;
        for (int i = 0; i < 40; ++i) (chi2(0.5 * (low + high)) > 1 ? low : high) = 0.5 * (low + high);
        return high;
    }

private:
    struct Voxel {
        double difference, error;  ///< shares of the reference
        double size;               ///< of the reference
    };
    std::vector<Voxel> voxels_;
};

}  // namespace photic
