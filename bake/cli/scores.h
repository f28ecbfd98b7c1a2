// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>

#include "bake/cli/json.h"
#include "bake/field/deviations.h"

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
        if (deviations_.count() == 0 || z > worst_) worst_ = z, worst_voxel_ = voxel;
        deviations_.add(a, b, standard_error);
    }

    glm::ivec3 worstVoxel() const { return worst_voxel_; }
    Json json() const {
        const double n = std::max<double>(1, static_cast<double>(deviations_.count()));
        return {{"voxels", deviations_.count()},
                {"bias_allowance", bias_},
                {"most_standard_error", std::isfinite(most_) ? Json(most_) : Json(nullptr)},
                {"chi2_per_voxel", chi2_ / n},
                {"chi2_per_voxel_without_allowance", deviations_.chi2()},
                {"chi2_per_voxel_in_quadrature", deviations_.chi2(bias_)},
                {"bias_in_quadrature", deviations_.bias()},
                {"share_above_3", static_cast<double>(above3_) / n},
                {"worst_z", worst_}};
    }

private:
    double bias_, most_;
    Deviations deviations_;
    std::int64_t above3_ = 0;
    double chi2_ = 0, worst_ = 0;
    glm::ivec3 worst_voxel_{0};
};

}  // namespace photic::cli
