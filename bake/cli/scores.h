// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "bake/cli/json.h"

namespace photic::cli {

/// Chi-squared and z scores of a - b in units of b's standard error. A bias of a is either forgiven voxel by voxel (its
/// share of b is taken off the difference), or added to the standard error in quadrature, as an error of unknown sign.
class Scores {
public:
    /// @param bias  share of b
    /// @param most  voxels whose standard error is a larger share of b are left out
    Scores(double bias, double most) : bias_(bias), most_(most) {}

    void add(const glm::ivec3& voxel, double a, double b, double standard_error) {
        if (!(standard_error > 0) || standard_error > most_ * std::fabs(b)) return;
        const double beyond = std::max(0.0, std::fabs(a - b) - bias_ * std::fabs(b));
        const double z = beyond / standard_error;
        chi2_ += z * z, above3_ += z > 3 ? 1 : 0;
        if (voxels_.empty() || z > worst_) worst_ = z, worst_voxel_ = voxel;
        const double light = b != 0 ? std::fabs(b) : 1e-300;
        voxels_.push_back({(a - b) / light, standard_error / light});
    }

    glm::ivec3 worstVoxel() const { return worst_voxel_; }
    Json json() const {
        const double n = std::max<double>(1, static_cast<double>(voxels_.size()));
        return {{"voxels", voxels_.size()},
                {"bias_allowance", bias_},
                {"most_standard_error", std::isfinite(most_) ? Json(most_) : Json(nullptr)},
                {"chi2_per_voxel", chi2_ / n},
                {"chi2_per_voxel_without_allowance", chi2With(0)},
                {"chi2_per_voxel_in_quadrature", chi2With(bias_)},
                {"bias_in_quadrature", biasInQuadrature()},
                {"share_above_3", static_cast<double>(above3_) / n},
                {"worst_z", worst_}};
    }

private:
    struct Voxel {
        double difference, error;  ///< shares of b
    };

    /// chi^2/n where a may be off by a share of b, of either sign.
    double chi2With(double bias) const {
        double sum = 0;
        for (const Voxel& v : voxels_) {
            const double d = v.difference, s = v.error;
            sum += d * d / (s * s + bias * bias);
        }
        return sum / std::max<double>(1, static_cast<double>(voxels_.size()));
    }

    /// The bias that makes chi^2/n 1; 0 where noise alone explains all.
    double biasInQuadrature() const {
        if (chi2With(0) <= 1) return 0;
        double low = 0, high = 1e-6;
        while (chi2With(high) > 1 && high < 1e6) high *= 2;
        for (int i = 0; i < 40; ++i) (chi2With(0.5 * (low + high)) > 1 ? low : high) = 0.5 * (low + high);
        return high;
    }

    double bias_, most_;
    std::vector<Voxel> voxels_;
    std::int64_t above3_ = 0;
    double chi2_ = 0, worst_ = 0;
    glm::ivec3 worst_voxel_{0};
};

}  // namespace photic::cli
