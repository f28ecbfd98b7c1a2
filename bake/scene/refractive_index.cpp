// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/refractive_index.h"

#include <cmath>
#include <utility>

namespace photic {
namespace {

double inverseSquare(double wavelength_nm) {
    const double micrometres = wavelength_nm * 1e-3;
    return 1 / (micrometres * micrometres);
}

}  // namespace

RefractiveIndex::RefractiveIndex(double n) : terms_{n} {}

RefractiveIndex RefractiveIndex::channels(const glm::dvec3& n) {
    RefractiveIndex index;
    index.form_ = Form::Channels, index.terms_ = {n.x, n.y, n.z};
    return index;
}

RefractiveIndex RefractiveIndex::abbe(double n_d, double abbe) {
    // n_F - n_C = b (1/F^2 - 1/C^2).
    const double b = (n_d - 1) / abbe / (inverseSquare(kF_nm) - inverseSquare(kC_nm));
    RefractiveIndex index = cauchy({n_d - b * inverseSquare(kD_nm), b});
    index.form_ = Form::Abbe;
    return index;
}

RefractiveIndex RefractiveIndex::cauchy(std::vector<double> a) {
    RefractiveIndex index;
    index.form_ = Form::Cauchy, index.terms_ = std::move(a);
    return index;
}

RefractiveIndex RefractiveIndex::sellmeier(const glm::dvec3& b, const glm::dvec3& c) {
    RefractiveIndex index;
    index.form_ = Form::Sellmeier, index.terms_ = {b.x, b.y, b.z, c.x, c.y, c.z};
    return index;
}

double RefractiveIndex::at(double wavelength_nm) const {
    const double u = inverseSquare(wavelength_nm);
    switch (form_) {
        case Form::Constant:
            return terms_[0];
        case Form::Channels: {
            // u grows from red to blue.
            const double red = inverseSquare(kChannels_nm.x), green = inverseSquare(kChannels_nm.y),
                         blue = inverseSquare(kChannels_nm.z);
            if (u <= red) return terms_[0];
            if (u >= blue) return terms_[2];
            return u < green ? std::lerp(terms_[0], terms_[1], (u - red) / (green - red))
                             : std::lerp(terms_[1], terms_[2], (u - green) / (blue - green));
        }
        case Form::Abbe:
        case Form::Cauchy: {
            double n = 0;
            for (std::size_t i = terms_.size(); i-- > 0;) n = n * u + terms_[i];
            return n;
        }
        case Form::Sellmeier: {
            double squared = 1;
            for (std::size_t i = 0; i < 3; ++i) squared += terms_[i] / (1 - terms_[i + 3] * u);
            return std::sqrt(squared);
        }
    }
    return 1;
}

glm::dvec3 RefractiveIndex::atChannels() const { return {at(kChannels_nm.x), at(kChannels_nm.y), at(kChannels_nm.z)}; }

double RefractiveIndex::mean() const {
    return form_ == Form::Channels ? (terms_[0] + terms_[1] + terms_[2]) / 3 : at(kD_nm);
}

bool RefractiveIndex::disperses() const {
    const glm::dvec3 n = atChannels();
    return n.x != n.y || n.y != n.z;
}

}  // namespace photic
